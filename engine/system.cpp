#include "engine/system.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

#include "engine/check.h"
#include "engine/fluid/fluid.h"
#include "engine/geometry/manifold.h"
#include "engine/geometry/shape_bounds.h"

namespace feder {

DistanceView System::distance_view() const {
  return {distance.a.data(),      distance.b.data(),       distance.run.data(), distance.rest.data(),
          distance.spring.data(), distance.damping.data(), distance.batches()};
}

std::string System::row_name(int row) const {
  auto named = [&](const std::string& kind, int id, const int* ends, int count) {
    const auto label = static_cast<std::size_t>(id);
    if (id >= 0 && label < row_labels.size() && !row_labels[label].empty()) return row_labels[label];
    const int centres = places() - static_cast<int>(bodies.size());
    bool nodes_only = true;
    for (int i = 0; i < count; ++i) nodes_only = nodes_only && ends[i] < centres;
    std::string text = kind + " row " + std::to_string(id) + (nodes_only ? " (nodes " : " (");
    for (int i = 0; i < count; ++i) {
      if (ends[i] >= places()) continue;  // a spin: its centre was named
      text += i ? ", " : "";
      if (!nodes_only) text += ends[i] < centres ? "node " : "body ";
      text += std::to_string(ends[i] < centres ? ends[i] : ends[i] - centres);
    }
    return text + ")";
  };
  if (row < distance.size()) {
    const int pair[2] = {distance.a[row], distance.b[row]};
    return named("distance", distance.public_row[row], pair, 2);
  }
  std::string name = "row " + std::to_string(row);
  int first = distance.size();
  for_each_stencil_row_type(stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    const int end = first + Row::kRows * static_cast<int>(list.size());
    if (row >= first && row < end) {
      int id = -1;
      const int head = first + (row - first) / Row::kRows * Row::kRows;
      for (std::size_t i = 0; i < row_of_id.size(); ++i)
        if (row_of_id[i] == head) id = static_cast<int>(i);
      const Row& element = list[(row - first) / Row::kRows];
      name = named(Row::kName, id, element.nodes.data(), element.count());
    }
    first = end;
  });
  return name;
}

double System::memory(int row, double dt) const {
  const double d = stiffness[row];
  if (std::isinf(d)) return damping_time[row] / (dt + damping_time[row]);
  return damping[row] > 0.0 ? damping[row] / (dt * d + damping[row]) : 0.0;
}

std::string SystemBuilder::place(int node) const {
  return "node " + std::to_string(node);
}

Anchor SystemBuilder::add_particle(double mass, const Vector3d& position, const Vector3d& velocity,
                                   FreeMask free) {
  const int node = static_cast<int>(nodes_.size());
  require_positive(place(node), "mass", mass, "kg");
  if (!std::isfinite(1.0 / mass))
    fail_input(place(node), "mass", mass, "kg", "a mass whose inverse is finite");
  for (int c = 0; c < 3; ++c) {
    require_finite(place(node), "position", position[c], "m");
    require_finite(place(node), "velocity", velocity[c], "m/s");
    if (!(free >> c & 1) && velocity[c] != 0.0)
      fail_input(place(node), "velocity", velocity[c], "m/s", "0 along a masked coordinate");
  }
  if (free > kFree) fail_input(place(node), "free mask", free, "", "a value from 0 to 7");
  nodes_.push_back({mass, position, velocity, free});
  return {node};
}

Anchor SystemBuilder::add_world_point(const Vector3d& position) {
  const int node = static_cast<int>(nodes_.size());
  for (int c = 0; c < 3; ++c) require_finite(place(node), "position", position[c], "m");
  nodes_.push_back({0.0, position, Vector3d::Zero(), kPinned});
  return {node};
}

Anchor SystemBuilder::add_moving_point(const Motion& motion) {
  const int node = static_cast<int>(nodes_.size());
  if (!motion.position || !motion.velocity || !motion.acceleration)
    throw InputError(place(node) + ": motion, expected position, velocity and acceleration");
  drives_.push_back({node, motion});
  return add_world_point(motion.position(0.0));
}

Anchor SystemBuilder::add_dial(const Target& target) {
  if (!target.value || !target.rate || !target.acceleration)
    throw InputError(place(static_cast<int>(nodes_.size())) +
                     ": target, expected value, rate and acceleration");
  auto along_x = [](const std::function<double(double)>& f) {
    return [f](double t) { return Vector3d(f(t), 0.0, 0.0); };
  };
  const Anchor dial =
      add_moving_point({along_x(target.value), along_x(target.rate), along_x(target.acceleration)});
  drives_.back().dial = true;
  nodes_.back().dial = true;
  return dial;
}

