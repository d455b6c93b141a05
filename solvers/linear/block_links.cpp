// Links one or two at a time: the three numbers of a block column fill no vector, and wider instructions
// measured slower. A = L D L^T here: no square roots, and what is passed on to the parent needs only
// quantities that are one division away from the diagonal block (w2, w3 below are multiples of columns of
// L D).
#include "solvers/linear/block_links.h"

namespace feder {
namespace {

typedef double Pair __attribute__((vector_size(16)));
typedef long long PairBits __attribute__((vector_size(16)));

template <class T>
constexpr int kLanes = sizeof(T) / sizeof(double);

inline bool all(bool x) {
  return x;
}
inline bool all(PairBits x) {
  return (x[0] & x[1]) != 0;
}

template <class T>
inline T gather(const double* const (&from)[kLanes<T>], int i) {
  if constexpr (kLanes<T> == 2)
    return T{from[0][i], from[1][i]};
  else
    return from[0][i];
}
template <class T>
inline double part(const T& x, int i) {
  if constexpr (kLanes<T> == 2)
    return x[i];
  else
    return x;
}
template <class T>
inline void set_part(T& x, int i, double y) {
  if constexpr (kLanes<T> == 2)
    x[i] = y;
  else
    x = y;
}

// True if every pivot is positive, finite and not the least so far; otherwise they need a closer look.
template <class T>
inline bool unremarkable(const PivotWatch& watch, const T& pivot, const T& original) {
  constexpr double kLargest = __DBL_MAX__;
  return all((pivot > 0.0) & (pivot <= kLargest) & (pivot * watch.original >= watch.pivot * original));
}

// L below = B L^-T D^-1; the rest as in pivots()
template <class T>
inline void eliminate_below(const T (&b)[9], const T (&a)[6], const Pivots<T>& p,
                            Link* const (&link)[kLanes<T>], T (&taken)[6]) {
  T v[3][3], w[3][3];
  const T f3 = p.r1 * p.q2, c22a11 = p.c22 * a[0], c22a31 = p.c22 * a[2];
  for (int i = 0; i < 3; ++i) {
    const T w2 = a[0] * b[3 + i] - a[1] * b[i], w3 = (c22a11 * b[6 + i] - c22a31 * b[i]) - p.c32 * w2;
    v[0][i] = b[i] * p.r1, v[1][i] = w2 * p.q2, v[2][i] = w3 * p.q3;
    w[0][i] = b[i], w[1][i] = w2 * p.r1, w[2][i] = w3 * f3;
  }
  for (int l = 0; l < kLanes<T>; ++l)
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < 3; ++i) link[l]->below[3 * c + i] = part(v[c][i], l);
  // written out: as a loop it is vectorised through memory, and the next link waits for that
  auto sum = [&](int i, int j) { return w[0][i] * v[0][j] + w[1][i] * v[1][j] + w[2][i] * v[2][j]; };
  taken[0] = sum(0, 0), taken[1] = sum(1, 0), taken[2] = sum(2, 0);
  taken[3] = sum(1, 1), taken[4] = sum(2, 1), taken[5] = sum(2, 2);
}

template <class T>
inline void take_children(const LinkView& list, const Link* link, int k, int l, T (&a)[6]) {
  for (int i = list.child_start[k]; i < list.child_start[k + 1]; ++i) {
    double taken[6];
    passed(link[list.child[i]], taken);
    for (int c = 0; c < 6; ++c) set_part(a[c], l, part(a[c], l) - taken[c]);
  }
}

template <class T>
bool factor_run(const LinkView& list, int begin, int end, const double* values, Link* out,
                PivotWatch& watch) {
  constexpr int kColumn[6] = {0, 1, 2, 4, 5, 8};
  T taken[6] = {};
  for (int k = begin; k < end; k += kLanes<T>) {
    const double *value[kLanes<T>], *below[kLanes<T>];
    Link* link[kLanes<T>];
    for (int l = 0; l < kLanes<T>; ++l) {
      value[l] = values + list.value[k + l], link[l] = out + k + l;
      below[l] = list.parent[k + l] >= 0 ? value[l] + 9 : value[l];  // read in any case, used in one
      if (!list.follows[k + l])
        for (T& x : taken) set_part(x, l, 0.0);
    }
    T a[6], b[9];
    for (int i = 0; i < 6; ++i) a[i] = gather<T>(value, kColumn[i]);
    const T original[3] = {a[0], a[3], a[5]};
    for (int i = 0; i < 6; ++i) a[i] -= taken[i];
    for (int l = 0; l < kLanes<T>; ++l) take_children(list, out, k + l, l, a);
    const Pivots<T> p = pivots(a);
    if (!(unremarkable(watch, a[0], original[0]) & unremarkable(watch, p.pivot2, original[1]) &
          unremarkable(watch, p.pivot3, original[2])))
      for (int l = 0; l < kLanes<T>; ++l) {
        const double pivot[3] = {part(a[0], l), part(p.pivot2, l), part(p.pivot3, l)};
        const double before[3] = {part(original[0], l), part(original[1], l), part(original[2], l)};
        if (!accept(watch, pivot, before, 3 * list.column[k + l])) return false;
      }
    const T l21 = a[1] * p.r1, l31 = a[2] * p.r1, l32 = p.c32 * p.q2, r2 = a[0] * p.q2,
            r3 = a[0] * p.c22 * p.q3;
    for (int l = 0; l < kLanes<T>; ++l) {
      link[l]->l21 = part(l21, l), link[l]->l31 = part(l31, l), link[l]->l32 = part(l32, l);
      link[l]->r1 = part(p.r1, l), link[l]->r2 = part(r2, l), link[l]->r3 = part(r3, l);
    }
    for (int i = 0; i < 9; ++i) b[i] = gather<T>(below, i);
    eliminate_below(b, a, p, link, taken);
  }
  return true;
}

}  // namespace

void passed(const Link& link, double (&taken)[6]) {
  const double *v = link.below, d[3] = {1.0 / link.r1, 1.0 / link.r2, 1.0 / link.r3};
  for (int j = 0, k = 0; j < 3; ++j)
    for (int i = j; i < 3; ++i, ++k)
      taken[k] = v[i] * d[0] * v[j] + v[3 + i] * d[1] * v[3 + j] + v[6 + i] * d[2] * v[6 + j];
}

bool factor_links(const LinkView& list, const double* values, Link* out, PivotWatch& total) {
  PivotWatch watch = total;
  bool good = true;
  const LinkRun* run = list.run;
  for (int begin = 0; good && begin < list.count; begin = run++->end)
    good = run->pairs ? factor_run<Pair>(list, begin, run->end, values, out, watch)
                      : factor_run<double>(list, begin, run->end, values, out, watch);
  total = watch;
  return good;
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
