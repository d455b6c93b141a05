#pragma once

#include <Eigen/Core>
#include <array>
#include <string>

#include "engine/state.h"

namespace feder {

/// Bending of a chain of three nodes that is straight at rest: phi = kappa = 2 a x b / (|a||b| + a.b), a = x1
/// - x0, b = x2 - x1. Three rows of rank 2 (kappa is orthogonal to a and b), so finite stiffness only.
/// |kappa| = 2 tan(psi/2).
struct CurvatureRow {
  static constexpr int kNodes = 3;
  static constexpr int kRows = 3;
  static constexpr const char* kName = "curvature";
  static constexpr const char* kUnit = "N m";
  static constexpr bool kMayBeRigid = false;

  std::array<int, 3> nodes{};
  static constexpr int count() { return kNodes; }
  double stiffness = 0.0;     ///< d [N m], finite
  double damping_time = 0.0;  ///< tau [s]

  /// Input checks of this type alone; throws InputError.
  void check(const std::string& where) const;
  /// phi: kRows values [1]; jacobian: kRows x 9 row-major [1/m], may be null. False where the row is
  /// degenerate (an edge of length 0 or folded back, psi = pi); then phi and jacobian are 0.
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  /// sum_i lambda_i Hess phi_i over (x0, x1, x2), 9 x 9.
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

/// Bending with a curved rest state: phi = psi - psi0, psi = atan2(|a x b|, a.b) in (0, pi).
/// Degenerate at psi = 0 and pi, where the angle has a cone (notes E2).
struct AngleRow {
  static constexpr int kNodes = 3;
  static constexpr int kRows = 1;
  static constexpr const char* kName = "angle";
  static constexpr const char* kUnit = "N m";
  static constexpr bool kMayBeRigid = true;

  std::array<int, 3> nodes{};
  static constexpr int count() { return kNodes; }
  double stiffness = 0.0;     ///< d [N m], may be infinite
  double damping_time = 0.0;  ///< tau [s]
  double rest_angle = 0.0;    ///< psi0 [rad], inside (0, pi)

  void check(const std::string& where) const;
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

}  // namespace feder
