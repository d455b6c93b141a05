// Equation of state p = rho_0 c^2/g ((rho/rho_0)^g - 1); from E = sum m_i u(rho_i), du/drho = p/rho^2,
//   F_ij = -m_i m_j (p_i/rho_i^2 + p_j/rho_j^2) grad W_ij        (p = 0 at samples without a density)
// Viscosity along the line of centres, which keeps angular momentum, too (Monaghan, Rep. Prog. Phys. 68,
// 2005, with the factor 2 (D + 2) of Espanol and Revenga, Phys. Rev. E 67, 2003):
//   F_ij = 2 (D + 2) mu m_i m_j/(rho_i rho_j) (v_ij.x_ij)/r^2 grad W_ij
#include "engine/fluid/fluid.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/body.h"
#include "engine/fluid/fluid_forces.h"

namespace feder {
namespace {

// The workspace of a thread.
struct Workspace {
  FluidPairs pairs;
  FluidForces forces;
  std::vector<double> velocity;
};
Workspace& workspace() {
  static thread_local Workspace own;
  return own;
}

}  // namespace

double Fluid::pressure(double rho) const {
  if (incompressible() || (material_.clamp_tension && rho <= material_.rest_density)) return 0.0;
  const double c = material_.sound_speed, g = material_.exponent;
  return material_.rest_density * c * c / g * std::expm1(g * std::log(rho / material_.rest_density));
}

double Fluid::energy_per_mass(double rho) const {
  if (incompressible() || (material_.clamp_tension && rho <= material_.rest_density)) return 0.0;
  const double c = material_.sound_speed, g = material_.exponent, s = rho / material_.rest_density;
  if (g == 1.0) return c * c * (std::log(s) + (1.0 - s) / s);
  return c * c / g * (std::expm1((g - 1.0) * std::log(s)) / (g - 1.0) + (1.0 - s) / s);
}

Vector3d sample_position(const Place& sample, const VectorXd& q) {
  if (sample.node < 0) return sample.point;
  const Vector3d centre = q.segment<3>(3 * sample.node);
  return sample.spin < 0 ? centre : Vector3d(centre + rotation(sample, q.data()) * sample.point);
}

bool Fluid::find_pairs(const VectorXd& q, FluidPairs& pairs, int* bad) const {
  static thread_local std::vector<double> at;
  const int D = material_.dimension, fluid = static_cast<int>(particles_.size());
  at.resize(D * masses_.size());
  for (int i = 0; i < fluid; ++i)
    for (int c = 0; c < D; ++c) at[D * i + c] = q[3 * particles_[i] + c];
  for (std::size_t b = 0; b < samples_.size(); ++b) {
    const Vector3d x = sample_position(samples_[b], q);
    for (int c = 0; c < D; ++c) at[D * (fluid + b) + c] = x[c];
  }
  for (std::size_t i = 0; i < at.size(); ++i)
    if (!std::isfinite(at[i])) {
      if (bad) *bad = static_cast<int>(i) / D;
      return false;
    }
  pairs.find(material_.kernel, D, material_.support, fluid, at, masses_, own_densities_);
  return true;
}

void Fluid::densities(const VectorXd& q, VectorXd& rho) const {
  FluidPairs& pairs = workspace().pairs;
  rho.setConstant(static_cast<Eigen::Index>(particles_.size()), std::numeric_limits<double>::quiet_NaN());
  if (!find_pairs(q, pairs)) return;
  for (int i = 0; i < pairs.size(); ++i)
    if (pairs.is_fluid(i)) rho[pairs.point(i)] = pairs.density[i];
}

double Fluid::energy(const VectorXd& q) const {
  if (incompressible()) return 0.0;
  FluidPairs& pairs = workspace().pairs;
  if (!find_pairs(q, pairs)) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0.0;
  for (int i = 0; i < pairs.size(); ++i)
    if (has_pressure(pairs.point(i))) sum += pairs.mass[i] * energy_per_mass(pairs.density[i]);
  return sum;
}

void Fluid::add_forces(const VectorXd& q, const VectorXd& v, VectorXd& f) const {
  const int D = material_.dimension, fluid = static_cast<int>(particles_.size());
  if (incompressible() && material_.viscosity == 0.0) return;
  Workspace& w = workspace();
  int bad = 0;
  if (!find_pairs(q, w.pairs, &bad)) {
    constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
    f.segment<3>(3 * (bad < fluid ? particles_[bad] : samples_[bad - fluid].node)).setConstant(kNaN);
    if (bad >= fluid)  // what holds a sample may be masked along every axis
      for (int node : particles_) f.segment<3>(3 * node).setConstant(kNaN);
    return;
  }
  if (material_.viscosity > 0.0) {
    w.velocity.assign(D * masses_.size(), 0.0);
    for (int i = 0; i < fluid; ++i)
      for (int c = 0; c < D; ++c) w.velocity[D * i + c] = v[3 * particles_[i] + c];
    for (std::size_t b = 0; b < samples_.size(); ++b) {
      const Place& at = samples_[b];
      if (at.node < 0) continue;
      Vector3d u = v.segment<3>(3 * at.node);  // v + R (w x s)
      if (at.spin >= 0) u += rotation(at, q.data()) * Vector3d(v.segment<3>(3 * at.spin)).cross(at.point);
      for (int c = 0; c < D; ++c) w.velocity[D * (fluid + b) + c] = u[c];
    }
  }
  w.forces.evaluate(*this, w.pairs, w.velocity);
  for (int i = 0; i < w.pairs.size(); ++i) {
    const int point = w.pairs.point(i);
    Vector3d force = Vector3d::Zero();
    for (int c = 0; c < D; ++c) force[c] = w.forces.f[D * i + c];
    if (point < fluid) {
      f.segment<3>(3 * particles_[point]) += force;
      continue;
    }
    const Place& at = samples_[point - fluid];
    if (at.node < 0) continue;
    f.segment<3>(3 * at.node) += force;
    if (at.spin >= 0)  // torque in principal axes: s x R^T F
      f.segment<3>(3 * at.spin) += at.point.cross(Vector3d(rotation(at, q.data()).transpose() * force));
  }
}

}  // namespace feder
