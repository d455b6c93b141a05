// Frames move by their own axes (notes F8, second reading): turning a frame about its z axis by theta is
//   x <- c x + s y,  y <- c y - s x,  moving it on along z by d is p <- p + d z,  and likewise about x.
// Four such moves make a row; joint i with axis z_i through o_i moves the tool at p by
//   revolute z_i x (p - o_i), z_i;  prismatic z_i, 0                                        (columns of J).
#include "models/robot/dh.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "engine/check.h"

namespace feder {
namespace {

struct Turn {
  double c, s;
  explicit Turn(double angle) : c(std::cos(angle)), s(std::sin(angle)) {}
};

void turn_columns(Matrix3d& R, int from, int to, const Turn& turn) {
  const Vector3d x = R.col(from), y = R.col(to);
  R.col(from) = turn.c * x + turn.s * y;
  R.col(to) = turn.c * y - turn.s * x;
}

void move_about_z(Pose& frame, const DhRow& row, double q) {
  turn_columns(frame.rotation, 0, 1, Turn(row.prismatic ? row.theta : row.theta + q));
  frame.position += (row.prismatic ? row.d + q : row.d) * frame.rotation.col(2);
}

void move_about_x(Pose& frame, const DhRow& row, const Turn& twist) {
  frame.position += row.a * frame.rotation.col(0);
  turn_columns(frame.rotation, 1, 2, twist);
}

// The frame behind the row; `joint` before its motion about z, where z is the joint's axis.
void move_on(Pose& frame, Pose& joint, const DhRow& row, DhConvention convention, const Turn& twist,
             double q) {
  if (convention == DhConvention::kModified) move_about_x(frame, row, twist);
  joint = frame;
  move_about_z(frame, row, q);
  if (convention == DhConvention::kStandard) move_about_x(frame, row, twist);
}

void set_column(ToolJacobian& J, int i, const DhRow& row, const Pose& joint, const Vector3d& tool) {
  const Vector3d z = joint.rotation.col(2);
  if (row.prismatic)
    J.col(i) << z, Vector3d::Zero();
  else
    J.col(i) << z.cross(tool - joint.position), z;
}

// Keeps the sines of the twists and the joint frames between calls.
struct Evaluator {
  Arm arm;
  std::vector<Turn> twists;
  std::vector<Pose> joints;

