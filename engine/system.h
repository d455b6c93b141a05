#pragma once

#include <limits>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/anchor_rows.h"
#include "engine/axis_rows.h"
#include "engine/bending.h"
#include "engine/body.h"
#include "engine/check.h"
#include "engine/collider.h"
#include "engine/distance.h"
#include "engine/drive.h"
#include "engine/forces.h"
#include "engine/law_spring.h"
#include "engine/mass_properties.h"
#include "engine/state.h"

namespace feder {

class Fluid;

/// THE LIST of row types beside distance rows. A type has kNodes (at most), kRows, kName, nodes, count(),
/// stiffness, damping_time, evaluate() and hessian() (see CurvatureRow; rows between anchors: BallRow);
/// adding one is its file pair and its name here.
template <class... Type>
using RowLists = std::tuple<std::vector<Type>...>;
using StencilRows =
    RowLists<CurvatureRow, AngleRow, BallRow, AnchorDistanceRow, PerpendicularRow, AlongRow, TurnRow>;

/// A dense block of the step matrix over a few nodes: the rows of one stencil row element, or (rows = 0) the
/// stiffness of a law spring or user force.
struct Stencil {
  int first_row = 0;   ///< in row order
  int rows = 0;        ///< scalar rows
  int first_node = 0;  ///< into System::stencil_nodes
  int nodes = 0;       ///< number of nodes
  int jacobian = 0;    ///< offset of its rows x 3 nodes Jacobian, row-major
  int matrix = 0;      ///< offset of its symmetric 3 nodes x 3 nodes matrix
};

/// What a mechanical system IS; constant during a run. Built by SystemBuilder.
///
/// Rows are numbered: distance slots (padding included), then the scalar rows of each stencil row type in
/// list order.
/// Nodes are numbered: particles and world points as added, then the centres of the bodies, then their spins.
/// Seen in its principal axes a body is two nodes with a constant diagonal mass: every route and kernel works
/// on them as on particles.
struct System {
  int nodes = 0;          ///< particles, world points, centres, spins
  int free_count = 0;     ///< free coordinates n
  VectorXd mass;          ///< per node [kg], 0 for world points and spins
  VectorXd inertia;       ///< 3 per node: mass [kg]; spins: principal moments [kg m^2]
  VectorXd inverse_mass;  ///< 3 per node [1/kg], 0 where masked
  std::vector<Body> bodies;
  std::vector<FreeMask> free;
  std::vector<int> masked;    ///< coordinates 3 node + axis that are no unknowns
  std::vector<Drive> drives;  ///< nodes that follow a prescribed motion

  DistanceRows distance;
  StencilRows stencil_rows;
  std::vector<Stencil> stencils;
  std::vector<int> stencil_nodes;
  int jacobian_size = 0, matrix_size = 0;

  int rows = 0;                         ///< m, slots included
  int active_rows = 0;                  ///< rows that can push
  VectorXd stiffness;                   ///< d per row; 0 for inactive slots
  VectorXd damping_time;                ///< tau per row [s]
  VectorXd damping;                     ///< b = d tau + own coefficient per row; 0 for hard rows
  std::vector<int> row_of_id;           ///< public row id -> first row
  std::vector<std::string> row_labels;  ///< per public row id, what messages call it; may be shorter
  bool has_hard_rows = false;           ///< some d = inf
  bool has_damping = false;             ///< some b > 0
  std::vector<int> inactive_distance;   ///< distance slots with d = 0: no pull, no pattern

  Forces forces;
  std::vector<LawSpring> law_springs;
  std::vector<Collider> colliders;
  /// Per collider: for a free particle that may meet one without unknowns the stencil of its node alone,
  /// where a step keeps what such contacts add to Mt; otherwise -1.
  std::vector<int> contact_stencil;
  std::shared_ptr<const Fluid> fluid;  ///< particles that are smoothed mass; null if there are none
  bool forces_look_at_state() const {
    return forces.user || forces.has_torques || !law_springs.empty() || fluid;
  }

