// Contact rows (design.md section 1: an impulse at a contact is one row of the same matrix). With F the
// contact's axes (rows n, t1, t2), x the touched point and R, s the rotation and the arm of a body's point,
//   u = F (v_b(x) - v_a(x)),   v(x) = c' + R (w x s)   so   d u/d c' = +-F,   d u/d w = -+F R [s]x
// a gap changes by dt u_n to first order. Rows are taken at the start of the step.
#include "engine/contacts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/body.h"
#include "engine/geometry/shape_bounds.h"
#include "engine/system.h"

namespace feder {
namespace {

// What a collider may move within dt beyond its velocity and the constant forces: a share of that again.
constexpr double kReserve = 2.0;
// Of the size of the smaller shape: contacts at rest stay rows although rounding opens them.
constexpr double kTouching = 1e-6;

}  // namespace

Matrix3d contact_frame(const Vector3d& n) {
  // Duff et al., Building an orthonormal basis, revisited, 2017
  const double sign = std::copysign(1.0, n.z()), a = -1.0 / (sign + n.z()), b = n.x() * n.y() * a;
  Matrix3d F;
  F << n.transpose(), 1.0 + sign * n.x() * n.x() * a, sign * b, -sign * n.x(), b, sign + n.y() * n.y() * a,
      -n.y();
  return F;
}

void ContactRows::multiply(const VectorXd& v, VectorXd& u) const {
  u.setZero(3 * count());
  for (int i = 0; i < count(); ++i)
    for (int k = 0; k < contacts[i].blocks; ++k) {
      const Block& block = blocks[contacts[i].first_block + k];
      u.segment<3>(3 * i) += block.J * v.segment<3>(3 * block.node);
    }
}

void ContactRows::velocities(const VectorXd& v, VectorXd& u) const {
  multiply(v, u);
  u += driven;
}

void ContactRows::add_impulses(const VectorXd& y, VectorXd& out) const {
  for (int i = 0; i < count(); ++i)
    for (int k = 0; k < contacts[i].blocks; ++k) {
      const Block& block = blocks[contacts[i].first_block + k];
      out.segment<3>(3 * block.node) += block.J.transpose() * y.segment<3>(3 * i);
    }
}

ContactRows ContactRows::subset(const std::vector<int>& some) const {
  ContactRows out;
  out.driven.resize(3 * static_cast<Eigen::Index>(some.size()));
  for (int i : some) {
    out.driven.segment<3>(3 * out.count()) = driven.segment<3>(3 * i);
    out.contacts.push_back(contacts[i]);
    Contact& contact = out.contacts.back();
    const auto first = blocks.begin() + contact.first_block;
    contact.first_block = static_cast<int>(out.blocks.size());
    out.blocks.insert(out.blocks.end(), first, first + contact.blocks);
  }
  return out;
}

void ContactRows::keep_within(double gap) {
  std::vector<int> some;
  for (int i = 0; i < count(); ++i)
    if (contacts[i].at.gap <= gap) some.push_back(i);
  *this = subset(some);
}

ContactFinder::ContactFinder(const System& system)
    : system_(system), poses_(system.colliders.size()), margins_(system.colliders.size()) {
  for (const Stencil& stencil : system.stencils) {
    if (stencil.rows == 0) continue;
    std::vector<int> ends;
    for (int i = 0; i < stencil.nodes; ++i)
      for (std::size_t body = 0; body < system.bodies.size(); ++body)
        if (system.bodies[body].centre == system.stencil_nodes[stencil.first_node + i])
          ends.push_back(static_cast<int>(body));
    if (ends.size() == 2) joined_.emplace_back(std::minmax(ends[0], ends[1]));
  }
  std::sort(joined_.begin(), joined_.end());
}

bool ContactFinder::may_touch(int i, int j) const {
  const Collider &a = system_.colliders[i], &b = system_.colliders[j];
  if (a.fixed && b.fixed) return false;
  if (a.group != 0 && a.group == b.group) return false;
  if (a.place.node == b.place.node) return false;
  if (a.at.body < 0 || b.at.body < 0) return true;
  const std::pair<int, int> bodies = std::minmax(a.at.body, b.at.body);
  return !std::binary_search(joined_.begin(), joined_.end(), bodies);
}

// Pairs of colliders whose boxes, grown by what they may move in dt and half of `margin`, overlap.
void ContactFinder::candidates(const State& state, double dt, double margin) {
  const System& s = system_;
  boxes_.resize(s.colliders.size());
  for (std::size_t i = 0; i < s.colliders.size(); ++i) {
    const Collider& c = s.colliders[i];
    poses_[i] = c.pose(state.q.data());
    double moved = dt * state.v.segment<3>(3 * c.place.node).norm();
    if (s.mass[c.place.node] > 0.0)
      moved += dt * dt * s.forces.constant.segment<3>(3 * c.place.node).norm() / s.mass[c.place.node];
    const double reach = c.reach();
    if (c.place.spin >= 0)
      moved += dt * state.v.segment<3>(3 * c.place.spin).norm() * (c.place.point.norm() + reach);
    margins_[i] = 0.5 * margin + kReserve * moved + (std::isfinite(reach) ? kTouching * reach : 0.0);
    boxes_[i] = bounds(c.shape, poses_[i]);
    boxes_[i].min.array() -= margins_[i];
    boxes_[i].max.array() += margins_[i];
  }
  broad_phase_.update(boxes_);
  broad_phase_.find_pairs(pairs_);
  std::erase_if(pairs_, [&](const std::pair<int, int>& pair) { return !may_touch(pair.first, pair.second); });
}

void ContactFinder::find(const State& state, double dt, ContactRows& out) {
  const System& s = system_;
  out.contacts.clear();
  out.blocks.clear();
  candidates(state, dt, 0.0);
  for (const auto& [i, j] : pairs_) {
    const Collider &a = s.colliders[i], &b = s.colliders[j];
    points_.clear();
    find_contacts(a.shape, poses_[i], b.shape, poses_[j], margins_[i] + margins_[j], points_);
    const Surface surface{std::sqrt(a.surface.friction * b.surface.friction),
                          std::max(a.surface.restitution, b.surface.restitution)};
    for (const ContactPoint& point : points_)
      out.contacts.push_back({i, j, point, contact_frame(point.normal), surface});
  }
  std::sort(out.contacts.begin(), out.contacts.end(),
            [](const Contact& a, const Contact& b) { return a.key() < b.key(); });

  out.driven.setZero(3 * out.count());
  for (int k = 0; k < out.count(); ++k) {
    Contact& contact = out.contacts[k];
    contact.first_block = static_cast<int>(out.blocks.size());
    // a particle takes no torque: what touches it is met at its centre, or angular momentum would be lost
    Vector3d point = contact.at.point;
    for (int collider : {contact.a, contact.b})
      if (const Collider& c = s.colliders[collider]; c.place.spin < 0 && !c.fixed)
        point = poses_[collider].position;
    for (const auto& [collider, sign] : {std::pair{contact.a, -1.0}, std::pair{contact.b, 1.0}}) {
      const Place& place = s.colliders[collider].place;
      const Matrix3d F = sign * contact.frame;
      auto add = [&](int node, const Matrix3d& J) {
        Matrix3d free = J;
        for (int c = 0; c < 3; ++c)
          if (!(s.free[node] >> c & 1)) {
            out.driven.segment<3>(3 * k) += J.col(c) * state.v[3 * node + c];
            free.col(c).setZero();
          }
        if (s.free[node] != kPinned) out.blocks.push_back({node, free});
      };
      add(place.node, F);
      if (place.spin < 0) continue;
      const Matrix3d R = rotation(place, state.q.data());
      add(place.spin, -F * R * skew(R.transpose() * (point - state.q.segment<3>(3 * place.node))));
    }
    contact.blocks = static_cast<int>(out.blocks.size()) - contact.first_block;
  }
}

double ContactFinder::smallest_gap(const State& state, double margin) {
  candidates(state, 0.0, margin);
  double gap = margin;
  for (const auto& [i, j] : pairs_) {
    points_.clear();
    find_contacts(system_.colliders[i].shape, poses_[i], system_.colliders[j].shape, poses_[j], gap, points_);
    for (const ContactPoint& point : points_) gap = std::min(gap, point.gap);
  }
  return gap;
}

}  // namespace feder
