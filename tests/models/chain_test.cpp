#include "models/chain.h"

#include <gtest/gtest.h>

#include "engine/check.h"
#include "tests/models/dense.h"

namespace feder {
namespace {

TEST(Chain, FrequenciesAreTheEigenvaluesOfTheAssembledPencil) {
  for (int n : {1, 2, 10, 57}) {
    Chain o;
    o.n = n, o.modes = {{1, 1e-3}};
    const Model model = make_chain(o);
    ASSERT_EQ(model.system.free_count, n);
    const VectorXd omega =
        pencil_frequencies(dense_stiffness(model.system, model.state.q), dense_mass(model.system));
    double worst = 0.0;
    for (int j = 1; j <= n; ++j)
      worst = std::max(worst, std::abs(omega[j - 1] / chain_frequency(o, j) - 1.0));
    ASSERT_GT(omega[0], 1.0);
    EXPECT_LT(worst, 1e-12) << n;  // 4.6e-14 at n = 57
  }
}

TEST(Chain, NegativeModeNumbersCountFromTheHighest) {
  Chain from_end, from_start;
  from_end.modes = {{-1, 1e-3}};
  from_start.modes = {{10, 1e-3}};
  EXPECT_TRUE(make_chain(from_end).state.q == make_chain(from_start).state.q);
  from_start.modes = {{9, 1e-3}};
  EXPECT_FALSE(make_chain(from_end).state.q == make_chain(from_start).state.q);
}

TEST(Chain, KeepsItsOrderUpToTheAmplitudeItRefuses) {
  Chain o;
  const double largest = o.rest_length / (2.0 * std::sin(3.141592653589793 / (2.0 * (o.n + 1))));
  o.modes = {{1, 0.999 * largest}};
  const Model model = make_chain(o);
  for (int i = 0; i <= 100; ++i) {
    const State s = model.exact(i * model.end_time / 100.0);
    for (int k = 0; k <= o.n; ++k) EXPECT_GT(s.q[3 * k + 3], s.q[3 * k]);
  }
  o.modes = {{1, 1.001 * largest}};
  EXPECT_THROW(make_chain(o), InputError);
}

TEST(Chain, DampedMotionLosesItsEnergy) {
  Chain o;
  o.damping_time = 1e-2, o.drag = 0.1;
  const Model model = make_chain(o);
  const State end = model.exact(10.0 * model.end_time);
  EXPECT_GT((model.exact(0.0).q - end.q).norm(), 1e-3);
  EXPECT_LT(end.v.norm(), 1e-12);
  EXPECT_TRUE(model.conserved.empty());
}

}  // namespace
}  // namespace feder