  bool active(int row) const { return stiffness[row] > 0.0 || damping[row] > 0.0; }
  bool driven() const { return !drives.empty() || !std::get<std::vector<TurnRow>>(stencil_rows).empty(); }
  /// b / (dt d + b): how much of phi_n implicit Euler still feels; tau / (dt + tau) for hard rows.
  double memory(int row, double dt) const;
  int places() const { return nodes - static_cast<int>(bodies.size()); }  ///< nodes that have a position
  Eigen::Index position_size() const { return 3 * nodes + static_cast<int>(bodies.size()); }  ///< of q
  DistanceView distance_view() const;
  /// Its label, or "distance row 12 (nodes 3, 7)", "ball row 4 (body 0, body 1)": how messages name a row.
  std::string row_name(int row) const;
};

inline constexpr double kRigid = std::numeric_limits<double>::infinity();
/// Stiffness and damping of a row: d in [0, inf] (infinity: exactly rigid), damping time tau >= 0.
struct Material {
  double stiffness = 0.0;     ///< [N/m], [N m] for bending
  double damping_time = 0.0;  ///< [s]
  double damping = 0.0;       ///< own coefficient, b = d tau + damping; a damper alone has d = 0 [kg/s]
};

/// Collects nodes, rows and forces, checks every number (InputError names the place), and builds System and
/// State.
class SystemBuilder {
 public:
  /// mass [kg] > 0; position [m]; velocity [m/s] must be 0 where masked.
  Anchor add_particle(double mass, const Vector3d& position, const Vector3d& velocity = Vector3d::Zero(),
                      FreeMask free = kFree);
  /// A fixed place of the world: no mass, no columns.
  Anchor add_world_point(const Vector3d& position);
  /// A world point that follows a motion.
  Anchor add_moving_point(const Motion& motion);
  /// The target of one row (`dial` of AlongRow, TurnRow), [m] or [rad].
  Anchor add_dial(const Target& target);

  /// Pose and velocity of a body: where the origin of the axes of its MassProperties lies and how they are
  /// turned; velocity of its centre of mass; angular velocity in world axes. A pinned body has all of `free`
  /// and `free_spin` cleared; masks of the spin are by principal axis and must fit the start (0 velocity
  /// where masked).
  struct BodyStart {
    Vector3d position = Vector3d::Zero();          ///< [m]
    Matrix3d orientation = Matrix3d::Identity();   ///< proper rotation
    Vector3d velocity = Vector3d::Zero();          ///< [m/s]
    Vector3d angular_velocity = Vector3d::Zero();  ///< [rad/s]
    FreeMask free = kFree, free_spin = kFree;
  };
  /// Returns the anchor at the origin of the body's axes; others: {.body = id, .point = ...}.
  Anchor add_body(const MassProperties& properties, const BodyStart& start);

  /// The anchor of a body (any of its anchors given) that lies at a place of the world at the start;
  /// Anchor{}, the world, gives a new world point there.
  Anchor anchor_at(const Anchor& body, const Vector3d& place);
  /// A direction of the world at the start, in the axes of the anchor's body; unchanged for the world.
  Vector3d direction_in(const Anchor& body, const Vector3d& direction) const;

  /// phi = |x_b - x_a| - rest [m], between particles and world points. rest < 0 means: as placed. Returns the
  /// public row id.
  int add_distance(Anchor a, Anchor b, const Material& material, double rest = -1.0);
  /// A row of any type of the list StencilRows, for example CurvatureRow. Returns the public row id.
  template <class Row>
  int add(const Row& given);

  /// What messages call a row, by its public id, instead of its type and nodes.
  void label_row(int id, std::string label);

  void set_gravity(const Vector3d& g) { gravity_ = g; }
  /// Force -coefficient v on every particle [kg/s].
  void set_drag(double coefficient) { drag_ = coefficient; }
  /// On a body: at its centre of mass. In world axes [N].
  void add_constant_force(Anchor at, const Vector3d& force);
  /// On a body, in world axes [N m].
  void add_constant_torque(Anchor at, const Vector3d& torque);
  /// Stiffness and damping of `spring` as a row are not used.
  void add_law_spring(const LawSpring& spring);
  /// A solid shape at a particle, a world point or a point of a body; `rotation` turns the shape's axes into
  /// the body's (at nodes: the world's). Bodies joined by a row, and colliders of one `group` other than 0,
  /// pass through each other. Returns its place in System::colliders.
  int add_collider(const Anchor& at, const Shape& shape, const Surface& surface = {}, int group = 0,
                   const Matrix3d& rotation = Matrix3d::Identity());
  void set_user_force(UserForce force) { user_ = std::move(force); }
  /// Makes some of the particles a fluid (engine/fluid/fluid.h).
  void set_fluid(std::shared_ptr<const Fluid> fluid) { fluid_ = std::move(fluid); }

