// The contact law: the direct solve and the sweeps against closed forms, enumeration and each other.
#include "solvers/contact/contact_problem.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdio>

#include "tests/support/campaign.h"
#include "tests/support/random.h"

namespace feder {
namespace {

// k contacts between bodies of random shape: J random, v random; redundant where 3 k exceeds the unknowns.
ContactProblem random_problem(std::uint64_t seed, int most, double friction) {
  Random random(seed);
  const int k = 1 + random.below(most), n = 6 * (1 + random.below(6));
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3 * k, n);
  for (int i = 0; i < k; ++i) {
    const int a = random.below(n / 6), b = random.below(n / 6);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 6; ++c) {
        J(3 * i + r, 6 * a + c) += random.uniform();
        if (b != a) J(3 * i + r, 6 * b + c) -= random.uniform();
      }
  }
  ContactProblem p{J * J.transpose(), J * random.numbers(n), VectorXd(k)};
  for (int i = 0; i < k; ++i) p.friction[i] = friction * random.uniform(0.0, 1.0);
  return p;
}

// One mass on a plane.
ContactProblem block(double mass, const Vector3d& velocity, double friction) {
  return {Eigen::MatrixXd::Identity(3, 3) / mass, velocity, VectorXd::Constant(1, friction)};
}

TEST(ContactLaw, HoldsABlockInsideItsCone) {
  VectorXd y = VectorXd::Zero(3);
  ASSERT_TRUE(solve_contacts(block(2.0, {-1.0, 0.3, 0.0}, 0.5), {}, y).status.ok());
  EXPECT_LT((y - Vector3d(2.0, -0.6, 0.0)).norm(), 1e-9);
}

TEST(ContactLaw, SlidesABlockAgainstItsVelocity) {
  VectorXd y = VectorXd::Zero(3);
  const ContactProblem p = block(2.0, {-1.0, 0.6, 0.8}, 0.5);
  ASSERT_TRUE(solve_contacts(p, {}, y).status.ok());
  EXPECT_LT((y - Vector3d(2.0, -0.6, -0.8)).norm(), 1e-9);
}

TEST(ContactLaw, LetsGoWhatSeparates) {
  VectorXd y = VectorXd::Constant(3, 5.0);
  ASSERT_TRUE(solve_contacts(block(2.0, {0.1, 0.6, 0.8}, 0.5), {}, y).status.ok());
  EXPECT_EQ(y.norm(), 0.0);
}

TEST(ContactLaw, ViolationIsZeroAtTheSolutionAlone) {
  const ContactProblem p = block(2.0, {-1.0, 0.6, 0.8}, 0.5);
  EXPECT_LT(contact_violation(p, Vector3d(2.0, -0.6, -0.8)), 1e-15);
  EXPECT_NEAR(contact_violation(p, Vector3d(1.0, -0.3, -0.4)), 0.5, 1e-12);  // pushes too little
  EXPECT_GT(contact_violation(p, Vector3d(2.0, 0.6, 0.8)), 0.5);             // friction drives
  EXPECT_GT(contact_violation(p, Vector3d(2.0, -1.2, -1.6)), 0.49);          // outside the cone
  EXPECT_GT(contact_violation(block(1.0, {0.5, 0.0, 0.0}, 0.5), Vector3d(0.1, 0.0, 0.0)),
            0.05);  // pulls at nothing
}

