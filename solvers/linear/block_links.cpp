// Links on scalars: three numbers fill no vector, and wide instructions measured slower. A = L D L^T here: no
// square roots, and what is passed on to the parent needs only quantities that are one division away from the
// diagonal block (w2, w3 below are multiples of columns of L D).
#include "solvers/linear/block_links.h"

namespace feder {
namespace {

// L below = B L^-T D^-1; the rest as in pivots()
inline Passed eliminate_below(const double* b, const double* a, const Pivots& p, Link& link) {
  double v[3][3], w[3][3];
  const double a11 = a[0], a21 = a[1], a31 = a[2], f2 = p.r1, f3 = p.r1 * p.q2, c22a11 = p.c22 * a11,
               c22a31 = p.c22 * a31;
  for (int i = 0; i < 3; ++i) {
    const double b1 = b[i], w2 = a11 * b[3 + i] - a21 * b1,
                 w3 = (c22a11 * b[6 + i] - c22a31 * b1) - p.c32 * w2;
    v[0][i] = b1 * p.r1, v[1][i] = w2 * p.q2, v[2][i] = w3 * p.q3;
    w[0][i] = b1, w[1][i] = w2 * f2, w[2][i] = w3 * f3;
  }
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 3; ++i) link.below[3 * c + i] = v[c][i];
  auto sum = [&](int i, int j) { return w[0][i] * v[0][j] + w[1][i] * v[1][j] + w[2][i] * v[2][j]; };
  return {sum(0, 0), sum(1, 0), sum(2, 0), sum(1, 1), sum(2, 1), sum(2, 2)};
}

}  // namespace

Passed passed(const Link& link) {
  const double *v = link.below, d[3] = {1.0 / link.r1, 1.0 / link.r2, 1.0 / link.r3};
  auto sum = [&](int i, int j) {
    return v[i] * d[0] * v[j] + v[3 + i] * d[1] * v[3 + j] + v[6 + i] * d[2] * v[6 + j];
  };
  return {sum(0, 0), sum(1, 0), sum(2, 0), sum(1, 1), sum(2, 1), sum(2, 2)};
}

bool factor_links(const LinkView& list, const double* values, Link* out, PivotWatch& total) {
  PivotWatch watch = total;
  Passed before;
  for (int k = 0; k < list.count; ++k) {
    const double* value = values + list.value[k];
    if (!list.follows[k]) before = {};
    double a[6] = {value[0] - before.a11, value[1] - before.a21, value[2] - before.a31,
                   value[4] - before.a22, value[5] - before.a32, value[8] - before.a33};
    for (int i = list.child_start[k]; i < list.child_start[k + 1]; ++i) {
      const Passed other = passed(out[list.child[i]]);
      a[0] -= other.a11, a[1] -= other.a21, a[2] -= other.a31;
      a[3] -= other.a22, a[4] -= other.a32, a[5] -= other.a33;
    }
    const Pivots p = pivots(a[0], a[1], a[2], a[3], a[4], a[5]);
    const double pivot[3] = {a[0], p.pivot2, p.pivot3}, original[3] = {value[0], value[4], value[8]};
    if (!accept(watch, pivot, original, 3 * list.column[k])) return total = watch, false;
    Link& link = out[k];
    link.l21 = a[1] * p.r1, link.l31 = a[2] * p.r1, link.l32 = p.c32 * p.q2;
    link.r1 = p.r1, link.r2 = a[0] * p.q2, link.r3 = a[0] * p.c22 * p.q3;
    if (list.parent[k] >= 0) before = eliminate_below(value + 9, a, p, link);
  }
  total = watch;
  return true;
}

void forward_links(const LinkView& list, const Link* link, double* x) {
  for (int k = 0; k < list.count; ++k) {
    const Link& l = link[k];
    const double* v = l.below;
    double* y = x + 3 * list.column[k];
    const double y1 = y[0], y2 = y[1] - l.l21 * y1, y3 = y[2] - l.l31 * y1 - l.l32 * y2;
    y[0] = y1 * l.r1, y[1] = y2 * l.r2, y[2] = y3 * l.r3;
    if (list.parent[k] < 0) continue;
    double* z = x + 3 * list.parent[k];
    for (int i = 0; i < 3; ++i) z[i] = z[i] - v[i] * y1 - v[3 + i] * y2 - v[6 + i] * y3;
  }
}

void backward_links(const LinkView& list, const Link* link, double* x) {
  for (int k = list.count; k-- > 0;) {
    const Link& l = link[k];
    const double* v = l.below;
    double* y = x + 3 * list.column[k];
    double y1 = y[0], y2 = y[1], y3 = y[2];
    if (list.parent[k] >= 0) {
      // z[0] comes last from the parent's own substitution
      const double* z = x + 3 * list.parent[k];
      y1 = y1 - v[2] * z[2] - v[1] * z[1] - v[0] * z[0];
      y2 = y2 - v[5] * z[2] - v[4] * z[1] - v[3] * z[0];
      y3 = y3 - v[8] * z[2] - v[7] * z[1] - v[6] * z[0];
    }
    y2 -= l.l32 * y3;
    y1 = y1 - l.l31 * y3 - l.l21 * y2;
    y[0] = y1, y[1] = y2, y[2] = y3;
  }
}

}  // namespace feder