int SystemBuilder::require_dial(Anchor anchor, const std::string& where) {
  const int node = require_node(anchor, where);
  if (!nodes_[node].dial)
    fail_input(where, "dial", node, "", "a dial of its own, made by add_dial and used by one row");
  nodes_[node].dial = false;  // taken
  return node;
}

namespace {
void require_rotation(const std::string& where, const std::string& name, const Matrix3d& R) {
  const double defect = (R.transpose() * R - Matrix3d::Identity()).norm();
  if (!(defect <= 1e-9) || !(R.determinant() > 0.0))
    fail_input(where, name + "'s distance from a rotation", defect, "", "a proper rotation");
}
}  // namespace

Anchor SystemBuilder::add_body(const MassProperties& properties, const BodyStart& start) {
  const int id = static_cast<int>(bodies_.size());
  const std::string where = "body " + std::to_string(id);
  check_inertia(where, properties);
  for (int c = 0; c < 3; ++c) {
    require_finite(where, "position", start.position[c], "m");
    require_finite(where, "velocity", start.velocity[c], "m/s");
    require_finite(where, "angular velocity", start.angular_velocity[c], "rad/s");
    if (!(start.free >> c & 1) && start.velocity[c] != 0.0)
      fail_input(where, "velocity", start.velocity[c], "m/s", "0 along a masked coordinate");
  }
  if (start.free > kFree) fail_input(where, "free mask", start.free, "", "a value from 0 to 7");
  if (start.free_spin > kFree)
    fail_input(where, "free mask of the spin", start.free_spin, "", "a value from 0 to 7");
  require_rotation(where, "orientation", start.orientation);
  bodies_.push_back({properties, start});
  return {.body = id};
}

Anchor SystemBuilder::anchor_at(const Anchor& body, const Vector3d& place) {
  if (body.body < 0) return body.node < 0 ? add_world_point(place) : Anchor{require_node(body, "anchor")};
  const BodyStart& start = bodies_[require_anchor(body, "anchor")].start;
  return {.body = body.body, .point = start.orientation.transpose() * (place - start.position)};
}

Vector3d SystemBuilder::direction_in(const Anchor& body, const Vector3d& direction) const {
  if (body.body < 0) return direction;
  return bodies_[require_anchor(body, "direction")].start.orientation.transpose() * direction;
}

int SystemBuilder::require_anchor(const Anchor& anchor, const std::string& where) const {
  if (anchor.body < 0) return require_node(anchor, where);
  if (anchor.body >= static_cast<int>(bodies_.size()))
    fail_input(where, "body", anchor.body, "",
               "an existing body, 0 to " + std::to_string(static_cast<int>(bodies_.size()) - 1));
  return anchor.body;
}

int SystemBuilder::require_node(Anchor anchor, const std::string& where) const {
  if (anchor.body >= 0) fail_input(where, "body", anchor.body, "", "a particle or world point here");
  if (anchor.node < 0 || anchor.node >= static_cast<int>(nodes_.size()))
    fail_input(where, "node", anchor.node, "", "an existing node, 0 to " + std::to_string(nodes_.size() - 1));
  return anchor.node;
}

void SystemBuilder::check_material(const std::string& where, const Material& material, const char* unit,
                                   bool may_be_rigid) const {
  const double d = material.stiffness;
  const bool rigid = d == std::numeric_limits<double>::infinity();
  if (rigid && !may_be_rigid)
    fail_input(where, "stiffness", d, unit, "a finite value: this row type has no rigid form");
  if (!rigid) require_non_negative(where, "stiffness", d, unit);
  require_non_negative(where, "damping time", material.damping_time, "s");
  require_non_negative(where, "damping", material.damping, "kg/s or kg m^2/s");
  if (rigid && material.damping > 0.0)
    fail_input(where, "damping", material.damping, "kg/s or kg m^2/s", "0 where the stiffness is infinite");
}

