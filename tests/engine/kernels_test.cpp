// The scalar kernels against the definition, the vector kernels against the scalar ones.
#include "engine/kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "engine/system.h"
#include "tests/support/kernel_choice.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"

namespace feder {
namespace {

enum class Numbering { kGrid, kShuffled, kRandomNet, kChain };

/// 24 x 17 sheet of springs in general position, some damped, some rods, some of zero rest length.
TestScene sheet(Numbering numbering, std::uint64_t seed) {
  Random random(seed);
  const int width = numbering == Numbering::kChain ? 37 : 24,
            height = numbering == Numbering::kChain ? 1 : 17;
  const int nodes = width * height;
  std::vector<int> name(nodes);
  for (int i = 0; i < nodes; ++i) name[i] = i;
  if (numbering == Numbering::kShuffled)
    for (int i = nodes - 1; i > 0; --i) std::swap(name[i], name[random.below(i + 1)]);
  std::vector<int> cell(nodes);
  for (int i = 0; i < nodes; ++i) cell[name[i]] = i;

  SystemBuilder builder;
  for (int i = 0; i < nodes; ++i) {
    const Vector3d x(cell[i] % width, cell[i] / width, 0.0);
    builder.add_particle(random.uniform(0.1, 3.0), x + random.vector(0.3), random.vector());
  }
  auto connect = [&](int a, int b) {
    const int kind = random.below(10);
    const double d = kind == 0 ? kRigid : random.uniform(1.0, 1e4);
    builder.add_distance({name[a]}, {name[b]}, {d, kind % 2 ? random.uniform(0.0, 0.1) : 0.0},
                         kind == 1 ? 0.0 : random.uniform(0.5, 1.5));
  };
  if (numbering == Numbering::kRandomNet) {
    for (int k = 0; k < 3 * nodes; ++k) {
      const int a = random.below(nodes);
      connect(a, (a + 1 + random.below(nodes - 1)) % nodes);
    }
  } else {
    for (int i = 0; i < nodes; ++i) {
      if (i % width + 1 < width) connect(i, i + 1);
      if (i + width < nodes) connect(i, i + width);
      if (i % width + 1 < width && i + width + 1 < nodes) connect(i, i + width + 1);
    }
  }
  auto [system, state] = builder.build();
  return {std::move(system), std::move(state)};
}

/// All that the distance kernels compute at a state.
struct Evaluation {
  VectorXd u, length, phi, phi_alone, forces, damped, product, weighted, transpose;
  double least_evaluate, least_forces, least_damped;
};

Evaluation evaluate_with(const Kernels& kernel, const TestScene& scene) {
  const DistanceView view = scene.system.distance_view();
  const int m = scene.system.distance.size(), n = 3 * scene.system.nodes;
  Random random(77);
  const VectorXd y = random.numbers(m);
  Evaluation e;
  e.u = VectorXd::Constant(3 * m, NAN);
  e.length = e.phi = e.phi_alone = e.product = e.weighted = VectorXd::Constant(m, NAN);
  e.forces = e.damped = e.transpose = VectorXd::Ones(n);  // they add
  const double *q = scene.state.q.data(), *v = scene.state.v.data();
  e.least_evaluate = kernel.evaluate(view, q, e.u.data(), e.length.data(), e.phi.data());
  VectorXd u_again(3 * m);
  (void)kernel.evaluate(view, q, u_again.data(), nullptr, e.phi_alone.data());
  EXPECT_TRUE((u_again.array() == e.u.array() || (u_again.array().isNaN() && e.u.array().isNaN())).all());
  e.least_forces = kernel.forces(view, q, e.forces.data());
  e.least_damped = kernel.damped_forces(view, q, v, e.damped.data());
  kernel.multiply(view, e.u.data(), v, e.product.data());
  const VectorXd w = random.numbers(n);
  kernel.multiply_weighted(view, e.u.data(), w.data(), v, e.weighted.data());
  kernel.add_transpose(view, e.u.data(), y.data(), e.transpose.data());
  return e;
}

double largest_difference(const VectorXd& x, const VectorXd& y) {
  return (x - y).cwiseAbs().maxCoeff();
}

TEST(ScalarKernels, AgreeWithTheDefinitionRowByRow) {
  const TestScene scene = sheet(Numbering::kShuffled, 1);
  const System& s = scene.system;
  const Evaluation e = evaluate_with(scalar_kernels(), scene);
  Random random(77);
  const VectorXd y = random.numbers(s.distance.size());
  const VectorXd wv = random.numbers(3 * s.nodes).cwiseProduct(scene.state.v);
  VectorXd forces = VectorXd::Ones(3 * s.nodes), damped = forces, transpose = forces;
  double least = kRigid;
  for (int k = 0; k < s.distance.size(); ++k) {
    const int a = 3 * s.distance.a[k], b = 3 * s.distance.b[k];
    const Vector3d d = scene.state.q.segment<3>(b) - scene.state.q.segment<3>(a);
    const Vector3d dv = scene.state.v.segment<3>(b) - scene.state.v.segment<3>(a);
    const Vector3d u = d.normalized();
    least = std::min(least, d.squaredNorm());
    EXPECT_NEAR(e.length[k], d.norm(), 1e-14);                                      // 0
    EXPECT_NEAR(e.phi[k], d.norm() - s.distance.rest[k], 1e-14);                    // 0
    EXPECT_LT((e.u.segment<3>(3 * k) - u).norm(), 1e-15);                           // 2e-16
    EXPECT_NEAR(e.product[k], u.dot(dv), 1e-14);                                    // 4e-16
    EXPECT_NEAR(e.weighted[k], u.dot(wv.segment<3>(b) - wv.segment<3>(a)), 1e-14);  // 2e-16
    if (s.distance.active(k) && std::isfinite(s.distance.stiffness[k])) {
      const double pull = s.distance.stiffness[k] * (d.norm() - s.distance.rest[k]);
      const double drag = s.distance.stiffness[k] * s.distance.damping_time[k] * u.dot(dv);
      forces.segment<3>(a) += pull * u;
      forces.segment<3>(b) -= pull * u;
      damped.segment<3>(a) += (pull + drag) * u;
      damped.segment<3>(b) -= (pull + drag) * u;
    }
    transpose.segment<3>(a) -= y[k] * u;
    transpose.segment<3>(b) += y[k] * u;
  }
  ASSERT_GT(forces.cwiseAbs().maxCoeff(), 1e3);
  ASSERT_GT((damped - forces).cwiseAbs().maxCoeff(), 1e2);
  EXPECT_LT(largest_difference(e.forces, forces), 1e-14 * forces.cwiseAbs().maxCoeff());  // 2e-16
  EXPECT_LT(largest_difference(e.damped, damped), 1e-14 * damped.cwiseAbs().maxCoeff());  // 2e-16
  EXPECT_LT(largest_difference(e.transpose, transpose), 1e-14);                           // 9e-16
  EXPECT_NEAR(e.least_evaluate, least, 1e-15);                                            // 0
  EXPECT_EQ(e.least_forces, e.least_evaluate);
  EXPECT_EQ(e.least_damped, e.least_evaluate);
}

class VectorKernels : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (!choice.available()) GTEST_SKIP() << "this processor has no " << GetParam();
  }
  KernelChoice choice{GetParam()};
};