  struct Built;
  Built build() const;

 private:
  std::string place(int node) const;
  int require_anchor(const Anchor& anchor, const std::string& where) const;
  int require_node(Anchor anchor, const std::string& where) const;
  int require_dial(Anchor anchor, const std::string& where);
  void check_material(const std::string& where, const Material& material, const char* unit,
                      bool may_be_rigid) const;

  struct Node {
    double mass;
    Vector3d position, velocity;
    FreeMask free;
    bool dial = false;
  };
  struct BodyNode {
    MassProperties properties;
    BodyStart start;
    Vector3d torque = Vector3d::Zero();
  };
  void build_bodies(Built& out) const;
  struct RowId {
    int type;   ///< place in StencilRows, -1 for distance rows
    int index;  ///< place in its list
  };
  std::vector<Node> nodes_;
  std::vector<Drive> drives_;
  std::vector<BodyNode> bodies_;
  std::vector<DistanceRow> distance_;
  StencilRows stencil_rows_;
  std::vector<RowId> ids_;
  std::vector<std::string> labels_;
  std::vector<std::pair<Anchor, Vector3d>> constant_;
  std::vector<LawSpring> law_springs_;
  std::vector<Collider> colliders_;
  Vector3d gravity_ = Vector3d::Zero();
  double drag_ = 0.0;
  UserForce user_;
  std::shared_ptr<const Fluid> fluid_;
};

struct SystemBuilder::Built {
  System system;
  State state;
};

/// Calls visit(list) for every stencil row list.
template <class Lists, class Visit>
void for_each_stencil_row_type(Lists& lists, Visit&& visit) {
  std::apply([&](auto&... list) { (visit(list), ...); }, lists);
}

template <class Row>
int SystemBuilder::add(const Row& given) {
  Row row = given;
  const int id = static_cast<int>(ids_.size());
  const std::string where = "row " + std::to_string(id) + " (" + Row::kName + ")";
  if constexpr (requires { row.a; }) {
    const int a = require_anchor(row.a, where), b = require_anchor(row.b, where);
    if (a == b && (row.a.body >= 0) == (row.b.body >= 0))
      fail_input(where, row.a.body >= 0 ? "body" : "node", a, "", "two different ones");
  } else {
    for (std::size_t i = 0; i < row.nodes.size(); ++i) {
      (void)require_node({row.nodes[i]}, where);
      for (std::size_t j = 0; j < i; ++j)
        if (row.nodes[i] == row.nodes[j]) fail_input(where, "node", row.nodes[i], "", "different nodes");
    }
  }
  Material material{row.stiffness, row.damping_time};
  if constexpr (requires { row.damping; }) material.damping = row.damping;
  check_material(where, material, Row::kUnit, Row::kMayBeRigid);
  if constexpr (requires { row.dial; }) {
    if (row.dial.node < 0 && std::is_same_v<Row, TurnRow>) row.dial = add_dial(steady_target(row.rest, 0.0));
    if (row.dial.node >= 0 || row.dial.body >= 0) row.dial.node = require_dial(row.dial, where);
  }
  row.check(where);
  int type = 0, place = -1;
  for_each_stencil_row_type(stencil_rows_, [&](auto& list) {
    if constexpr (std::is_same_v<typename std::decay_t<decltype(list)>::value_type, Row>) {
      list.push_back(row);
      place = type;
    }
    ++type;
  });
  ids_.push_back({place, static_cast<int>(std::get<std::vector<Row>>(stencil_rows_).size()) - 1});
  return id;
}

}  // namespace feder
