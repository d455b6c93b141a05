#pragma once

#include <string>
#include <vector>

#include "engine/anchor_rows.h"

namespace feder {

/// A row with a target: s(t) of its dial if it has one (SystemBuilder::add_dial), `rest` otherwise.
struct TargetPair : AnchorPair {
  double rest = 0.0;  ///< [m] or [rad]
  Anchor dial = {};   ///< node whose x is the target

  int count() const { return AnchorPair::count() + (dial.node >= 0 ? 1 : 0); }
  void resolve(const std::vector<Body>& bodies);
  void check(const std::string& where) const;

 protected:
  double target(const double* q) const { return dial.node >= 0 ? q[3 * dial.node] : rest; }
  void set_dial_column(double* jacobian) const;
};

/// How far b lies from a along an axis fixed in a: phi = n_a . (x_b - x_a) - target [m]. Two of them with
/// rest 0 and the rotations held make a prismatic joint; one with a finite d is a spring along the axis, with
/// a dial a linear motor.
struct AlongRow : TargetPair {
  static constexpr int kNodes = 5;
  static constexpr int kRows = 1;
  static constexpr const char* kName = "along";
  static constexpr const char* kUnit = "N/m";
  static constexpr bool kMayBeRigid = true;
  Vector3d axis = Vector3d::UnitX();  ///< in a's axes, length 1

  Vector3d principal_axis = axis;
  void resolve(const std::vector<Body>& bodies);
  void check(const std::string& where) const;
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

/// How far b has turned about an axis fixed in a: phi = psi - target [rad], psi the angle from direction_a
/// (a's axes, perpendicular to the axis) to direction_b (b's axes), seen along the axis. psi counts turns:
/// its dial, which every such row has (made by the builder if not given), remembers the last angle, and a
/// step may turn it by less than half a turn. Degenerate where direction_b lies along the axis.
struct TurnRow : TargetPair {
  static constexpr int kNodes = 5;
  static constexpr int kRows = 1;
  static constexpr const char* kName = "turn";
  static constexpr const char* kUnit = "N m";
  static constexpr bool kMayBeRigid = true;
  Vector3d axis = Vector3d::UnitZ(), direction_a = Vector3d::UnitX(), direction_b = Vector3d::UnitX();

  Vector3d cosine_a = direction_a, sine_a = Vector3d::UnitY(), principal_b = direction_b;
  void resolve(const std::vector<Body>& bodies);
  void check(const std::string& where) const;
  /// psi [rad], turns counted from the dial.
  double angle(const double* q) const;
  void count_turns(double* q) const { q[3 * dial.node + 1] = angle(q); }
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

}  // namespace feder