TEST_P(VectorKernels, AgreeWithTheScalarOnesOnEveryNumbering) {
  for (Numbering numbering :
       {Numbering::kGrid, Numbering::kShuffled, Numbering::kRandomNet, Numbering::kChain})
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      const TestScene scene = sheet(numbering, seed);
      const Evaluation plain = evaluate_with(scalar_kernels(), scene), wide = evaluate_with(kernels(), scene);
      ASSERT_GT(plain.phi.cwiseAbs().maxCoeff(), 0.1);
      ASSERT_GT(plain.product.cwiseAbs().maxCoeff(), 0.1);
      EXPECT_LT(largest_difference(wide.u, plain.u), 1e-15);                // 0
      EXPECT_LT(largest_difference(wide.length, plain.length), 1e-14);      // 0
      EXPECT_LT(largest_difference(wide.phi, plain.phi), 1e-14);            // 0
      EXPECT_LT(largest_difference(wide.product, plain.product), 1e-14);    // 0
      EXPECT_LT(largest_difference(wide.weighted, plain.weighted), 1e-14);  // 0
      EXPECT_TRUE(wide.phi_alone == wide.phi);
      const double largest = plain.forces.cwiseAbs().maxCoeff(), damped = plain.damped.cwiseAbs().maxCoeff();
      ASSERT_GT(largest, 1e3);
      EXPECT_LT(largest_difference(wide.forces, plain.forces),
                1e-14 * largest);  // 1e-17: another order of the sums
      EXPECT_LT(largest_difference(wide.damped, plain.damped), 1e-14 * damped);  // 3e-18
      EXPECT_LT(largest_difference(wide.transpose, plain.transpose), 1e-14);     // 9e-16
      EXPECT_EQ(wide.least_evaluate, plain.least_evaluate);
      EXPECT_EQ(wide.least_forces, plain.least_forces);
      EXPECT_EQ(wide.least_damped, plain.least_damped);
    }
}

