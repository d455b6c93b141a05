// Random mechanisms whose hard rows depend on each other, at random places and turned at random, so that no
// number is tidy; moving as the joints allow. `shift` moves one anchor of a redundant row, which then
// contradicts the others.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "engine/joints.h"
#include "engine/kkt.h"
#include "tests/support/random.h"

namespace feder::test {

enum class Redundancy { kDoubledHinge, kPlanarLoop, kPlates, kParallelograms };
inline constexpr int kRedundancies = 4;

inline Matrix3d random_rotation(Random& random) {
  const Vector3d theta = random.vector(3.0);
  return Eigen::AngleAxisd(theta.norm(), theta.normalized()).toRotationMatrix();
}

/// A body with random inertia and its own random axes, its origin at `place`.
inline Anchor random_lump(SystemBuilder& builder, Random& random, const Vector3d& place) {
  std::vector<PointMass> points;
  for (int k = 0; k < 5; ++k) points.push_back({random.uniform(0.1, 0.4), random.vector(0.3)});
  return builder.add_body(point_masses("lump", points),
                          {.position = place, .orientation = random_rotation(random)});
}

struct Loop {
  Vector3d origin, x, y, axis;  // plane of a planar mechanism
  Vector3d at(double u, double w) const { return origin + u * x + w * y; }
};

inline Loop random_plane(Random& random) {
  const Matrix3d R = random_rotation(random);
  return {random.vector(2.0), R.col(0), R.col(1), R.col(2)};
}

/// Hinges about parallel axes: bars through `corners`, both ends in the world. 3 redundant rows.
inline void add_planar_loop(SystemBuilder& builder, Random& random, const Loop& plane,
                            const std::vector<Vector3d>& corners) {
  Anchor last{};
  for (std::size_t i = 0; i + 1 < corners.size(); ++i) {
    const Anchor bar = random_lump(builder, random, 0.5 * (corners[i] + corners[i + 1]));
    add_hinge(builder, last, bar, corners[i], plane.axis);
    last = bar;
  }
  add_hinge(builder, last, {}, corners.back(), plane.axis);
}

inline SystemBuilder::Built redundant_mechanism(std::uint64_t seed, Redundancy kind, double shift = 0.0) {
  Random random(seed);
  SystemBuilder builder;
  builder.set_gravity({0.0, -9.81, 0.0});
  const Loop plane = random_plane(random);
  auto point = [&] { return plane.at(random.uniform(), random.uniform()); };
  int doubled = 0;
  if (kind == Redundancy::kDoubledHinge) {  // a chain with one door on two hinges
    Anchor last{};
    const int bodies = 2 + random.below(5);
    doubled = random.below(bodies);
    for (int i = 0; i < bodies; ++i) {
      const Anchor body = random_lump(builder, random, random.vector(2.0));
      const Vector3d place = random.vector(2.0), axis = random.vector().normalized();
      add_hinge(builder, last, body, place, axis);
      if (i == doubled) add_hinge(builder, last, body, place + 0.7 * axis, axis);
      last = body;
    }
  } else if (kind == Redundancy::kPlanarLoop) {  // four to seven bars
    std::vector<Vector3d> corners;
    for (int i = 0; i < 4 + random.below(4); ++i) corners.push_back(point());
    add_planar_loop(builder, random, plane, corners);
  } else if (kind == Redundancy::kPlates) {  // plates with four ball joints between neighbours
    Anchor last{};
    for (int i = 0; i < 1 + random.below(4); ++i) {
      const Anchor plate = random_lump(builder, random, random.vector(2.0));
      for (int k = 0; k < 4; ++k) add_ball(builder, last, plate, random.vector(2.0));
      last = plate;
    }
    add_ball(builder, last, random_lump(builder, random, random.vector(2.0)), random.vector(2.0));
  } else {  // three parallel cranks carry one bar: moves although counted immobile
    const Vector3d crank = 0.8 * (plane.x * std::cos(0.9) + plane.y * std::sin(0.9));
    const Anchor bar = random_lump(builder, random, plane.at(0.5, 0.0) + crank);
    for (double u : {0.0, random.uniform(0.4, 0.9), random.uniform(1.0, 1.5)}) {
      const Anchor arm = random_lump(builder, random, plane.at(u, 0.0) + 0.5 * crank);
      add_hinge(builder, {}, arm, plane.at(u, 0.0), plane.axis);
      add_hinge(builder, arm, bar, plane.at(u, 0.0) + crank, plane.axis);
    }
  }
  SystemBuilder::Built out = builder.build();
  if (shift != 0.0) {  // a row whose removal leaves the rank is part of a dependent set
    auto& balls = std::get<std::vector<BallRow>>(out.system.stencil_rows);
    const std::size_t moved = kind == Redundancy::kDoubledHinge ? static_cast<std::size_t>(doubled) + 1
                              : kind == Redundancy::kPlates     ? 3
                                                                : balls.size() - 1;
    // out of a plane in which a loop would only become another one
    Place& end = balls[moved].at_a.spin >= 0 ? balls[moved].at_a : balls[moved].at_b;
    end.point += shift * rotation_matrix(out.state.q.data() + end.quaternion).transpose() * plane.axis;
  }
  return out;
}

}  // namespace feder::test