int SystemBuilder::add_distance(Anchor a, Anchor b, const Material& material, double rest) {
  const int id = static_cast<int>(ids_.size());
  const std::string where = "row " + std::to_string(id) + " (distance)";
  const int i = require_node(a, where), j = require_node(b, where);
  if (i == j) fail_input(where, "node", i, "", "two different nodes");
  check_material(where, material, "N/m", true);
  require_finite(where, "rest length", rest, "m");
  const double length = (nodes_[j].position - nodes_[i].position).norm();
  if (rest < 0.0) rest = length;
  require_finite(where, "rest length", rest, "m");
  if (std::isinf(material.stiffness) && rest == 0.0)
    fail_input(where, "rest length", rest, "m", "a rod longer than 0: it needs a direction");
  distance_.push_back({i, j, rest, material.stiffness, material.damping_time, material.damping});
  ids_.push_back({-1, static_cast<int>(distance_.size()) - 1});
  return id;
}

void SystemBuilder::add_law_spring(const LawSpring& spring) {
  const std::string where = "law spring " + std::to_string(law_springs_.size());
  const int a = require_anchor(spring.a, where), b = require_anchor(spring.b, where);
  if (a == b && (spring.a.body >= 0) == (spring.b.body >= 0))
    fail_input(where, spring.a.body >= 0 ? "body" : "node", a, "", "two different ones");
  spring.check(where);
  law_springs_.push_back(spring);
}

int SystemBuilder::add_collider(const Anchor& at, const Shape& shape, const Surface& surface, int group,
                                const Matrix3d& rotation) {
  const std::string where = "collider " + std::to_string(colliders_.size());
  (void)require_anchor(at, where);
  for (int c = 0; c < 3; ++c) require_finite(where, "point", at.point[c], "m");
  check_shape(where, shape);
  require_non_negative(where, "friction", surface.friction, "");
  if (!(surface.restitution >= 0.0 && surface.restitution <= 1.0))
    fail_input(where, "restitution", surface.restitution, "", "a value from 0 to 1");
  require_rotation(where, "rotation", rotation);
  colliders_.push_back({at, shape, surface, rotation, group});
  return static_cast<int>(colliders_.size()) - 1;
}

void SystemBuilder::label_row(int id, std::string label) {
  FEDER_CHECK(id >= 0 && id < static_cast<int>(ids_.size()), "label_row: no row with this id");
  labels_.resize(ids_.size());
  labels_[static_cast<std::size_t>(id)] = std::move(label);
}

void SystemBuilder::add_constant_force(Anchor at, const Vector3d& force) {
  const int id = require_anchor(at, "constant force");
  const std::string where = "constant force on " + (at.body < 0 ? place(id) : "body " + std::to_string(id));
  for (int c = 0; c < 3; ++c) require_finite(where, "force", force[c], "N");
  constant_.emplace_back(at, force);
}

void SystemBuilder::add_constant_torque(Anchor at, const Vector3d& torque) {
  if (at.body < 0) fail_input("constant torque", "node", at.node, "", "a body: particles do not turn");
  const int body = require_anchor(at, "constant torque");
  for (int c = 0; c < 3; ++c)
    require_finite("constant torque on body " + std::to_string(body), "torque", torque[c], "N m");
  bodies_[body].torque += torque;
}

namespace {

// Stencils of the row types and of the user force, with their places in the Jacobian and matrix pools.
void lay_out_stencils(System& s) {
  auto append = [&](const int* nodes, int count, int rows) {
    s.stencils.push_back(
        {s.rows, rows, static_cast<int>(s.stencil_nodes.size()), count, s.jacobian_size, s.matrix_size});
    s.stencil_nodes.insert(s.stencil_nodes.end(), nodes, nodes + count);
    s.jacobian_size += rows * 3 * count;
    s.matrix_size += 9 * count * count;
    s.rows += rows;
  };
  s.rows = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    for (const auto& row : list) append(row.nodes.data(), row.count(), row.kRows);
  });
  bool has_fixed = false;
  for (const Collider& collider : s.colliders) has_fixed = has_fixed || collider.fixed;
  for (const Collider& collider : s.colliders) {
    const bool held = has_fixed && collider.at.body < 0 && !collider.fixed;
    s.contact_stencil.push_back(held ? static_cast<int>(s.stencils.size()) : -1);
    if (held) append(&collider.place.node, 1, 0);
  }
  for (const LawSpring& spring : s.law_springs) append(spring.nodes.data(), spring.count(), 0);
  for (const std::vector<int>& stencil : s.forces.user.stencils)
    append(stencil.data(), static_cast<int>(stencil.size()), 0);
}

