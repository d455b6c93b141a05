#pragma once

#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "engine/anchor_rows.h"
#include "engine/bending.h"
#include "engine/body.h"
#include "engine/check.h"
#include "engine/distance.h"
#include "engine/forces.h"
#include "engine/mass_properties.h"
#include "engine/state.h"

namespace feder {

/// THE LIST of row types beside distance rows. A type has kNodes (at most), kRows, kName, nodes, count(),
/// stiffness, damping_time, evaluate() and hessian() (see CurvatureRow; rows between anchors: BallRow);
/// adding one is its file pair and its name here.
template <class... Type>
using RowLists = std::tuple<std::vector<Type>...>;
using StencilRows = RowLists<CurvatureRow, AngleRow, BallRow, AnchorDistanceRow, PerpendicularRow>;

/// A dense block of the step matrix over a few nodes: the rows of one stencil row element, or (rows = 0) the
/// stiffness of a user force.
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
  std::vector<int> masked;  ///< coordinates 3 node + axis that never move

  DistanceRows distance;
  StencilRows stencil_rows;
  std::vector<Stencil> stencils;
  std::vector<int> stencil_nodes;
  int jacobian_size = 0, matrix_size = 0;

  int rows = 0;                        ///< m, slots included
  int active_rows = 0;                 ///< rows that can push
  VectorXd stiffness;                  ///< d per row; 0 for inactive slots
  VectorXd damping_time;               ///< tau per row [s]
  std::vector<int> row_of_id;          ///< public row id -> first row
  bool has_hard_rows = false;          ///< some d = inf
  bool has_damping = false;            ///< some b > 0
  std::vector<int> inactive_distance;  ///< distance slots with d = 0: no pull, no pattern

  Forces forces;

  int places() const { return nodes - static_cast<int>(bodies.size()); }  ///< nodes that have a position
  Eigen::Index position_size() const { return 3 * nodes + static_cast<int>(bodies.size()); }  ///< of q
  DistanceView distance_view() const;
  /// "distance row 12 (nodes 3, 7)": how messages name a row.
  std::string row_name(int row) const;
};

/// Stiffness and damping of a row: d in [0, inf] (infinity: exactly rigid), damping time tau >= 0, b = d tau.
struct Material {
  double stiffness = 0.0;     ///< [N/m], [N m] for bending
  double damping_time = 0.0;  ///< [s]
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

  /// phi = |x_b - x_a| - rest [m], between particles and world points. rest < 0 means: as placed. Returns the
  /// public row id.
  int add_distance(Anchor a, Anchor b, const Material& material, double rest = -1.0);
  /// A row of any type of the list StencilRows, for example CurvatureRow. Returns the public row id.
  template <class Row>
  int add(const Row& row);

  void set_gravity(const Vector3d& g) { gravity_ = g; }
  /// Force -coefficient v on every particle [kg/s].
  void set_drag(double coefficient) { drag_ = coefficient; }
  void add_constant_force(Anchor at, const Vector3d& force);
  /// On a body, in world axes [N m].
  void add_constant_torque(Anchor at, const Vector3d& torque);
  void set_user_force(UserForce force) { user_ = std::move(force); }

  struct Built;
  Built build() const;

 private:
  std::string place(int node) const;
  int require_anchor(const Anchor& anchor, const std::string& where) const;
  int require_node(Anchor anchor, const std::string& where) const;
  void check_material(const std::string& where, const Material& material, const char* unit,
                      bool may_be_rigid) const;

  struct Node {
    double mass;
    Vector3d position, velocity;
    FreeMask free;
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
  std::vector<BodyNode> bodies_;
  std::vector<DistanceRow> distance_;
  StencilRows stencil_rows_;
  std::vector<RowId> ids_;
  std::vector<std::pair<int, Vector3d>> constant_;
  Vector3d gravity_ = Vector3d::Zero();
  double drag_ = 0.0;
  UserForce user_;
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
int SystemBuilder::add(const Row& row) {
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
  check_material(where, {row.stiffness, row.damping_time}, Row::kUnit, Row::kMayBeRigid);
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