TEST_P(VectorKernels, AgreeWithTheScalarOnesWherePointsCoincide) {
  for (Numbering numbering : {Numbering::kGrid, Numbering::kShuffled}) {
    TestScene scene = sheet(numbering, 3);
    const DistanceRows& rows = scene.system.distance;
    for (int k = 0; k < rows.size(); k += 5)
      scene.state.q.segment<3>(3 * rows.b[k]) = scene.state.q.segment<3>(3 * rows.a[k]);
    const Evaluation plain = evaluate_with(scalar_kernels(), scene), wide = evaluate_with(kernels(), scene);
    ASSERT_EQ(plain.least_evaluate, 0.0);
    EXPECT_EQ(wide.least_evaluate, 0.0);
    EXPECT_EQ(wide.least_forces, 0.0);
    EXPECT_EQ(wide.least_damped, 0.0);
    int coincident = 0;
    for (int k = 0; k < rows.size(); ++k)
      if (plain.length[k] == 0.0) {
        ++coincident;
        EXPECT_TRUE(plain.u.segment<3>(3 * k).isZero(0.0));
        EXPECT_TRUE(wide.u.segment<3>(3 * k).isZero(0.0));
        EXPECT_EQ(wide.length[k], 0.0);
        EXPECT_EQ(wide.phi[k], -rows.rest[k]);
      }
    EXPECT_GT(coincident, 50);  // 102
    for (const VectorXd* x : {&wide.u, &wide.length, &wide.phi, &wide.forces, &wide.damped, &wide.product,
                              &wide.weighted, &wide.transpose})
      EXPECT_TRUE(x->allFinite());
    EXPECT_LT(largest_difference(wide.forces, plain.forces),
              1e-14 * plain.forces.cwiseAbs().maxCoeff());  // 0
  }
}

TEST_P(VectorKernels, ReportNotANumberWhereverItSits) {
  const TestScene scene = sheet(Numbering::kGrid, 2);
  for (int i = 0; i < scene.system.nodes; i += 7) {
    TestScene bad = scene;
    bad.state.q[3 * i + i % 3] = NAN;
    const Evaluation plain = evaluate_with(scalar_kernels(), bad), wide = evaluate_with(kernels(), bad);
    EXPECT_TRUE(std::isnan(plain.least_evaluate) && std::isnan(plain.least_forces) &&
                std::isnan(plain.least_damped))
        << i;
    EXPECT_TRUE(std::isnan(wide.least_evaluate) && std::isnan(wide.least_forces) &&
                std::isnan(wide.least_damped))
        << i;
  }
}

TEST_P(VectorKernels, ArrayPassesAgreeWithTheScalarOnesForEveryTail) {
  const Kernels &plain = scalar_kernels(), &wide = kernels();
  Random random(9);
  for (int n = 0; n <= 40; ++n) {
    const VectorXd x = random.numbers(n), y = random.numbers(n), z = random.numbers(n), w = random.numbers(n),
                   m = random.numbers(n / 3 + 1);
    const double a = random.uniform();
    const std::size_t size = static_cast<std::size_t>(n);
    auto both = [&](auto&& pass) {
      VectorXd p = VectorXd::Constant(n + 1, -7.0), q = p;  // the last number must stay
      pass(plain, p.data());
      pass(wide, q.data());
      EXPECT_EQ(p[n], -7.0);
      EXPECT_EQ(q[n], -7.0);
      if (n > 0) {
        EXPECT_GT((p.head(n).array() + 7.0).abs().minCoeff(), 1.0);  // every number was written
        EXPECT_LT(largest_difference(p, q), 1e-15);                  // 0
      }
    };
    both([&](const Kernels& k, double* out) { k.product(size, x.data(), y.data(), out); });
    both([&](const Kernels& k, double* out) { k.drift(size, a, x.data(), y.data(), out); });
    both([&](const Kernels& k, double* out) { k.kick(size, a, x.data(), y.data(), z.data(), out); });
    both([&](const Kernels& k, double* out) { k.momentum(size, m.data(), x.data(), a, y.data(), out); });
    double p_sums[5], w_sums[5], null_sums[5];
    both([&](const Kernels& k, double* out) {
      k.balance(size, x.data(), a, y.data(), z.data(), w.data(), out, &k == &plain ? p_sums : w_sums);
    });
    wide.balance(size, x.data(), a, y.data(), z.data(), w.data(), nullptr, null_sums);
    for (int j = 0; j < 5; ++j) {
      EXPECT_NEAR(w_sums[j], p_sums[j], 1e-14 * (1.0 + p_sums[j])) << n;  // 7e-15
      EXPECT_EQ(null_sums[j], w_sums[j]);
    }
  }
}

