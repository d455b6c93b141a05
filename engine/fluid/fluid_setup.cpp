// What a fluid is checked for, and the masses of its boundary samples: rho_0 V_b, V_b = 1 / sum_k W(x_b -
// x_k) over the samples of the same holder (Akinci et al., ACM TOG 31, 2012, eq. 4).
#include <cmath>
#include <limits>
#include <map>

#include "engine/check.h"
#include "engine/fluid/fluid.h"
#include "engine/system.h"

namespace feder {

Fluid::Fluid(const FluidMaterial& material, std::vector<int> particles, std::vector<BoundarySample> boundary)
    : material_(material), particles_(std::move(particles)), boundary_(std::move(boundary)) {
  const std::string where = "fluid";
  const FluidMaterial& m = material_;
  if (m.dimension < 1 || m.dimension > 3) fail_input(where, "dimension", m.dimension, "", "1, 2 or 3");
  if (!smooths_density(m.kernel) || !is_defined(m.kernel, m.dimension))
    throw InputError(where + ": kernel = " + to_string(m.kernel) + ", expected one that is finite at 0");
  require_positive(where, "support", m.support, "m");
  require_positive(where, "rest density", m.rest_density, "kg/m^D");
  if (m.sound_speed != std::numeric_limits<double>::infinity())
    require_positive(where, "sound speed", m.sound_speed, "m/s");
  if (!(m.exponent >= 1.0 && m.exponent <= 100.0))
    fail_input(where, "exponent", m.exponent, "", "a value from 1 to 100");
  require_non_negative(where, "viscosity", m.viscosity, "Pa s");
  require_non_negative(where, "wall drag", m.wall_drag, "");
}

// Particles, each once, that do not move out of the line or plane of the fluid.
void Fluid::check_particles(const System& s) const {
  const int nodes = s.places() - static_cast<int>(s.bodies.size());
  std::vector<char> seen(nodes, 0);
  const FreeMask across = static_cast<FreeMask>(kFree & ~((1 << material_.dimension) - 1));
  for (int node : particles_) {
    if (node < 0 || node >= nodes) fail_input("fluid", "node", node, "", "an existing particle");
    const std::string where = "fluid, node " + std::to_string(node);
    if (s.mass[node] <= 0.0) fail_input(where, "mass", s.mass[node], "kg", "a particle, which has mass");
    if (seen[node]++) throw InputError(where + ": named twice, expected once");
    if (s.free[node] & across)
      fail_input(
          where, "free mask", s.free[node], "",
          "a particle masked across the fluid's " + std::to_string(material_.dimension) + " dimensions");
  }
}

void Fluid::resolve(const System& s, const VectorXd& q) {
  check_particles(s);
  samples_.clear();
  masses_.clear();
  for (int node : particles_) masses_.push_back(s.mass[node]);
  const int nodes = s.places() - static_cast<int>(s.bodies.size());
  own_densities_.clear();
  for (const auto& [at, volume, density] : boundary_) {
    require_non_negative("fluid boundary", "volume", volume, "m^D");
    require_non_negative("fluid boundary", "density", density, "kg/m^D");
    own_densities_.push_back(density);
    for (int c = 0; c < 3; ++c) require_finite("fluid boundary", "point", at.point[c], "m");
    if (at.body >= static_cast<int>(s.bodies.size()))
      fail_input("fluid boundary", "body", at.body, "", "an existing body");
    if (at.body < 0 && at.node >= nodes)
      fail_input("fluid boundary", "node", at.node, "", "an existing node");
    if (at.body >= 0) {
      const Body& b = s.bodies[at.body];
      samples_.push_back({b.centre, b.spin, b.quaternion, b.axes.transpose() * (at.point - b.centre_point)});
    } else {
      samples_.push_back({at.node, -1, -1, at.point});
    }
  }
  find_volumes(q);
}

void Fluid::find_volumes(const VectorXd& q) {
  std::map<int, std::vector<int>> held;  // by body; everything else is one holder
  for (std::size_t b = 0; b < samples_.size(); ++b)
    if (boundary_[b].volume == 0.0) held[samples_[b].spin].push_back(static_cast<int>(b));
  masses_.resize(particles_.size() + samples_.size());
  for (std::size_t b = 0; b < samples_.size(); ++b)
    masses_[particles_.size() + b] = material_.rest_density * boundary_[b].volume;
  const int D = material_.dimension;
  FluidPairs pairs;
  for (const auto& [holder, list] : held) {
    std::vector<double> at;
    for (int b : list) {
      const Vector3d x = sample_position(samples_[b], q);
      at.insert(at.end(), x.data(), x.data() + D);
    }
    const int count = static_cast<int>(list.size());
    pairs.find(material_.kernel, D, material_.support, count, at, std::vector<double>(list.size(), 1.0));
    for (int i = 0; i < count; ++i)
      masses_[particles_.size() + list[pairs.point(i)]] = material_.rest_density / pairs.density[i];
  }
}

}  // namespace feder
