// d phi_i / d x_i = sum_j m_j/rho_0 grad W_ij,  d phi_i / d x_j = -m_j/rho_0 grad W_ij; by the spin of a body
// that holds sample j: s x R^T (d phi_i / d x_j).
#include "engine/fluid/density_rows.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/body.h"

namespace feder {
namespace {

constexpr double kRounding = 1e-15;

}  // namespace

// Pairs from both sides: those of place i are around_[start_[i]] to around_[start_[i + 1] - 1].
void DensityRows::list_neighbours() {
  const int places = pairs_.size();
  place_of_.resize(places);
  start_.assign(places + 1, 0);
  for (int i = 0; i < places; ++i) {
    place_of_[pairs_.point(i)] = i;
    for (int k = pairs_.first[i]; k < pairs_.first[i + 1]; ++k)
      ++start_[i + 1], ++start_[pairs_.neighbour[k] + 1];
  }
  for (int i = 0; i < places; ++i) start_[i + 1] += start_[i];
  around_.resize(start_[places]);
  std::vector<int> next(start_.begin(), start_.end() - 1);
  for (int i = 0; i < places; ++i)
    for (int k = pairs_.first[i]; k < pairs_.first[i + 1]; ++k) {
      const int j = pairs_.neighbour[k];
      around_[next[i]++] = {j, pairs_.slope[k]};
      around_[next[j]++] = {i, pairs_.slope[k]};
    }
}

// The gradient of -phi by the place of a point, for the one who holds it: at once at particles, gathered at
// others.
void DensityRows::add_gradient(const Fluid& fluid, const VectorXd& q, int point, const Vector3d& gradient) {
  const int D = fluid.material().dimension, particles = static_cast<int>(fluid.particles().size());
  if (point < particles) {
    for (int c = 0; c < D; ++c) rows.add(3 * fluid.particles()[point] + c, gradient[c]);
    return;
  }
  const Place& at = fluid.samples()[point - particles];
  if (at.node < 0) return;
  std::size_t s = 0;
  while (s < held_.size() && held_[s].node != at.node) ++s;
  if (s == held_.size()) held_.push_back({at.node, at.spin, Vector3d::Zero(), Vector3d::Zero()});
  held_[s].force += gradient;
  if (at.spin >= 0)
    held_[s].torque += at.point.cross(Vector3d(rotation(at, q.data()).transpose() * gradient));
}

bool DensityRows::evaluate(const Fluid& fluid, const VectorXd& q, double dt) {
  const FluidMaterial& m = fluid.material();
  const int D = m.dimension, points = static_cast<int>(fluid.masses().size());
  rows.clear();
  rows.unilateral = m.clamp_tension;
  if (!fluid.find_pairs(q, pairs_)) return false;
  list_neighbours();
  point_of.clear();
  for (int point = 0; point < points; ++point)
    if (fluid.has_pressure(point)) point_of.push_back(point);
  const int count = static_cast<int>(point_of.size());
  phi.resize(count);
  rows.r.resize(count);
  rows.gamma.setZero(count);
  for (int k = 0; k < count; ++k) {
    const int i = place_of_[point_of[k]];
    phi[k] = pairs_.density[i] / m.rest_density - 1.0;
    Vector3d own = Vector3d::Zero(), size = Vector3d::Zero();
    held_.clear();
    for (int n = start_[i]; n < start_[i + 1]; ++n) {
      const auto [j, slope] = around_[n];
      Vector3d gradient = Vector3d::Zero();
      for (int c = 0; c < D; ++c)
        gradient[c] = -pairs_.mass[j] / m.rest_density * slope * (pairs_.x[c][i] - pairs_.x[c][j]);
      own += gradient;
      size += gradient.cwiseAbs();
      add_gradient(fluid, q, pairs_.point(j), -gradient);
    }
    for (int c = 0; c < D; ++c)  // what neighbours on all sides leave of their sum is rounding
      if (std::abs(own[c]) <= kRounding * size[c]) own[c] = 0.0;
    add_gradient(fluid, q, point_of[k], own);
    for (const Held& h : held_) {
      for (int c = 0; c < D; ++c) rows.add(3 * h.node + c, h.force[c]);
      for (int c = 0; c < 3 && h.spin >= 0; ++c) rows.add(3 * h.spin + c, h.torque[c]);
    }
    rows.close_row();
    rows.r[k] = -phi[k] / dt;
    if (!fluid.incompressible())
      rows.gamma[k] = 1.0 / (dt * dt * pairs_.mass[i] * m.sound_speed * m.sound_speed);
  }
  return true;
}

}  // namespace feder