TEST_P(VectorKernels, WorkInPlace) {
  const Kernels& wide = kernels();
  Random random(10);
  const int n = 29;
  const VectorXd x = random.numbers(n), y = random.numbers(n), w = random.numbers(n);
  VectorXd out = x;
  wide.product(n, out.data(), y.data(), out.data());
  EXPECT_LT(largest_difference(out, x.cwiseProduct(y)), 1e-15);  // 0
  out = x;
  wide.drift(n, 0.5, y.data(), out.data(), out.data());
  EXPECT_LT(largest_difference(out, x + 0.5 * y), 1e-15);  // 0
  out = x;
  wide.kick(n, 0.5, w.data(), y.data(), out.data(), out.data());
  EXPECT_LT(largest_difference(out, x + 0.5 * w.cwiseProduct(y)), 1e-15);  // 0
}

INSTANTIATE_TEST_SUITE_P(Widths, VectorKernels, testing::Values("avx2", "avx512"),
                         [](const auto& instance) { return instance.param; });

TEST(ScalarKernels, ArrayPassesComputeTheirFormulas) {
  const Kernels& k = scalar_kernels();
  Random random(11);
  const int n = 12;
  const VectorXd x = random.numbers(n), y = random.numbers(n), z = random.numbers(n),
                 m = random.numbers(n / 3);
  VectorXd out(n);
  k.product(n, x.data(), y.data(), out.data());
  EXPECT_LT(largest_difference(out, x.cwiseProduct(y)), 1e-15);  // 0
  k.drift(n, 0.3, y.data(), x.data(), out.data());
  EXPECT_LT(largest_difference(out, x + 0.3 * y), 1e-15);  // 0
  k.kick(n, 0.3, z.data(), y.data(), x.data(), out.data());
  EXPECT_LT(largest_difference(out, x + 0.3 * z.cwiseProduct(y)), 1e-15);  // 6e-17
  k.momentum(n, m.data(), x.data(), 0.3, y.data(), out.data());
  for (int i = 0; i < n; ++i) EXPECT_NEAR(out[i], m[i / 3] * x[i] + 0.3 * y[i], 1e-15);
  double sums[5];
  k.balance(n, x.data(), -2.0, y.data(), z.data(), x.data(), out.data(), sums);
  const VectorXd yz = y.cwiseProduct(z), expected = x - 2.0 * yz + x;
  EXPECT_LT(largest_difference(out, expected), 1e-15);  // 0
  EXPECT_NEAR(sums[0], x.squaredNorm(), 1e-14);         // 4e-16
  EXPECT_NEAR(sums[1], yz.squaredNorm(), 1e-14);        // 2e-16
  EXPECT_NEAR(sums[2], x.squaredNorm(), 1e-14);         // 4e-16
  EXPECT_NEAR(sums[3], expected.squaredNorm(), 1e-14);  // 7e-15
  EXPECT_NEAR(sums[4], z.squaredNorm(), 1e-14);         // 0
}

TEST(KernelSelection, RefusesUnknownNamesAndKeepsTheChoice) {
  const std::string before = kernels().name;
  for (const char* name : {"", "avx", "AVX2", "sse", "avx512 ", "scalars"})
    EXPECT_FALSE(select_kernels(name)) << name;
  EXPECT_EQ(kernels().name, before);
}

TEST(KernelSelection, TakesTheNamedKernels) {
  int found = 0;
  for (const std::string& name : kernel_names()) {
    const KernelChoice choice(name);
    if (!choice.available()) continue;
    ++found;
    EXPECT_EQ(kernels().name, name);
  }
  EXPECT_GE(found, 1);
}

TEST(KernelSelection, StartsWithTheWidestThereIs) {
  const std::string start = kernels().name;
  std::string widest;
  for (const std::string& name : kernel_names())
    if (KernelChoice(name).available()) widest = name;
  EXPECT_EQ(start, widest);
}

}  // namespace
}  // namespace feder
