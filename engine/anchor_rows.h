#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "engine/state.h"

namespace feder {

struct Body;

/// An anchor resolved against a System: one node (particle, world point) or two (centre and spin of a body).
struct Place {
  int node = -1, spin = -1, quaternion = -1;
  Vector3d point = Vector3d::Zero();  ///< in principal axes about the centre [m]
  int count() const { return spin < 0 ? 1 : 2; }
};

/// World axes of a place's principal axes; the identity at particles and world points.
Matrix3d rotation(const Place& place, const double* q);
/// Second derivative of f.(R exp([xi]x) s) by xi.
Matrix3d turned_twice(const Matrix3d& R, const Vector3d& s, const Vector3d& f);

/// What the rows between two anchors share: phi depends on q through the vector d = x_b - x_a of their
/// points. SystemBuilder resolves the anchors; `nodes` are those of a, then those of b.
struct AnchorPair {
  Anchor a, b;
  double stiffness = 0.0;     ///< d, may be infinite
  double damping_time = 0.0;  ///< tau [s]
  double damping = 0.0;       ///< own coefficient beside d tau, finite d only [kg/s, kg m^2/s]

  Place at_a = {}, at_b = {};
  std::array<int, 5> nodes{};
  int count() const { return at_a.count() + at_b.count(); }
  void resolve(const std::vector<Body>& bodies);
  /// d and its derivative, 3 x 3 count row-major [m/m, m/rad].
  Vector3d difference(const double* q, double* jacobian) const;
  /// out = Hess (f . d), block diagonal per body.
  void add_curvature(const double* q, const Vector3d& f, Eigen::Ref<Eigen::MatrixXd> out) const;
  /// n . m of two directions fixed at the anchors (in principal axes, world axes at nodes); its gradient by
  /// the nodes, 3 count; out += weight times its second derivative.
  double dot(const double* q, const Vector3d& n, const Vector3d& m, double* gradient) const;
  void add_dot_curvature(const double* q, const Vector3d& n, const Vector3d& m, double weight,
                         Eigen::Ref<Eigen::MatrixXd> out) const;
  void check(const std::string& where) const;
};

/// A direction given in the axes of the anchor's body, in its principal axes.
Vector3d in_principal_axes(const Anchor& anchor, const Vector3d& direction, const std::vector<Body>& bodies);
/// Throws InputError unless |n| = 1.
void check_direction(const std::string& where, const char* name, const Vector3d& n);

/// Ball joint: phi = x_b - x_a, three rows [m]; finite d is an isotropic spring of rest length 0 [N/m].
struct BallRow : AnchorPair {
  static constexpr int kNodes = 4;
  static constexpr int kRows = 3;
  static constexpr const char* kName = "ball";
  static constexpr const char* kUnit = "N/m";
  static constexpr bool kMayBeRigid = true;
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

/// Spring or rod between any two anchors: phi = |x_b - x_a| - rest [m]. Degenerate where the points coincide.
struct AnchorDistanceRow : AnchorPair {
  static constexpr int kNodes = 4;
  static constexpr int kRows = 1;
  static constexpr const char* kName = "anchor distance";
  static constexpr const char* kUnit = "N/m";
  static constexpr bool kMayBeRigid = true;
  double rest = 0.0;  ///< [m], > 0
  void check(const std::string& where) const;
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

/// Two directions stay perpendicular: phi = n_a . n_b [1]. A direction is fixed in its anchor's body (given
/// in the body's axes) or in the world. Two of them make a ball joint a hinge. finite d [N m].
struct PerpendicularRow : AnchorPair {
  static constexpr int kNodes = 4;
  static constexpr int kRows = 1;
  static constexpr const char* kName = "perpendicular";
  static constexpr const char* kUnit = "N m";
  static constexpr bool kMayBeRigid = true;
  Vector3d direction_a = Vector3d::UnitX(), direction_b = Vector3d::UnitY();  ///< unit vectors

  Vector3d principal_a = direction_a, principal_b = direction_b;
  void resolve(const std::vector<Body>& bodies);
  void check(const std::string& where) const;
  bool evaluate(const double* q, double* phi, double* jacobian) const;
  void hessian(const double* q, const double* lambda, Eigen::Ref<Eigen::MatrixXd> out) const;
};

}  // namespace feder
