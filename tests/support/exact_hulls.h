// Do two convex hulls meet? Exactly, in integers: numbers are doubles or sums of products of doubles, so a
// power of two makes them whole. A common point sum lambda_i p_i = sum mu_j q_j, weights >= 0 of sum 1, is a
// linear programme with five equations; phase 1 of the simplex method with Bland's rule, pivoting without
// fractions (Edmonds 1967). No axis, no distance, no tolerance in it.
#pragma once

#include <gmpxx.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "engine/geometry/bounding_volumes.h"

namespace feder::test {

using ExactPoint = std::array<mpz_class, 3>;
using ExactPoints = std::vector<ExactPoint>;

/// The least k >= 0 for which 2^k x is whole for all numbers x given to it.
class BinaryScale {
 public:
  void include(double x) {
    int exponent = 0;
    std::frexp(x, &exponent);
    if (x != 0.0) shift_ = std::max(shift_, 53 - exponent);
  }
  void include(const Vector3d& x) {
    for (double component : x) include(component);
  }
  /// 2^(times k) x, times >= 1; rounded down if x was not included.
  mpz_class whole(double x, int times = 1) const {
    int exponent = 0;
    mpz_class out(std::ldexp(std::frexp(x, &exponent), 53));
    const int shift = exponent - 53 + times * shift_;
    return shift >= 0 ? mpz_class(out << shift) : mpz_class(out >> -shift);
  }
  ExactPoint whole(const Vector3d& x, int times = 1) const {
    return {whole(x[0], times), whole(x[1], times), whole(x[2], times)};
  }

 private:
  int shift_ = 0;
};

inline ExactPoints exact_points(const BinaryScale& scale, std::span<const Vector3d> points, int times = 1) {
  ExactPoints out;
  for (const Vector3d& p : points) out.push_back(scale.whole(p, times));
  return out;
}

inline void include(BinaryScale& scale, const Obb& box) {
  scale.include(box.centre);
  scale.include(box.half);
  for (int k = 0; k < 3; ++k) scale.include(box.axes.col(k));
}

/// centre + axes diag(+-1) half, scaled twice.
inline ExactPoints exact_corners(const BinaryScale& scale, const Obb& box) {
  ExactPoints out(8, scale.whole(box.centre, 2));
  for (int j = 0; j < 3; ++j) {
    const mpz_class half = scale.whole(box.half[j]);
    for (int i = 0; i < 3; ++i) {
      const mpz_class step = half * scale.whole(box.axes(i, j));
      for (int corner = 0; corner < 8; ++corner)
        if (corner >> j & 1)
          out[corner][i] += step;
        else
          out[corner][i] -= step;
    }
  }
  return out;
}

inline bool hulls_meet(const ExactPoints& p, const ExactPoints& q) {
  constexpr int kRows = 5;
  const int n = static_cast<int>(p.size() + q.size());

  // columns (p - p_0, 1, 0) and (p_0 - q, 0, 1), right-hand side (0, 0, 0, 1, 1); last row: sum of the others
  std::vector<std::vector<mpz_class>> T(kRows + 1, std::vector<mpz_class>(n + 1));
  for (int j = 0; j < n; ++j) {
    const int i = j - static_cast<int>(p.size());
    for (int c = 0; c < 3; ++c) T[c][j] = i < 0 ? p[j][c] - p[0][c] : p[0][c] - q[i][c];
    T[i < 0 ? 3 : 4][j] = 1;
  }
  T[3][n] = T[4][n] = 1;
  for (int r = 0; r < kRows; ++r)
    for (int j = 0; j <= n; ++j) T[kRows][j] += T[r][j];

  int basis[kRows] = {n, n + 1, n + 2, n + 3, n + 4};
  mpz_class denominator = 1, product;
  while (T[kRows][n] > 0) {
    // Bland: the first column that lowers the sum of the artificial variables, the first row among equals
    int column = 0, row = -1;
    while (column < n && T[kRows][column] <= 0) ++column;
    if (column == n) return false;
    for (int r = 0; r < kRows; ++r) {
      if (T[r][column] <= 0) continue;
      if (row >= 0) {
        const int order = cmp(T[r][n] * T[row][column], T[row][n] * T[r][column]);
        if (order > 0 || (order == 0 && basis[r] > basis[row])) continue;
      }
      row = r;
    }
    // T_i = (T_i pivot - T_i,column T_row) / denominator, a division without remainder
    const mpz_class pivot = T[row][column];
    for (int r = 0; r <= kRows; ++r) {
      if (r == row) continue;
      const mpz_class factor = T[r][column];
      for (int j = 0; j <= n; ++j) {
        mpz_mul(product.get_mpz_t(), factor.get_mpz_t(), T[row][j].get_mpz_t());
        mpz_mul(T[r][j].get_mpz_t(), T[r][j].get_mpz_t(), pivot.get_mpz_t());
        mpz_sub(T[r][j].get_mpz_t(), T[r][j].get_mpz_t(), product.get_mpz_t());
        mpz_divexact(T[r][j].get_mpz_t(), T[r][j].get_mpz_t(), denominator.get_mpz_t());
      }
    }
    denominator = pivot;
    basis[row] = column;
  }
  return true;
}

/// q + offset
inline ExactPoints shifted(ExactPoints q, const ExactPoint& offset) {
  for (ExactPoint& point : q)
    for (int c = 0; c < 3; ++c) point[c] += offset[c];
  return q;
}

/// The hull of q with a cube of this half edge added.
inline ExactPoints grown(const ExactPoints& q, const mpz_class& half) {
  ExactPoints out;
  for (int corner = 0; corner < 8; ++corner) {
    ExactPoint offset;
    for (int c = 0; c < 3; ++c) offset[c] = corner >> c & 1 ? mpz_class(half) : mpz_class(-half);
    for (const ExactPoint& point : shifted(q, offset)) out.push_back(point);
  }
  return out;
}

}  // namespace feder::test
