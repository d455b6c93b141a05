// Rotations (notes B5 to B8, C2). In body axes the inertia is constant and diagonal, and
//   I w' = T - w x I w,   q' = 1/2 q w.
// Free rotation about axis i alone: angle a = dt w_i; the momentum L = I w turns by -a about it (it rests in
// the world), the body by +a.
#include "engine/rotation.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

namespace feder {
namespace {

// a <- a * b
void multiply(double* a, const double* b) {
  const double w = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3];
  const double x = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2];
  const double y = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1];
  const double z = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0];
  a[0] = w, a[1] = x, a[2] = y, a[3] = z;
}

void rotate_about(int axis, double dt, const Vector3d& moments, Vector3d& momentum, double* quaternion) {
  const double angle = dt * momentum[axis] / moments[axis], c = std::cos(angle), s = std::sin(angle);
  const int j = (axis + 1) % 3, k = (axis + 2) % 3;
  const double Lj = momentum[j], Lk = momentum[k];
  momentum[j] = c * Lj + s * Lk;
  momentum[k] = c * Lk - s * Lj;
  double step[4] = {std::cos(0.5 * angle), 0.0, 0.0, 0.0};
  step[1 + axis] = std::sin(0.5 * angle);
  multiply(quaternion, step);
}

}  // namespace

Matrix3d skew(const Vector3d& a) {
  Matrix3d m;
  m << 0.0, -a[2], a[1], a[2], 0.0, -a[0], -a[1], a[0], 0.0;
  return m;
}

Matrix3d rotation_matrix(const double* q) {
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  Matrix3d R;
  R << 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),  //
      2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),   //
      2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y);
  return R;
}

void normalise(double* q) {
  const double inverse = 1.0 / std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (int i = 0; i < 4; ++i) q[i] *= inverse;
}

void turn(const Vector3d& theta, RotationUpdate update, double* quaternion) {
  const double half = 0.5 * theta.norm();
  double scalar = 1.0, vector = 0.5;
  if (update == RotationUpdate::kExponential) {
    scalar = std::cos(half);
    vector = half > 1e-4 ? 0.5 * std::sin(half) / half : 0.5 * (1.0 - half * half / 6.0);
  }
  const double step[4] = {scalar, vector * theta[0], vector * theta[1], vector * theta[2]};
  multiply(quaternion, step);
  normalise(quaternion);
}

Matrix3d right_jacobian(const Vector3d& theta) {
  const double squared = theta.squaredNorm(), angle = std::sqrt(squared);
  const bool small = angle < 1e-3;  // series: error below 1e-14
  const double a = small ? 0.5 - squared / 24.0 : (1.0 - std::cos(angle)) / squared;
  const double b = small ? 1.0 / 6.0 - squared / 120.0 : (angle - std::sin(angle)) / (angle * squared);
  const Matrix3d S = skew(theta);
  return Matrix3d::Identity() - a * S + b * S * S;
}

void quaternion_rate(const double* quaternion, const Vector3d& w, double* rate) {
  const double half[4] = {0.0, 0.5 * w[0], 0.5 * w[1], 0.5 * w[2]};
  for (int i = 0; i < 4; ++i) rate[i] = quaternion[i];
  multiply(rate, half);
}

void rotate_freely(const Vector3d& moments, double dt, Vector3d& w, double* quaternion) {
  Vector3d momentum = moments.cwiseProduct(w);
  const int axes[5] = {0, 1, 2, 1, 0};
  for (int i = 0; i < 5; ++i) rotate_about(axes[i], i == 2 ? dt : 0.5 * dt, moments, momentum, quaternion);
  normalise(quaternion);
  w = momentum.cwiseQuotient(moments);
}

Vector3d implicit_gyroscopic_step(const Vector3d& moments, double dt, const Vector3d& w) {
  constexpr int kMostIterations = 50;
  const Matrix3d inertia = moments.asDiagonal();
  const double scale = moments.cwiseProduct(w).norm();
  Vector3d next = w;
  auto residual = [&](const Vector3d& x) -> Vector3d {
    return moments.cwiseProduct(x - w) + dt * x.cross(moments.cwiseProduct(x));
  };
  Vector3d f = residual(next);
  for (int i = 0; i < kMostIterations; ++i) {
    if (f.norm() <= 4.0 * std::numeric_limits<double>::epsilon() * scale) return next;
    const Matrix3d slope = inertia + dt * (skew(next) * inertia - skew(moments.cwiseProduct(next)));
    const Vector3d change = slope.inverse() * f;
    // halve the step while it does not come nearer; at rounding nothing does
    double step = 1.0;
    Vector3d trial = next - change, at_trial = residual(trial);
    for (int cut = 0; cut < 30 && !(at_trial.norm() < f.norm()); ++cut) {
      step *= 0.5;
      trial = next - step * change;
      at_trial = residual(trial);
    }
    if (!(at_trial.norm() < f.norm())) break;
    next = trial;
    f = at_trial;
  }
  return f.norm() <= 1e-12 * scale ? next : Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace feder