  explicit Evaluator(Arm a) : arm(std::move(a)), joints(arm.rows.size()) {
    for (const DhRow& row : arm.rows) twists.emplace_back(row.alpha);
  }
  void operator()(const double* q, Pose& tool, ToolJacobian& J) {
    const int n = arm.joints();
    Pose frame;
    for (int i = 0; i < n; ++i) move_on(frame, joints[i], arm.rows[i], arm.convention, twists[i], q[i]);
    tool = product(frame, arm.tool);
    J.resize(6, n);
    for (int i = 0; i < n; ++i) set_column(J, i, arm.rows[i], joints[i], tool.position);
  }
};

void check_size(const Arm& arm, const VectorXd& q) {
  FEDER_CHECK(q.size() == arm.joints(), "as many joint values as the arm has joints");
}

}  // namespace

void check_arm(const Arm& arm) {
  const std::string place = "arm '" + arm.name + "'";
  if (arm.rows.empty()) fail_input(place, "joints", 0.0, "", "at least 1");
  for (int i = 0; i < arm.joints(); ++i) {
    const DhRow& row = arm.rows[i];
    const std::string at = place + " row " + std::to_string(i + 1);
    const char* unit = row.prismatic ? "m" : "rad";
    require_finite(at, "a", row.a, "m");
    require_finite(at, "alpha", row.alpha, "rad");
    require_finite(at, "d", row.d, "m");
    require_finite(at, "theta", row.theta, "rad");
    require_finite(at, "least", row.least, unit);
    require_finite(at, "greatest", row.greatest, unit);
    if (!(row.least < row.greatest))
      fail_input(at, "least", row.least, unit, "less than greatest = " + std::to_string(row.greatest));
  }
  if (arm.task.empty()) fail_input(place, "rows of the task", 0.0, "", "at least 1");
  int before = -1;
  for (const int row : arm.task) {
    if (row < 0 || row > 5) fail_input(place, "task", row, "", "rows 0 to 5 of the Jacobian");
    if (row <= before) fail_input(place, "task", row, "", "rows in ascending order, each once");
    before = row;
  }
  for (const double x : arm.tool.position) require_finite(place, "tool position", x, "m");
  const Matrix3d& R = arm.tool.rotation;
  const double off = (R * R.transpose() - Matrix3d::Identity()).norm();
  if (!(off < 1e-9)) fail_input(place, "|R R^T - E| of the tool", off, "", "less than 1e-9: a rotation");
  if (R.determinant() < 0.0)
    fail_input(place, "det R of the tool", R.determinant(), "", "1: a rotation, no reflection");
}

Pose product(const Pose& first, const Pose& second) {
  return {first.rotation * second.rotation, first.rotation * second.position + first.position};
}

Pose inverse(const Pose& pose) {
  return {pose.rotation.transpose(), -(pose.rotation.transpose() * pose.position)};
}

Eigen::Matrix4d homogeneous(const Pose& pose) {
  Eigen::Matrix4d T = Eigen::Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = pose.rotation;
  T.topRightCorner<3, 1>() = pose.position;
  return T;
}

Pose row_transform(const DhRow& row, DhConvention convention, double q) {
  Pose frame, joint;
  move_on(frame, joint, row, convention, Turn(row.alpha), q);
  return frame;
}

std::vector<Pose> frames(const Arm& arm, const VectorXd& q) {
  check_size(arm, q);
  std::vector<Pose> all(1);
  for (int i = 0; i < arm.joints(); ++i)
    all.push_back(product(all.back(), row_transform(arm.rows[i], arm.convention, q[i])));
  all.push_back(product(all.back(), arm.tool));
  return all;
}

Pose tool_pose(const Arm& arm, const VectorXd& q) {
  return frames(arm, q).back();
}

ToolJacobian tool_jacobian(const Arm& arm, const VectorXd& q) {
  check_size(arm, q);
  Pose tool;
  ToolJacobian J;
  Evaluator{arm}(q.data(), tool, J);
  return J;
}

Arm as_modified(const Arm& arm) {
  if (arm.convention == DhConvention::kModified) return arm;
  Arm same = arm;
  same.convention = DhConvention::kModified;
  for (int i = arm.joints() - 1; i > 0; --i)
    same.rows[i].a = arm.rows[i - 1].a, same.rows[i].alpha = arm.rows[i - 1].alpha;
  same.rows[0].a = same.rows[0].alpha = 0.0;
  Pose last;
  move_about_x(last, arm.rows.back(), Turn(arm.rows.back().alpha));
  same.tool = product(last, arm.tool);
  return same;
}

Ring reach_of(const Arm& arm) {
  // by the modified table: from joint i to joint i + 1 it is a along x and d along the next z
  const Arm by_axes = as_modified(arm);
  auto commands = [&](int row) { return std::find(arm.task.begin(), arm.task.end(), row) != arm.task.end(); };
  const bool parallel =
      std::all_of(arm.rows.begin(), arm.rows.end(), [](const DhRow& row) { return row.alpha == 0.0; });
  const bool flat = parallel && commands(0) && commands(1) && !commands(2);
  Ring ring;
  double both = 0.0;  // least + greatest length of one link, of the link where that is most
  auto add = [&](double least, double greatest) {
    ring.greatest += greatest;
    both = std::max(both, least + greatest);
  };
  // offsets along z [low, high], which a flat task does not see
  auto add_link = [&](double a, double low, double high) {
    if (flat) low = high = 0.0;
    const double near = low * high <= 0.0 ? 0.0 : std::min(std::abs(low), std::abs(high));
    add(std::hypot(a, near), std::hypot(a, std::max(std::abs(low), std::abs(high))));
  };
  const DhRow& first = by_axes.rows[0];
  ring.centre = row_transform(first, DhConvention::kModified, first.prismatic ? first.least : 0.0).position;
  if (first.prismatic) add_link(0.0, 0.0, first.greatest - first.least);
  for (int i = 1; i < by_axes.joints(); ++i) {
    const DhRow& row = by_axes.rows[i];
    add_link(row.a, row.prismatic ? row.d + row.least : row.d, row.prismatic ? row.d + row.greatest : row.d);
  }
  const Vector3d& tool = by_axes.tool.position;
  add_link(tool.head<2>().norm(), tool.z(), tool.z());
  if (flat || (commands(0) && commands(1) && commands(2))) ring.least = std::max(0.0, both - ring.greatest);
  return ring;
}

KinematicMap kinematic_map(const Arm& arm) {
  check_arm(arm);
  const int n = arm.joints();
  KinematicMap map{arm.name, VectorXd(n), VectorXd(n), {}, arm.task, reach_of(arm), Evaluator(arm)};
  for (int i = 0; i < n; ++i) {
    map.least[i] = arm.rows[i].least, map.greatest[i] = arm.rows[i].greatest;
    map.turns.push_back(!arm.rows[i].prismatic);
  }
  return map;
}

}  // namespace feder
