// Small systems with every kind of row, in general position.
#pragma once

#include <limits>
#include <utility>
#include <vector>

#include "engine/system.h"
#include "tests/support/random.h"

namespace feder {

/// Potential c/4 r^4 between two nodes: a user force whose stiffness changes with the state.
inline UserForce quartic_bond(int i, int j, double c) {
  auto between = [i, j](const VectorXd& q) { return Vector3d(q.segment<3>(3 * i) - q.segment<3>(3 * j)); };
  UserForce user;
  user.force = [=](double, const VectorXd& q, const VectorXd&, VectorXd& force) {
    const Vector3d d = between(q), f = -c * d.squaredNorm() * d;
    force.segment<3>(3 * i) += f;
    force.segment<3>(3 * j) -= f;
  };
  user.potential = [=](double, const VectorXd& q) {
    const double r2 = between(q).squaredNorm();
    return 0.25 * c * r2 * r2;
  };
  user.stiffness = [=](double, const VectorXd& q, const VectorXd&, double* stiffness) {
    const Vector3d d = between(q);
    const Matrix3d K = c * (d.squaredNorm() * Matrix3d::Identity() + 2.0 * d * d.transpose());
    for (int r = 0; r < 6; ++r)
      for (int s = 0; s < 6; ++s) stiffness[6 * r + s] = (r / 3 == s / 3 ? 1.0 : -1.0) * K(r % 3, s % 3);
  };
  user.stencils = {{i, j}};
  return user;
}

struct TestScene {
  System system;
  State state;
};

struct SceneParts {
  bool rods = true;         ///< hard distance rows
  bool hard_angle = false;  ///< a hard angle row
  bool bending = true;
  bool damping = true;  ///< of rows, and drag
  bool user_force = true;
};

/// Twelve nodes along a wavy line: a world point, a bead on a rail, a bead in a plane, free particles;
/// springs (stretched, compressed, doubled, of zero rest length, switched off), rods, bending, gravity, drag,
/// a constant and a user force.
inline TestScene mixed_scene(std::uint64_t seed, const SceneParts& parts = {}) {
  Random random(seed);
  SystemBuilder builder;
  auto tau = [&](double value) { return parts.damping ? value : 0.0; };
  std::vector<Anchor> at;
  for (int i = 0; i < 12; ++i) {
    const Vector3d x = Vector3d(1.0 * i, 0.5 * (i % 2), 0.3 * (i % 3)) + random.vector(0.2);
    if (i == 0) {
      at.push_back(builder.add_world_point(x));
      continue;
    }
    const FreeMask free = i == 3 ? FreeMask{1} : i == 7 ? kPlanarXY : kFree;
    Vector3d v = random.vector();
    for (int c = 0; c < 3; ++c)
      if (!(free >> c & 1)) v[c] = 0.0;
    at.push_back(builder.add_particle(random.uniform(0.1, 2.0), x, v, free));
  }
  for (int i = 0; i + 1 < 12; ++i)  // every other one compressed
    builder.add_distance(at[i], at[i + 1], {random.uniform(5.0, 50.0), tau(i % 3 == 0 ? 0.02 : 0.0)},
                         i % 2 ? 1.5 : 0.7);
  builder.add_distance(at[9], at[2], {12.0, tau(0.1)});
  builder.add_distance(at[2], at[9], {3.0}, 1.0);  // the same pair again
  builder.add_distance(at[4], at[10], {0.0, 0.3}, 1.0);
  builder.add_distance(at[5], at[8], {7.0}, 0.0);
  if (parts.rods) {
    builder.add_distance(at[1], at[6], {kRigid});
    builder.add_distance(at[11], at[0], {kRigid, 0.05}, 11.0);
  }
  if (parts.bending) {
    builder.add(CurvatureRow{{1, 2, 3}, 4.0, tau(0.03)});
    builder.add(AngleRow{{4, 5, 6}, 6.0, 0.0, 1.0});
    builder.add(CurvatureRow{{7, 9, 8}, 0.5, 0.0});
    builder.add(AngleRow{{8, 10, 11}, 0.0, 0.0, 0.5});
    builder.add(AngleRow{{9, 10, 0}, 2.0, tau(0.2), 2.0});
  }
  if (parts.hard_angle) builder.add(AngleRow{{2, 4, 7}, kRigid, 0.0, 0.6});
  builder.set_gravity({0.1, -9.81, 0.3});
  if (parts.damping) builder.set_drag(0.4);
  builder.add_constant_force(at[5], {1.0, 2.0, 3.0});
  builder.add_constant_force(at[7], {0.5, 0.5, 0.5});  // the plane takes the part along z
  if (parts.user_force) builder.set_user_force(quartic_bond(4, 8, 0.3));
  auto [system, state] = builder.build();
  state.t = 0.7;
  return {std::move(system), std::move(state)};
}

}  // namespace feder