// Without friction the law is a linear complementarity problem: one of the 2^k sets of pushing contacts fits.
TEST(ContactLaw, FrictionlessVelocitiesAgreeWithEnumeration) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE(seed);
    const ContactProblem p = random_problem(seed, 7, 0.0);
    VectorXd y = VectorXd::Zero(p.b.size());
    ASSERT_TRUE(solve_contacts(p, {}, y).status.ok());
    const VectorXd u = p.W * y + p.b;
    bool found = false;
    for (int set = 0; set < 1 << p.count() && !found; ++set) {
      std::vector<int> rows;
      for (int i = 0; i < p.count(); ++i)
        if (set >> i & 1) rows.push_back(3 * i);
      const int m = static_cast<int>(rows.size());
      Eigen::MatrixXd A(m, m);
      VectorXd rhs(m), trial = VectorXd::Zero(p.b.size());
      for (int i = 0; i < m; ++i) {
        rhs[i] = -p.b[rows[i]];
        for (int j = 0; j < m; ++j) A(i, j) = p.W(rows[i], rows[j]);
      }
      const Eigen::FullPivLU<Eigen::MatrixXd> lu(A);
      if (m > 0 && (lu.rank() < m)) continue;
      const VectorXd x = m > 0 ? VectorXd(lu.solve(rhs)) : VectorXd();
      for (int i = 0; i < m; ++i) trial[rows[i]] = x[i];
      const VectorXd w = p.W * trial + p.b;
      bool fits = m == 0 || x.minCoeff() >= -1e-10;
      for (int i = 0; i < p.count(); ++i) fits = fits && w[3 * i] >= -1e-9;
      if (!fits) continue;
      found = true;
      // normal velocities are unique (W is semidefinite), so are W y
      for (int i = 0; i < p.count(); ++i) EXPECT_NEAR(w[3 * i], u[3 * i], 1e-7);
    }
    EXPECT_TRUE(found);
  }
}

TEST(ContactLaw, SweepsReachTheSameVelocitiesWithoutFriction) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    SCOPED_TRACE(seed);
    const ContactProblem p = random_problem(seed, 12, 0.0);
    VectorXd direct = VectorXd::Zero(p.b.size()), swept = direct;
    ASSERT_TRUE(solve_contacts(p, {}, direct).status.ok());
    if (!solve_by_sweeps(p, {}, swept).status.ok()) continue;  // too slow on near-redundant ones
    const VectorXd difference = p.W * (direct - swept);
    for (int i = 0; i < p.count(); ++i) EXPECT_NEAR(difference[3 * i], 0.0, 1e-6);
  }
}

TEST(ContactLaw, StopsWithAReasonWhereItCannotGoOn) {
  ContactProblem p = random_problem(1, 12, 0.5);
  p.b[0] = std::nan("");
  VectorXd y = VectorXd::Zero(p.b.size());
  ContactOptions options;
  options.most_sweeps = 100;
  EXPECT_EQ(solve_contacts(p, options, y).status.code, StatusCode::kNonFinite);
  p = random_problem(3, 24, 0.5);
  options.most_sweeps = 1;
  y.setZero(p.b.size());
  const ContactReport report = solve_by_sweeps(p, options, y);
  EXPECT_EQ(report.status.code, StatusCode::kNotConverged);
  EXPECT_NE(report.status.reason.find("left open by"), std::string::npos);
}

// Random W is harsher than mechanics: tangents of one contact may lift another.
TEST(ContactLawCampaign, RandomProblemsAreSolved) {
  const int cases = test::campaign_cases(100'000);
  int failed = 0, direct = 0;
  long newton = 0;
  for (int i = 0; i < cases; ++i) {
    const ContactProblem p = random_problem(static_cast<std::uint64_t>(i), 24, 0.5 * (i % 3));
    VectorXd y = VectorXd::Zero(p.b.size());
    ContactOptions options;
    options.most_sweeps = 5000;
    const ContactReport report = solve_contacts(p, options, y);
    failed += !report.status.ok();
    direct += report.sweeps == 0;
    newton += report.newton_iterations;
    if (report.status.ok())
      EXPECT_LE(contact_violation(p, y), 1e-9 * p.b.lpNorm<Eigen::Infinity>()) << "seed " << i;
  }
  std::printf("%d problems: %d failed, %d by Newton alone, %.1f Newton iterations each\n", cases, failed,
              direct, static_cast<double>(newton) / cases);
  EXPECT_LE(failed, cases / 5'000);   // measured 11 of 100 000
  EXPECT_GE(direct, cases * 9 / 10);  // measured 94 650 of 100 000
}

}  // namespace
}  // namespace feder
