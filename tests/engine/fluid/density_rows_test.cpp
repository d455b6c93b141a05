// Density as a row: its Jacobian, and what it takes from the sound speed.
#include "engine/fluid/density_rows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/body.h"
#include "tests/engine/fluid/random_fluid.h"
#include "tests/support/finite_difference.h"

namespace feder {
namespace {

TEST(DensityRows, JacobianIsTheDerivativeOfTheDensities) {
  Random random(3);
  for (int dimension = 1; dimension <= 3; ++dimension) {
    RandomFluid options;
    options.material.dimension = dimension;
    options.particles = 20;
    const auto [system, state] = random_fluid(random, options);
    DensityRows density;
    ASSERT_TRUE(density.evaluate(*system.fluid, state.q, 1e-3));
    const auto& rows = density.rows;
    ASSERT_EQ(rows.count(), 20 + 2 * 6);  // half of the samples have a pressure
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows.count(), state.v.size());
    for (int k = 0; k < rows.count(); ++k)
      for (int i = rows.first[k]; i < rows.first[k + 1]; ++i) {
        EXPECT_EQ(J(k, rows.column[i]), 0.0) << "a column twice";
        J(k, rows.column[i]) = -rows.value[i];
      }
    const Eigen::MatrixXd expected = finite_jacobian(
        [&](const VectorXd& step) {
          VectorXd q, rho;
          advance(system, 1.0, step, state.q, q);
          FluidPairs pairs;
          (void)system.fluid->find_pairs(q, pairs);
          rho.resize(rows.count());
          for (int i = 0; i < pairs.size(); ++i)
            for (int k = 0; k < rows.count(); ++k)
              if (density.point_of[k] == pairs.point(i)) rho[k] = pairs.density[i];
          return VectorXd(rho / options.material.rest_density);
        },
        VectorXd::Zero(state.v.size()), 1e-5);
    const double size = expected.cwiseAbs().maxCoeff();
    EXPECT_GT(size, 0.1);
    for (int c = 0; c < J.cols(); ++c) {
      const int node = c / 3;
      const bool counted = system.free[node] >> (c % 3) & 1;
      if (counted) EXPECT_LT((J.col(c) - expected.col(c)).lpNorm<Eigen::Infinity>(), 1e-8 * size) << c;
    }
    for (const Body& b : system.bodies)
      EXPECT_EQ(J.middleCols(3 * b.spin, 3).norm() > 1e-3 * size, dimension > 1);
  }
}

TEST(DensityRows, HoldTheViolationAndTheStepInTheRightHandSide) {
  Random random(4);
  const auto [system, state] = random_fluid(random, {});
  DensityRows density;
  ASSERT_TRUE(density.evaluate(*system.fluid, state.q, 0.01));
  VectorXd rho;
  system.fluid->densities(state.q, rho);
  EXPECT_GT(density.phi.lpNorm<Eigen::Infinity>(), 0.1);
  EXPECT_LT(
      (density.phi.head(rho.size()) - (rho / 900.0).array().matrix() + VectorXd::Ones(rho.size())).norm(),
      1e-12);
  EXPECT_LT((density.rows.r + density.phi / 0.01).norm(), 1e-12);
  EXPECT_TRUE(density.rows.unilateral);
  // y/dt = -m c^2 phi where the rows do not move
  const double m = system.fluid->masses()[0];
  EXPECT_NEAR(density.rows.gamma[0], 1.0 / (1e-4 * m * 9.0), 1e-12 / (1e-4 * m * 9.0));
}

TEST(DensityRows, PushLikeThePressureOfTheSameMultiplier) {
  // J^T lambda with lambda = m p rho_0/rho^2 is the pressure force
  Random random(5);
  RandomFluid options;
  options.material.clamp_tension = false;
  const auto [system, state] = random_fluid(random, options);
  const Fluid& fluid = *system.fluid;
  DensityRows density;
  ASSERT_TRUE(density.evaluate(fluid, state.q, 0.01));
  VectorXd force = VectorXd::Zero(state.v.size()), pushed = force;
  fluid.add_forces(state.q, state.v, force);
  for (int k = 0; k < density.rows.count(); ++k) {
    const double rho = 900.0 * (1.0 + density.phi[k]), m = fluid.masses()[density.point_of[k]];
    density.rows.push_row(k, m * fluid.pressure(rho) * 900.0 / (rho * rho),
                          VectorXd::Ones(force.size()).eval().data(), pushed.data());
  }
  EXPECT_GT(force.norm(), 1.0);
  EXPECT_LT((force - pushed).norm(), 1e-12 * force.norm());
}

}  // namespace
}  // namespace feder
