#pragma once

#include <limits>
#include <random>
#include <vector>

#include "engine/kkt.h"

namespace feder::test {

/// A random net that uses everything at once: particles of spread masses, pins, rails and planar masks,
/// springs, damped springs, curvature and angle rows, drag and gravity; `rods` of its tree edges are rigid
/// (independent by construction).
struct RandomSystemOptions {
  int particles = 12;
  double stiffness = 1e3;  ///< [N/m], spread by a factor of 10 either way
  double damping_time = 0.0;
  int rods = 0;
  bool bending = true;
  bool loops = true;
};

inline SystemBuilder::Built random_system(unsigned seed, const RandomSystemOptions& options) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  auto spread = [&] { return std::pow(10.0, unit(random)); };

  SystemBuilder builder;
  std::vector<Anchor> nodes{builder.add_world_point(vector())};
  for (int i = 0; i < options.particles; ++i) {
    const FreeMask free = i % 7 == 3 ? kPlanarXY : i % 11 == 5 ? FreeMask{4} : i % 13 == 6 ? kPinned : kFree;
    Vector3d v = vector();
    for (int c = 0; c < 3; ++c)
      if (!(free >> c & 1)) v[c] = 0.0;
    nodes.push_back(builder.add_particle(0.1 * spread(), 2.0 * vector(), v, free));
  }
  // a spanning tree, its first edges rigid, then loops; rods only between wholly free nodes
  int rods = 0;
  for (int i = 1; i <= options.particles; ++i) {
    const bool free = (i - 1) % 7 != 3 && (i - 1) % 11 != 5 && (i - 1) % 13 != 6;
    const bool rod = free && rods < options.rods;
    rods += rod;
    const Material material{rod ? std::numeric_limits<double>::infinity() : options.stiffness * spread(),
                            i % 2 ? options.damping_time : 0.0};
    builder.add_distance(nodes[static_cast<std::size_t>(random() % static_cast<unsigned>(i))], nodes[i],
                         material);
  }
  for (int i = 0; options.loops && i < options.particles; ++i) {
    const int a = static_cast<int>(random() % nodes.size()), b = static_cast<int>(random() % nodes.size());
    if (a != b)
      builder.add_distance(nodes[a], nodes[b], {i % 5 == 4 ? 0.0 : options.stiffness * spread(), 0.0}, 0.5);
  }
  for (int i = 2; options.bending && i + 2 <= options.particles; i += 3) {
    builder.add(CurvatureRow{{nodes[i].node, nodes[i + 1].node, nodes[i + 2].node},
                             0.01 * options.stiffness,
                             options.damping_time});
    builder.add(
        AngleRow{{nodes[i - 1].node, nodes[i].node, nodes[i + 1].node}, 0.01 * options.stiffness, 0.0, 1.1});
  }
  builder.set_gravity({0.0, -9.81, 0.0});
  builder.set_drag(0.05);
  return builder.build();
}

/// The step matrix of implicit Euler at a state, as the integrator fills it.
inline Kkt implicit_euler_kkt(const System& system, const State& state, double dt,
                              GeometricStiffness kind = GeometricStiffness::kOff) {
  Kkt kkt;
  kkt.prepare(system);
  kkt.set_step(dt * dt, dt);
  EXPECT_TRUE(kkt.evaluate(state.q).ok());
  kkt.p = system.inertia.cwiseProduct(state.v) + dt * system.forces.constant;
  for (int i : system.masked) kkt.p[i] = 0.0;
  kkt.r = kkt.phi.array() / (dt + system.damping_time.array());
  VectorXd lambda = VectorXd::Zero(system.rows);
  for (int k = 0; k < system.rows; ++k)
    if (std::isfinite(system.stiffness[k])) lambda[k] = -system.stiffness[k] * kkt.phi[k];
  kkt.set_geometric_stiffness(kind, dt * dt, state, lambda);
  return kkt;
}

}  // namespace feder::test