void collect_row_materials(System& s) {
  s.stiffness = VectorXd::Zero(s.rows);
  s.damping_time = s.damping = VectorXd::Zero(s.rows);
  for (int k = 0; k < s.distance.size(); ++k) {
    s.stiffness[k] = s.distance.stiffness[k];
    s.damping_time[k] = s.distance.damping_time[k];
    s.damping[k] = s.distance.damping[k];
    if (!s.distance.active(k)) s.inactive_distance.push_back(k);
  }
  int row = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    for (const auto& element : list)
      for (int i = 0; i < element.kRows; ++i, ++row) {
        s.stiffness[row] = element.stiffness;
        s.damping_time[row] = element.damping_time;
        if (std::isinf(element.stiffness)) continue;
        s.damping[row] = element.stiffness * element.damping_time;
        if constexpr (requires { element.damping; }) s.damping[row] += element.damping;
      }
  });
  for (int k = 0; k < s.rows; ++k) s.active_rows += s.active(k);
  s.has_hard_rows = s.stiffness.size() > 0 && std::isinf(s.stiffness.maxCoeff());
  s.has_damping =
      (s.damping.array() > 0.0).any() || (s.stiffness.array() > 0.0 && s.damping_time.array() > 0.0).any();
}

// Colliders that would meet need a routine for their pair of shapes.
void check_pairs(const std::vector<Collider>& colliders) {
  std::map<std::tuple<std::size_t, bool, int>, std::pair<int, int>> kinds;  // the first and last of each
  for (int i = 0; i < static_cast<int>(colliders.size()); ++i)
    kinds.try_emplace({colliders[i].shape.index(), colliders[i].fixed, colliders[i].group}, i, i)
        .first->second.second = i;
  for (const auto& [kind_a, a] : kinds)
    for (const auto& [kind_b, b] : kinds) {
      const int i = a.first, j = b.second;
      const Collider &first = colliders[i], &second = colliders[j];
      if (i == j || (first.fixed && second.fixed) || (first.group != 0 && first.group == second.group))
        continue;
      if (const std::string why = refuse_pair(first.shape, second.shape); !why.empty())
        throw InputError("colliders " + std::to_string(i) + " and " + std::to_string(j) + ": " + why);
    }
}

// Principal axes; those given where they are principal to rounding, so that masks mean what the user sees.
PrincipalAxes axes_of(const MassProperties& p) {
  const Matrix3d& I = p.inertia;
  if ((I - Matrix3d(I.diagonal().asDiagonal())).cwiseAbs().maxCoeff() <= 1e-14 * I.trace())
    return {Matrix3d::Identity(), I.diagonal()};
  return principal_axes(p);
}

}  // namespace

// Bodies take the nodes after the particles: centres first, then spins.
void SystemBuilder::build_bodies(Built& out) const {
  System& s = out.system;
  const int particles = static_cast<int>(nodes_.size()), count = static_cast<int>(bodies_.size());
  for (int i = 0; i < count; ++i) {
    const auto& [properties, start, torque] = bodies_[i];
    const PrincipalAxes principal = axes_of(properties);
    const Body b{particles + i,
                 particles + count + i,
                 3 * (particles + count) + 4 * i,
                 principal.moments,
                 principal.axes,
                 properties.centre,
                 torque};
    s.forces.has_torques = s.forces.has_torques || !torque.isZero(0.0);
    s.bodies.push_back(b);
    const Matrix3d R = start.orientation * principal.axes;
    const Eigen::Quaterniond quaternion(R);
    out.state.q.segment<3>(3 * b.centre) = start.position + start.orientation * properties.centre;
    out.state.q.segment<4>(b.quaternion) << quaternion.w(), quaternion.x(), quaternion.y(), quaternion.z();
    normalise(out.state.q.data() + b.quaternion);
    out.state.v.segment<3>(3 * b.centre) = start.velocity;
    const Vector3d w = R.transpose() * start.angular_velocity;
    s.mass[b.centre] = properties.mass;
    for (int c = 0; c < 3; ++c) {
      s.inertia[3 * b.centre + c] = properties.mass;
      s.inertia[3 * b.spin + c] = principal.moments[c];
      const bool turns = start.free_spin >> c & 1;
      if (!turns && std::abs(w[c]) > 1e-12 * w.norm())
        fail_input("body " + std::to_string(i), "angular velocity", w[c], "rad/s",
                   "0 about a masked principal axis");
      out.state.v[3 * b.spin + c] = turns ? w[c] : 0.0;
    }
    s.free[b.centre] = start.free;
    s.free[b.spin] = start.free_spin;
  }
}

