// The block Cholesky factorisation against Eigen's dense LLT over patterns, sizes and seeds.
#include "solvers/linear/block_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <set>
#include <string>

#include "engine/kernels.h"

namespace feder {
namespace {

using Edges = std::vector<std::pair<int, int>>;

struct Problem {
  std::string name;
  int blocks;
  Edges edges;
};

// What messages start with.
std::string label(const Problem& problem, unsigned seed) {
  return problem.name + " of " + std::to_string(problem.blocks) + ", seed " + std::to_string(seed);
}

Problem chain(int n) {
  Problem p{"chain", n, {}};
  for (int i = 0; i + 1 < n; ++i) p.edges.emplace_back(i, i + 1);
  return p;
}

Problem ring(int n) {
  Problem p = chain(n);
  p.name = "ring";
  p.edges.emplace_back(0, n - 1);
  return p;
}

// every block's parent comes later
Problem tree(int n, unsigned seed, int reach) {
  Problem p{"tree", n, {}};
  std::mt19937 random(seed);
  for (int i = 0; i + 1 < n; ++i)
    p.edges.emplace_back(i, std::min<int>(n - 1, i + 1 + static_cast<int>(random() % reach)));
  return p;
}

Problem grid(int side) {
  Problem p{"grid", side * side, {}};
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      if (x > 0) p.edges.emplace_back(y * side + x, y * side + x - 1);
      if (y > 0) p.edges.emplace_back(y * side + x, y * side + x - side);
      if (x > 0 && y > 0) p.edges.emplace_back(y * side + x, y * side + x - side - 1);
    }
  return p;
}

// `branches` chains that end in a grid's blocks, and a lone block
Problem grid_with_chains(int side, int branches, int length) {
  Problem inner = grid(side), p{"grid with chains", 0, {}};
  for (int b = 0; b < branches; ++b) {
    for (int i = 0; i < length; ++i)
      p.edges.emplace_back(b * length + i, i + 1 < length ? b * length + i + 1 : branches * length + b);
  }
  for (const auto& [i, j] : inner.edges) p.edges.emplace_back(branches * length + i, branches * length + j);
  p.blocks = branches * length + inner.blocks + 1;
  return p;
}

Problem scattered(int n, int edges, unsigned seed) {
  Problem p{"scattered", n, {}};
  std::mt19937 random(seed);
  for (int k = 0; k < edges; ++k) {
    const int i = static_cast<int>(random() % n), j = static_cast<int>(random() % n);
    if (i != j) p.edges.emplace_back(i, j), p.edges.emplace_back(j, i);
  }
  return p;
}

// the hub comes first (`dense`: everything fills) or last
Problem arrow(int n, bool dense) {
  Problem p{dense ? "arrow, hub first" : "arrow, hub last", n, {}};
  for (int i = 1; i < n; ++i) p.edges.emplace_back(dense ? 0 : i - 1, dense ? i : n - 1);
  return p;
}

// J J^T + 0.1 I with random J per edge: positive definite, not diagonally dominant.
Eigen::MatrixXd random_matrix(const Problem& p, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd A = 0.1 * Eigen::MatrixXd::Identity(3 * p.blocks, 3 * p.blocks);
  auto noise = [&] { return Eigen::Matrix3d::NullaryExpr([&] { return normal(random); }); };
  for (int i = 0; i < p.blocks; ++i) {
    const Eigen::Matrix3d J = noise();
    A.block<3, 3>(3 * i, 3 * i) += 0.1 * J * J.transpose();
  }
  for (const auto& [i, j] : p.edges) {
    const Eigen::Matrix3d I = noise(), J = noise();
    A.block<3, 3>(3 * i, 3 * i) += I * I.transpose();
    A.block<3, 3>(3 * j, 3 * j) += J * J.transpose();
    A.block<3, 3>(3 * i, 3 * j) += I * J.transpose();
    A.block<3, 3>(3 * j, 3 * i) += J * I.transpose();
  }
  return A;
}

void write(const Eigen::MatrixXd& A, BlockCholesky& factor) {
  for (int i = 0; i < A.rows() / 3; ++i)
    for (int j = 0; j <= i; ++j)
      if (const int slot = factor.slot(i, j); slot >= 0)
        for (int r = 0; r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            const bool unread = i == j && r < c;
            factor.values()[slot + r + 3 * c] =
                unread ? std::numeric_limits<double>::quiet_NaN() : A(3 * i + r, 3 * j + c);
          }
}

BlockCholesky analyzed(const Problem& p) {
  BlockCholesky factor;
  factor.analyze(p.blocks, p.edges);
  return factor;
}

// |x - A^-1 b| / |A^-1 b|
double solve_error(const Eigen::MatrixXd& A, const BlockCholesky& factor) {
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1.0, 2.0), exact = A.llt().solve(b);
  Eigen::VectorXd x = b;
  factor.solve(x.data());
  return (x - exact).norm() / exact.norm();
}

