// Pivots of a symmetric 3 x 3 block without a division between them (Bareiss, Math. Comp. 22, 1968): with
// c_ik = a_11 a_ik - a_i1 a_k1 and d = c_22 c_33 - c_32^2 they are a_11, c_22 / a_11 and d / (a_11 c_22). The
// rounding errors are those of Cholesky up to a constant, and the three reciprocals run side by side: in a
// chain each block waits for the one before, and latency is all. Fourth powers of the entries must not
// overflow or underflow.
#pragma once

namespace feder {

/// Watches the pivots: the least L_kk^2 / A_kk so far as a fraction (compared by products: no division).
struct PivotWatch {
  double pivot = 1.0, original = 0.0;
  int column = -1;         ///< where it is
  int failed_column = -1;  ///< the first pivot that is not a positive finite number
};

namespace {  // compiled with several instruction sets: not to be merged by the linker

template <class T>
struct Pivots {
  T c22, c32, d;  // see above
  T r1, q2, q3;   // 1 / a_11, 1 / c_22, 1 / d
  T pivot2, pivot3;
};

// lower triangle by columns; T: one number or several side by side
template <class T>
inline Pivots<T> pivots(const T (&a)[6]) {
  const T a11 = a[0], a21 = a[1], a31 = a[2], a22 = a[3], a32 = a[4], a33 = a[5];
  Pivots<T> p;
  p.c22 = a11 * a22 - a21 * a21;
  p.c32 = a11 * a32 - a31 * a21;
  const T c33 = a11 * a33 - a31 * a31;
  p.d = p.c22 * c33 - p.c32 * p.c32;
  p.r1 = 1.0 / a11;
  p.q2 = 1.0 / p.c22;
  p.q3 = 1.0 / p.d;
  p.pivot2 = p.c22 * p.r1;
  p.pivot3 = p.d * (p.r1 * p.q2);
  return p;
}

inline void watch_pivot(PivotWatch& watch, double pivot, double original, int column) {
  if (pivot * watch.original >= watch.pivot * original) return;
  watch.pivot = pivot, watch.original = original, watch.column = column;
}

// false, and where, if a pivot is not positive and finite
inline bool accept(PivotWatch& watch, const double* pivot, const double* original, int column) {
  constexpr double kLargest = __DBL_MAX__;
  for (int c = 0; c < 3; ++c) {
    if (!(pivot[c] > 0.0 && pivot[c] <= kLargest)) return watch.failed_column = column + c, false;
    watch_pivot(watch, pivot[c], original[c], column + c);
  }
  return true;
}

}  // namespace
}  // namespace feder
