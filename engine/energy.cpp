#include "engine/energy.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/fluid/fluid.h"
#include "engine/kkt.h"

namespace feder {

double kinetic_energy(const System& s, const State& state) {
  return 0.5 * (s.inertia.array() * state.v.array().square()).sum();
}

double kinetic_energy_change(const System& s, const VectorXd& v_before, const VectorXd& v_after) {
  return 0.5 * (s.inertia.array() * (v_after - v_before).array() * (v_after + v_before).array()).sum();
}

double row_energy(const System& s, const State& state) {
  VectorXd phi;
  evaluate_phi(s, state.q, phi);
  double sum = 0.0;
  for (int k = 0; k < s.rows; ++k)
    if (std::isfinite(s.stiffness[k])) sum += 0.5 * s.stiffness[k] * phi[k] * phi[k];
  return sum;
}

double external_energy(const System& s, const State& state) {
  double potential = s.forces.user.potential ? s.forces.user.potential(state.t, state.q) : 0.0;
  for (const LawSpring& spring : s.law_springs)
    if (spring.energy) potential += spring.energy(spring.length(state.q.data()));
  if (s.fluid) potential += s.fluid->energy(state.q);
  return potential - s.forces.constant.head(3 * s.places()).dot(state.q.head(3 * s.places()));
}

double total_energy(const System& s, const State& state) {
  return kinetic_energy(s, state) + row_energy(s, state) + external_energy(s, state);
}

Vector3d linear_momentum(const System& s, const State& state) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < s.nodes; ++i) sum += s.mass[i] * state.v.segment<3>(3 * i);
  return sum;
}

Vector3d angular_momentum(const System& s, const State& state) {
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < s.places(); ++i)
    sum += s.mass[i] * Vector3d(state.q.segment<3>(3 * i)).cross(Vector3d(state.v.segment<3>(3 * i)));
  for (const Body& b : s.bodies)
    sum += rotation_matrix(state.q.data() + b.quaternion) *
           b.moments.cwiseProduct(Vector3d(state.v.segment<3>(3 * b.spin)));
  return sum;
}

double EnergyLedger::magnitude() const {
  return std::abs(kinetic_change) + std::abs(row_change) + std::abs(external_work) + std::abs(drag_work) +
         std::abs(row_work) + std::abs(geometric_work) + std::abs(numerical) + std::abs(contact_work);
}

}  // namespace feder
