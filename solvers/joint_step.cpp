// The dual route of the step matrix with M = E and v_start = z (notes F4): over the free joints
//   S y = e - A_held x_held - A z,  S = A A^T + gamma,  x = z + A^T y.
#include "solvers/joint_step.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

}  // namespace

Vector3d rotation_vector(const Matrix3d& rotation) {
  const Eigen::Quaterniond turn(rotation);
  const double sine = turn.vec().norm();
  if (sine == 0.0) return Vector3d::Zero();
  return 2.0 * std::atan2(sine, std::abs(turn.w())) / (turn.w() < 0.0 ? -sine : sine) * turn.vec();
}

double off_rotation(const Matrix3d& R) {
  if (R.determinant() < 0.0) return std::numeric_limits<double>::infinity();
  return (R * R.transpose() - Matrix3d::Identity()).norm();
}

void require_tolerance(const std::string& place, double tolerance, const KinematicMap& map) {
  require_positive(place, "tolerance", tolerance, "m and rad");
  const double least = 16.0 * std::numeric_limits<double>::epsilon() * std::max(1.0, map.reach.greatest);
  char expected[64];
  std::snprintf(expected, sizeof expected, "at least what rounding leaves, %.3g", least);
  if (tolerance < least) fail_input(place, "tolerance", tolerance, "m and rad", expected);
}

JointStep::JointStep(const KinematicMap& map, double length)
    : map_(&map),
      length_(length),
      J_(6, map.joints()),
      A_(map.task.size(), map.joints()),
      e_(map.task.size()),
      held_(map.least.size()) {
  FEDER_CHECK(!map.task.empty() && map.task.size() <= SmallDual::kMost, "from 1 to 6 task rows");
  FEDER_CHECK(std::adjacent_find(map.task.begin(), map.task.end(), std::greater_equal<>()) == map.task.end(),
              "task rows in ascending order");
  FEDER_CHECK(length > 0.0, "a length > 0");
  FEDER_CHECK(std::ssize(map.turns) == map.joints(), "turns says of each joint what it is");
}

void JointStep::linearise(const VectorXd& q, const Pose& target) {
  map_->evaluate(q.data(), tool_, J_);
  Eigen::Matrix<double, 6, 1> e;
  e.head<3>() = target.position - tool_.position;
  e.tail<3>().setZero();
  if (map_->task.back() >= 3) e.tail<3>() = rotation_vector(target.rotation * tool_.rotation.transpose());
  for (int k = 0; k < e_.size(); ++k) {
    const int row = map_->task[k];
    const double weight = row < 3 ? 1.0 : length_;
    e_[k] = weight * e[row];
    A_.row(k) = weight * J_.row(row);
  }
}

PoseError JointStep::pose_error() const {
  PoseError error;
  for (int k = 0; k < e_.size(); ++k) {
    double& part = map_->task[k] < 3 ? error.place : error.angle;
    part = std::hypot(part, map_->task[k] < 3 ? e_[k] : e_[k] / length_);
  }
  return error;
}

bool JointStep::wraps(int joint) const {
  return map_->turns[joint] && map_->greatest[joint] - map_->least[joint] >= kTurn;
}

double JointStep::free_gradient(const VectorXd& q, AtLimits at) const {
  double squared = 0.0;
  for (int i = 0; i < q.size(); ++i) {
    const double slope = A_.col(i).dot(e_);
    const bool stuck = slope > 0.0 ? q[i] >= map_->greatest[i] : q[i] <= map_->least[i];
    if (!stuck || (at == AtLimits::kWrap && wraps(i))) squared += slope * slope;
  }
  return squared;
}

bool JointStep::solve_free(const VectorXd& z, double gamma, VectorXd& x) {
  const int m = static_cast<int>(e_.size()), n = map_->joints();
  std::array<double, SmallDual::kMost> y{};
  std::copy_n(e_.data(), m, y.data());
  S_.reset(m, gamma);
  for (int i = 0; i < n; ++i) {
    const double* column = A_.col(i).data();
    const double moved = held_[i] ? x[i] : z[i];
    for (int k = 0; k < m; ++k) y[k] -= column[k] * moved;
    if (!held_[i]) S_.add(column);
  }
  ++solves_;
  if (!S_.factor()) return false;
  S_.solve(y.data());
  for (int i = 0; i < n; ++i) {
    if (held_[i]) continue;
    x[i] = z[i];
    for (int k = 0; k < m; ++k) x[i] += A_(k, i) * y[k];
  }
  return true;
}

bool JointStep::step(const VectorXd& q, const VectorXd& z, double gamma, VectorXd& x, AtLimits at) {
  const int n = map_->joints();
  x.resize(n);
  std::fill(held_.begin(), held_.end(), char{0});
  solves_ = 0;
  for (;;) {
    if (!solve_free(z, gamma, x)) return false;
    int worst = -1;
    double most = 0.0;
    for (int i = 0; i < n; ++i) {
      const double least = map_->least[i], greatest = map_->greatest[i];
      if (held_[i] || (at == AtLimits::kWrap && wraps(i))) continue;
      const double beyond = std::max(q[i] + x[i] - greatest, least - q[i] - x[i]);
      if (beyond > most) worst = i, most = beyond;
    }
    if (worst < 0) return true;
    held_[worst] = 1;
    x[worst] = (x[worst] > 0.0 ? map_->greatest : map_->least)[worst] - q[worst];
  }
}

void JointStep::take(const VectorXd& x, VectorXd& q, AtLimits at) const {
  for (int i = 0; i < q.size(); ++i) {
    const double least = map_->least[i], greatest = map_->greatest[i];
    q[i] += x[i];
    if (at == AtLimits::kWrap && wraps(i)) {
      if (q[i] > greatest) q[i] -= kTurn * std::ceil((q[i] - greatest) / kTurn);
      if (q[i] < least) q[i] += kTurn * std::ceil((least - q[i]) / kTurn);
    }
    q[i] = std::clamp(q[i], least, greatest);
  }
}

}  // namespace feder
