// A cloud of fluid particles around two moving bodies that hold boundary samples.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <memory>

#include "engine/fluid/fluid.h"
#include "engine/system.h"
#include "tests/support/random.h"

namespace feder {

struct RandomFluid {
  FluidMaterial material = {.support = 0.5, .rest_density = 900.0, .sound_speed = 3.0};
  int particles = 60;
  int samples = 12;   ///< per body
  bool walls = true;  ///< also samples of the world and on a particle that is no fluid
};

inline SystemBuilder::Built random_fluid(Random& random, const RandomFluid& options) {
  SystemBuilder builder;
  const int D = options.material.dimension;
  const FreeMask free = static_cast<FreeMask>((1 << D) - 1);
  auto place = [&](double size) {
    Vector3d x = random.vector(size);
    for (int c = D; c < 3; ++c) x[c] = 0.0;
    return x;
  };
  std::vector<int> fluid;
  std::vector<BoundarySample> boundary;
  const double volume = std::pow(1.6, D);
  for (int i = 0; i < options.particles; ++i) {
    const double mass = options.material.rest_density * volume / options.particles * random.uniform(0.8, 1.6);
    fluid.push_back(builder.add_particle(mass, place(0.8), place(2.0), free).node);
  }
  for (int b = 0; b < 2; ++b) {
    const MassProperties properties = solid_box("body", 40.0, {0.4, 0.3, 0.2});
    SystemBuilder::BodyStart start;
    start.position = place(0.5);
    start.velocity = place(1.0);
    if (D == 3) {
      start.orientation =
          Eigen::Quaterniond(Eigen::Vector4d(random.numbers(4))).normalized().toRotationMatrix();
      start.angular_velocity = random.vector(3.0);
    } else {
      start.free = free;
      start.free_spin = D == 2 ? 4 : 0;
      start.angular_velocity = {0.0, 0.0, D == 2 ? 2.0 : 0.0};
    }
    const Anchor body = builder.add_body(properties, start);
    for (int k = 0; k < options.samples; ++k) {
      BoundarySample sample{{.body = body.body, .point = place(0.3)}};
      if (k % 2) {  // with a pressure of its own
        sample.volume = volume / options.particles;
        sample.density = 0.4 * options.material.rest_density;
      }
      boundary.push_back(sample);
    }
  }
  if (options.walls) {
    boundary.push_back({{.point = place(0.6)}});
    boundary.push_back({{builder.add_particle(3.0, place(0.4), place(1.0), free).node}});
  }
  builder.set_fluid(std::make_shared<Fluid>(options.material, fluid, boundary));
  return builder.build();
}

}  // namespace feder
