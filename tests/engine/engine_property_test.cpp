// Properties over random inputs; RapidCheck shrinks what fails to the smallest case.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/bending.h"
#include "engine/kkt.h"
#include "tests/engine/arrangement.h"
#include "tests/support/kernel_choice.h"
#include "tests/support/random.h"

namespace feder {
namespace {

/// Any rows over 2 to 40 nodes: doubled, in both directions, switched off, rigid, damped.
std::vector<DistanceRow> any_rows(int nodes) {
  const int count = *rc::gen::inRange(0, 80);
  std::vector<DistanceRow> rows;
  for (int k = 0; k < count; ++k) {
    const int a = *rc::gen::inRange(0, nodes), b = (a + *rc::gen::inRange(1, nodes)) % nodes;
    const double d = *rc::gen::element(0.0, 1.0, 250.0, 1e12, static_cast<double>(INFINITY));
    rows.push_back({a, b, *rc::gen::element(0.0, 0.5, 1.0), d, *rc::gen::element(0.0, 0.1)});
  }
  return rows;
}

RC_GTEST_PROP(DistanceRowsProperty, EveryRowOnceAndRunsConsecutive, ()) {
  const int nodes = *rc::gen::inRange(2, 40);
  const std::vector<DistanceRow> rows = any_rows(nodes);
  RC_ASSERT(arrangement_fault(arrange_distance_rows(rows, nodes), rows, nodes) == "");
}

RC_GTEST_PROP(KernelsProperty, EveryWidthComputesTheSameRows, ()) {
  const int nodes = *rc::gen::inRange(2, 40);
  const DistanceRows rows = arrange_distance_rows(any_rows(nodes), nodes);
  const DistanceView view{rows.a.data(),      rows.b.data(),       rows.run.data(), rows.rest.data(),
                          rows.spring.data(), rows.damping.data(), rows.batches()};
  Random random(*rc::gen::arbitrary<std::uint64_t>());
  VectorXd q = random.numbers(3 * nodes);
  const VectorXd v = random.numbers(3 * nodes);
  if (*rc::gen::arbitrary<bool>()) q.tail<3>() = q.head<3>();  // a coincident pair
  const int m = rows.size();
  VectorXd u(3 * m), length(m), phi(m), f = VectorXd::Zero(3 * nodes);
  const double least = scalar_kernels().evaluate(view, q.data(), u.data(), length.data(), phi.data());
  (void)scalar_kernels().damped_forces(view, q.data(), v.data(), f.data());
  for (const std::string& name : kernel_names()) {
    const KernelChoice choice(name);
    if (!choice.available()) continue;
    VectorXd u2(3 * m), length2(m), phi2(m), f2 = VectorXd::Zero(3 * nodes);
    RC_ASSERT(kernels().evaluate(view, q.data(), u2.data(), length2.data(), phi2.data()) == least);
    (void)kernels().damped_forces(view, q.data(), v.data(), f2.data());
    RC_ASSERT((u - u2).norm() <= 1e-14 * (1.0 + u.norm()));
    RC_ASSERT((phi - phi2).norm() <= 1e-14 * (1.0 + phi.norm()));
    RC_ASSERT((length - length2).norm() <= 1e-14 * (1.0 + length.norm()));
    RC_ASSERT((f - f2).norm() <= 1e-13 * (1.0 + f.norm()));
  }
}

/// Points on a grid of 5^3, so that half of the elements are degenerate or near it.
template <class Row>
void any_bending_state_is_finite_or_reported(Row row) {
  row.nodes = {0, 1, 2};
  row.stiffness = 1.0;
  VectorXd q(9);
  const double scale = *rc::gen::element(1e-6, 1.0, 1e6), jitter = *rc::gen::element(0.0, 1e-13, 1e-7);
  for (int i = 0; i < 9; ++i) q[i] = scale * (*rc::gen::inRange(-2, 3) + jitter * *rc::gen::inRange(-9, 10));
  VectorXd phi = VectorXd::Constant(Row::kRows, NAN), J = VectorXd::Constant(9 * Row::kRows, NAN);
  const VectorXd lambda = VectorXd::Ones(Row::kRows);
  Eigen::Matrix<double, 9, 9> H;
  const bool good = row.evaluate(q.data(), phi.data(), J.data());
  row.hessian(q.data(), lambda.data(), H);
  RC_TAG(good ? "regular" : "degenerate");
  RC_ASSERT(phi.allFinite());
  RC_ASSERT(J.allFinite());
  RC_ASSERT(H.allFinite());
  RC_ASSERT(good || (J.isZero(0.0) && H.isZero(0.0)));
}

RC_GTEST_PROP(BendingProperty, CurvatureIsFiniteOrReportedAnywhere, ()) {
  any_bending_state_is_finite_or_reported(CurvatureRow{});
}

RC_GTEST_PROP(BendingProperty, AngleIsFiniteOrReportedAnywhere, ()) {
  AngleRow row;
  row.rest_angle = 1.0;
  any_bending_state_is_finite_or_reported(row);
}

}  // namespace
}  // namespace feder