std::vector<Problem> problems(unsigned seed) {
  const int n = 2 + static_cast<int>(7 * seed);
  return {{"lone", 1, {}},
          {"apart", n, {}},
          chain(n),
          ring(n + 1),
          tree(n, seed, 2),
          tree(n, seed, 5),
          grid(3 + static_cast<int>(seed)),
          grid_with_chains(4, 5, 1 + static_cast<int>(seed)),
          scattered(n, n, seed),
          scattered(n, 3 * n, seed),
          arrow(n, true),
          arrow(n, false)};
}

void expect_dense_solutions() {
  for (unsigned seed = 0; seed < 10; ++seed)
    for (const Problem& p : problems(seed)) {
      const Eigen::MatrixXd A = random_matrix(p, seed);
      BlockCholesky factor = analyzed(p);
      write(A, factor);
      ASSERT_TRUE(factor.factor()) << label(p, seed);
      EXPECT_EQ(factor.failed_column(), -1);
      EXPECT_LT(solve_error(A, factor), 1e-12) << label(p, seed);
    }
}

TEST(BlockCholesky, SolvesAsTheDenseFactorisationDoes) {
  expect_dense_solutions();
}

TEST(BlockCholesky, SolvesWithPlainKernelsToo) {
  const char* const before = kernels().name;
  ASSERT_TRUE(select_kernels("scalar"));
  expect_dense_solutions();
  ASSERT_TRUE(select_kernels(before));
}

TEST(BlockCholesky, SmallestPivotRatioIsThatOfTheDenseFactor) {
  for (unsigned seed = 0; seed < 10; ++seed)
    for (const Problem& p : problems(seed)) {
      const Eigen::MatrixXd A = random_matrix(p, seed), L = A.llt().matrixL();
      BlockCholesky factor = analyzed(p);
      write(A, factor);
      ASSERT_TRUE(factor.factor());
      const Eigen::VectorXd ratio = L.diagonal().array().square() / A.diagonal().array();
      EXPECT_NEAR(factor.smallest_pivot_ratio() / ratio.minCoeff(), 1.0, 1e-10) << label(p, seed);
      EXPECT_NEAR(ratio[factor.column_of_smallest_ratio()] / ratio.minCoeff(), 1.0, 1e-10) << label(p, seed);
    }
}

TEST(BlockCholesky, CountsTheFlopsAndEntriesOfTheFactor) {
  const BlockCholesky full = analyzed(arrow(10, true)), band = analyzed(chain(10));
  EXPECT_EQ(full.factor_entries(), 9u * 55u);
  EXPECT_EQ(band.factor_entries(), 9u * 19u);
  EXPECT_NEAR(full.flops(), 30.0 * 30.0 * 30.0 / 3.0, 0.1 * 9000.0);
  EXPECT_LT(band.flops(), full.flops() / 5.0);
}

// Scalar row k = row k - 1 of J: the matrix stays semidefinite, its pivot is rounding. Made negative.
void make_dependent(Eigen::MatrixXd& A, int k) {
  A.row(k) = A.row(k - 1).eval();
  A.col(k) = A.col(k - 1).eval();
  A(k, k) -= 1e-6 * A(k, k);
}

TEST(BlockCholesky, ReportsTheScalarColumnOfADependentRow) {
  for (unsigned seed = 1; seed < 6; ++seed)
    for (const Problem& p : problems(seed))
      for (int block : {0, p.blocks / 2, p.blocks - 1})
        for (int c : {1, 2}) {
          Eigen::MatrixXd A = random_matrix(p, seed);
          make_dependent(A, 3 * block + c);
          BlockCholesky factor = analyzed(p);
          write(A, factor);
          EXPECT_FALSE(factor.factor()) << label(p, seed);
          EXPECT_EQ(factor.failed_column(), 3 * block + c) << label(p, seed);
        }
}

