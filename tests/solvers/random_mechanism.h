#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "engine/kkt.h"

namespace feder::test {

/// A random tree of bodies hung from the world: ball joints or hinges, hard or soft, closed at the start and
/// moving as one rigid body would, so that hard rows hold in position and velocity; springs between random
/// points.
inline SystemBuilder::Built random_mechanism(unsigned seed, int bodies, double hard_share, double stiffness) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  auto vector = [&] { return Vector3d(unit(random), unit(random), unit(random)); };
  auto rotation = [&] {
    const Vector3d theta = 3.0 * vector();
    return Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix();
  };
  SystemBuilder builder;
  const Anchor world = builder.add_world_point(Vector3d::Zero());
  const Vector3d spin = 2.0 * vector();  // everything turns about the world point
  std::vector<Vector3d> origin;
  std::vector<Matrix3d> axes;
  for (int i = 0; i < bodies; ++i) {
    std::vector<PointMass> points;
    for (int k = 0; k < 5; ++k) points.push_back({0.2 + 0.1 * std::abs(unit(random)), 0.3 * vector()});
    const MassProperties lump = point_masses("lump", points);
    origin.push_back(2.0 * vector());
    axes.push_back(rotation());
    const Vector3d centre = origin.back() + axes.back() * lump.centre;
    const Anchor body = builder.add_body(lump, {.position = origin.back(),
                                                .orientation = axes.back(),
                                                .velocity = spin.cross(centre),
                                                .angular_velocity = spin});
    // joint to an earlier body or the world
    const double d = 0.5 * (unit(random) + 1.0) < hard_share ? INFINITY : stiffness;
    const int parent = static_cast<int>(random() % static_cast<unsigned>(i + 1)) - 1;
    const Vector3d at =
        parent < 0 ? Vector3d(Vector3d::Zero()) : Vector3d(origin[parent] + axes[parent] * 0.4 * vector());
    auto local = [&](int b) { return Vector3d(axes[b].transpose() * (at - origin[b])); };
    const Anchor a = parent < 0 ? world : Anchor{.body = parent, .point = local(parent)};
    const Anchor b{.body = body.body, .point = local(i)};
    builder.add(BallRow{{a, b, d}});
    if (parent >= 0 && random() % 2) {  // a hinge
      const Matrix3d frame = rotation();
      const Vector3d axis = axes[parent].transpose() * frame.col(0);
      builder.add(PerpendicularRow{{a, b, d}, axis, axes[i].transpose() * frame.col(1)});
      builder.add(PerpendicularRow{{a, b, d}, axis, axes[i].transpose() * frame.col(2)});
    }
    if (i > 0 && random() % 2)
      builder.add(AnchorDistanceRow{
          {{.body = 0, .point = 0.3 * vector()}, {.body = i, .point = 0.3 * vector()}, 20.0}, 1.0});
  }
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

}  // namespace feder::test