SystemBuilder::Built SystemBuilder::build() const {
  if (nodes_.empty() && bodies_.empty()) throw InputError("system: no nodes, expected at least one particle");
  for (int c = 0; c < 3; ++c) require_finite("system", "gravity", gravity_[c], "m/s^2");
  require_non_negative("system", "drag", drag_, "kg/s");

  Built out;
  System& s = out.system;
  const int particles = static_cast<int>(nodes_.size()), bodies = static_cast<int>(bodies_.size());
  s.nodes = particles + 2 * bodies;
  s.mass = VectorXd::Zero(s.nodes);
  s.inertia = s.inverse_mass = s.forces.constant = s.forces.drag = VectorXd::Zero(3 * s.nodes);
  s.free.assign(s.nodes, kPinned);
  out.state.q = VectorXd::Zero(3 * s.nodes + bodies);
  out.state.v = VectorXd::Zero(3 * s.nodes);
  s.forces.gravity = gravity_;
  s.forces.user = user_;
  s.forces.has_drag = drag_ > 0.0;
  for (int i = 0; i < particles; ++i) {
    s.mass[i] = nodes_[i].mass;
    s.free[i] = nodes_[i].free;
    s.inertia.segment<3>(3 * i).setConstant(nodes_[i].mass);
    out.state.q.segment<3>(3 * i) = nodes_[i].position;
    out.state.v.segment<3>(3 * i) = nodes_[i].velocity;
  }
  build_bodies(out);
  for (int i = 0; i < s.nodes; ++i)
    for (int c = 0; c < 3; ++c) {
      if (!(s.free[i] >> c & 1)) {
        s.masked.push_back(3 * i + c);
        continue;
      }
      ++s.free_count;
      s.inverse_mass[3 * i + c] = 1.0 / s.inertia[3 * i + c];
      s.forces.constant[3 * i + c] = s.mass[i] * gravity_[c];
      s.forces.drag[3 * i + c] = i < s.places() ? drag_ : 0.0;
    }
  for (const auto& [at, force] : constant_) {
    const int node = at.body < 0 ? at.node : s.bodies[at.body].centre;
    for (int c = 0; c < 3; ++c)
      if (s.free[node] >> c & 1) s.forces.constant[3 * node + c] += force[c];
  }

  for (const std::vector<int>& stencil : user_.stencils)
    for (int node : stencil)  // centres of bodies, too
      if (node < 0 || node >= s.places())
        fail_input("user force stencil", "node", node, "",
                   "an existing place, 0 to " + std::to_string(s.places() - 1));
  s.distance = arrange_distance_rows(distance_, s.places());
  s.stencil_rows = stencil_rows_;
  for_each_stencil_row_type(s.stencil_rows, [&](auto& list) {
    for (auto& row : list)
      if constexpr (requires { row.resolve(s.bodies); }) row.resolve(s.bodies);
  });
  s.law_springs = law_springs_;
  for (LawSpring& spring : s.law_springs) spring.resolve(s.bodies);
  s.colliders = colliders_;
  for (Collider& collider : s.colliders) collider.resolve(s);
  check_pairs(s.colliders);
  lay_out_stencils(s);
  collect_row_materials(s);
  s.drives = drives_;
  s.row_labels = labels_;
  if (s.driven()) {
    drive(s, out.state);
    if (!out.state.q.allFinite() || !out.state.v.allFinite())
      throw InputError("system: a prescribed motion is not finite at t = 0");
  }
  if (fluid_) {
    auto fluid = std::make_shared<Fluid>(*fluid_);
    fluid->resolve(s, out.state.q);
    s.fluid = std::move(fluid);
  }

  // public ids: distance rows moved by the batches, stencil rows in order
  std::vector<int> slot(distance_.size());
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.public_row[k] >= 0) slot[s.distance.public_row[k]] = k;
  std::vector<int> first_of_type, rows_of_type;
  int next = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    first_of_type.push_back(next);
    rows_of_type.push_back(Row::kRows);
    next += Row::kRows * static_cast<int>(list.size());
  });
  for (std::size_t id = 0; id < ids_.size(); ++id) {
    const auto [type, index] = ids_[id];
    s.row_of_id.push_back(type < 0 ? slot[index] : first_of_type[type] + rows_of_type[type] * index);
    if (type < 0) s.distance.public_row[slot[index]] = static_cast<int>(id);
  }
  return out;
}

}  // namespace feder