TEST(BlockCholesky, RatioPointsAtANearlyDependentRow) {
  for (const Problem& p : problems(3)) {
    Eigen::MatrixXd A = random_matrix(p, 3);
    const int k = 3 * (p.blocks / 2) + 1;
    make_dependent(A, k);
    A(k, k) = A(k - 1, k - 1) * (1.0 + 1e-9);
    BlockCholesky factor = analyzed(p);
    write(A, factor);
    ASSERT_TRUE(factor.factor()) << p.name;
    EXPECT_EQ(factor.column_of_smallest_ratio(), k) << p.name;
    EXPECT_NEAR(factor.smallest_pivot_ratio(), 1e-9, 1e-13) << p.name;
  }
}

TEST(BlockCholesky, TakesANotANumberAsFailure) {
  for (const Problem& p : problems(4)) {
    const Eigen::MatrixXd A = random_matrix(p, 4);
    BlockCholesky factor = analyzed(p);
    write(A, factor);
    const std::size_t last = factor.value_count() - 9;
    for (std::size_t at : {last, last + 1, last + 4, std::size_t{0}, factor.value_count() / 18 * 9}) {
      const double kept = factor.values()[at];
      factor.values()[at] = std::numeric_limits<double>::quiet_NaN();
      EXPECT_FALSE(factor.factor()) << p.name << " value " << at;
      factor.values()[at] = kept;
    }
    EXPECT_TRUE(factor.factor()) << p.name;
  }
}

TEST(BlockCholesky, FactorsNewValuesInTheSamePattern) {
  for (const Problem& p : problems(3)) {
    BlockCholesky factor = analyzed(p);
    for (unsigned seed = 0; seed < 3; ++seed) {
      const Eigen::MatrixXd A = random_matrix(p, seed);
      write(A, factor);
      ASSERT_TRUE(factor.factor());
      EXPECT_LT(solve_error(A, factor), 1e-12) << label(p, seed);
    }
  }
}

TEST(BlockCholesky, GivesTheSameBitsEveryTime) {
  for (const Problem& p : problems(5)) {
    const Eigen::MatrixXd A = random_matrix(p, 5);
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(A.rows(), -1.0, 2.0);
    Eigen::VectorXd first;
    for (int run = 0; run < 3; ++run) {
      BlockCholesky factor = analyzed(p);
      write(A, factor);
      ASSERT_TRUE(factor.factor());
      ASSERT_TRUE(factor.factor());
      Eigen::VectorXd x = b;
      factor.solve(x.data());
      if (run == 0) first = x;
      EXPECT_TRUE((x.array() == first.array()).all()) << p.name;
    }
  }
}

TEST(BlockCholesky, AnalysesASecondPattern) {
  BlockCholesky factor;
  for (const Problem& p : {grid(6), chain(4), ring(9), Problem{"lone", 1, {}}, grid(4)}) {
    factor.analyze(p.blocks, p.edges);
    const Eigen::MatrixXd A = random_matrix(p, 1);
    write(A, factor);
    ASSERT_TRUE(factor.factor()) << p.name;
    EXPECT_LT(solve_error(A, factor), 1e-12) << p.name;
  }
}

TEST(BlockCholesky, HasASlotForExactlyTheBlocksOfThePattern) {
  for (const Problem& p : problems(4)) {
    const BlockCholesky factor = analyzed(p);
    std::set<std::pair<int, int>> present(p.edges.begin(), p.edges.end());
    std::set<int> slots;
    for (int i = -1; i <= p.blocks; ++i)
      for (int j = -1; j <= p.blocks; ++j) {
        const bool inside = i >= j && j >= 0 && i < p.blocks;
        const bool wanted = inside && (i == j || present.contains({i, j}) || present.contains({j, i}));
        EXPECT_EQ(factor.slot(i, j) >= 0, wanted) << p.name << " " << i << " " << j;
        if (wanted) slots.insert(factor.slot(i, j));
      }
    EXPECT_EQ(9 * slots.size(), factor.value_count()) << p.name;
  }
}

TEST(BlockCholesky, AcceptsAnEmptyMatrix) {
  BlockCholesky factor = analyzed({"empty", 0, {}});
  EXPECT_TRUE(factor.factor());
  factor.solve(nullptr);
}

}  // namespace
}  // namespace feder
