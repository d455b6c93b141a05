// Distance rows and array passes, W numbers at a time. Included by one source file per instruction set, which
// defines kLanes and the shuffles; everything is in an unnamed namespace, because code compiled with wide
// instructions must not be merged by the linker.
//
// Nodes are stored x y z x y z ... . For a run, 3 W consecutive numbers hold W nodes: the difference D = X_b
// - X_a is taken in that order, squared, summed by threes into W squared lengths, and the W scales are spread
// back by threes: no transposition of q or f. Gathered batches load node by node into the same layout and
// share the arithmetic.
#include "engine/kernels_scalar.h"

namespace feder {
namespace {

typedef double Vec __attribute__((vector_size(kLanes * 8)));
typedef long long Bits __attribute__((vector_size(kLanes * 8)));

struct Triple {  // kLanes nodes, 3 numbers each, as stored
  Vec part[3];
};

inline Vec load(const double* p) {
  Vec x;
  __builtin_memcpy(&x, p, sizeof x);
  return x;
}
inline void store(double* p, Vec x) {
  __builtin_memcpy(p, &x, sizeof x);
}
inline Vec broadcast(double x) {
  return x - Vec{};
}

inline Triple load3(const double* p) {
  return {{load(p), load(p + kLanes), load(p + 2 * kLanes)}};
}
inline void store3(double* p, const Triple& x) {
  for (int i = 0; i < 3; ++i) store(p + kLanes * i, x.part[i]);
}
inline void add3(double* p, const Triple& x) {
  for (int i = 0; i < 3; ++i) store(p + kLanes * i, load(p + kLanes * i) + x.part[i]);
}
inline void subtract3(double* p, const Triple& x) {
  for (int i = 0; i < 3; ++i) store(p + kLanes * i, load(p + kLanes * i) - x.part[i]);
}
inline Triple operator*(const Triple& x, const Triple& y) {
  return {{x.part[0] * y.part[0], x.part[1] * y.part[1], x.part[2] * y.part[2]}};
}
inline Triple operator-(const Triple& x, const Triple& y) {
  return {{x.part[0] - y.part[0], x.part[1] - y.part[1], x.part[2] - y.part[2]}};
}

Vec sum_by_threes(const Triple& x);  // lane i: x[3i] + x[3i+1] + x[3i+2]
Triple spread_by_threes(Vec x);      // element 3i+c: x[i]
Vec later_by_three(Vec x, Vec y);    // the last three of x, then y

// lanes where `condition` holds take `yes`, others +0
inline Vec keep(Bits condition, Vec yes) {
  return reinterpret_cast<Vec>(condition & reinterpret_cast<Bits>(yes));
}

struct Length {
  Vec squared, length, inverse;
};

inline Length lengths(const Triple& D) {
  Length l;
  l.squared = sum_by_threes(D * D);
  l.length = vector_sqrt(l.squared);
  l.inverse = keep(l.squared > 0.0, 1.0 / l.length);
  return l;
}

// x_b - x_a of lanes [at, at + kLanes), whichever way the batch is stored
inline Triple difference(const DistanceView& rows, int first, int at, const double* x) {
  if (first >= 0) {
    const double* xa = x + 3 * static_cast<long>(rows.a[at]);
    return load3(xa + 3 * static_cast<long>(rows.b[at] - rows.a[at])) - load3(xa);
  }
  alignas(64) double d[3 * kLanes];
  for (int i = 0; i < kLanes; ++i) {
    const double* xa = x + 3 * static_cast<long>(rows.a[at + i]);
    const double* xb = x + 3 * static_cast<long>(rows.b[at + i]);
    d[3 * i] = xb[0] - xa[0], d[3 * i + 1] = xb[1] - xa[1], d[3 * i + 2] = xb[2] - xa[2];
  }
  return load3(d);
}

// f_b += F, f_a -= F
inline void apply(const DistanceView& rows, int first, int at, const Triple& F, double* f) {
  if (first >= 0) {
    double* fa = f + 3 * static_cast<long>(rows.a[at]);
    subtract3(fa, F);
    add3(fa + 3 * static_cast<long>(rows.b[at] - rows.a[at]), F);
    return;
  }
  alignas(64) double d[3 * kLanes];
  store3(d, F);
  for (int i = 0; i < kLanes; ++i) {
    double* fa = f + 3 * static_cast<long>(rows.a[at + i]);
    double* fb = f + 3 * static_cast<long>(rows.b[at + i]);
    for (int c = 0; c < 3; ++c) fa[c] -= d[3 * i + c], fb[c] += d[3 * i + c];
  }
}

// Scatters J^T y batch by batch. In a chain (b = a + 1) both ends of a batch lie in the same numbers: storing
// one and loading the other at an offset of one node would wait for the store, so node i gets F_(i-1) - F_i
// in registers, and the last F of a batch is carried into the next.
class Scatter {
 public:
  Scatter(const DistanceView& rows, double* f) : rows_(rows), f_(f) {}
  void add(int first, int at, const Triple& F) {
    if (first < 0 || rows_.b[at] != rows_.a[at] + 1) return apply(rows_, first, at, F, f_);
    const long a = rows_.a[at];
    if (a != carried_to_) finish();
    const Vec &x = F.part[0], &y = F.part[1], &z = F.part[2];
    add3(f_ + 3 * a, {{later_by_three(carry_, x) - x, later_by_three(x, y) - y, later_by_three(y, z) - z}});
    carry_ = z;
    carried_to_ = a + kLanes;
  }
  void finish() {
    if (carried_to_ >= 0)
      for (int c = 0; c < 3; ++c) f_[3 * carried_to_ + c] += carry_[kLanes - 3 + c];
    carry_ = Vec{};
    carried_to_ = -1;
  }

 private:
  const DistanceView& rows_;
  double* f_;
  Vec carry_{};           // its last three numbers are the force on node carried_to_
  long carried_to_ = -1;  // none
};

// the smaller of two, NaN wins
inline Vec least(Vec x, Vec y) {
  const Bits take = (y < x) | (y != y);
  return reinterpret_cast<Vec>((take & reinterpret_cast<Bits>(y)) | (~take & reinterpret_cast<Bits>(x)));
}
inline double least_lane(Vec x) {
  double smallest = x[0];
  for (int i = 1; i < kLanes; ++i)
    if (x[i] < smallest || x[i] != x[i]) smallest = x[i];
  return smallest;
}

template <bool kDamped>
double forces(const DistanceView& rows, const double* q, const double* v, double* f) {
  Vec smallest = broadcast(__builtin_inf());
  double smallest_gathered = __builtin_inf();
  Scatter scatter(rows, f);
  for (int batch = 0; batch < rows.batches; ++batch) {
    const int first = rows.run[batch];
    if (first < 0) {  // the scatter dominates: wide arithmetic gains nothing
      const double s = scalar_forces<kDamped>(rows, kBatch * batch, kBatch * (batch + 1), q, v, f);
      smallest_gathered = least(smallest_gathered, s);
      continue;
    }
    for (int at = kBatch * batch; at < kBatch * (batch + 1); at += kLanes) {
      const Triple D = difference(rows, first, at, q);
      const Length l = lengths(D);
      smallest = least(smallest, finite_or_nan(l.squared));
      Vec lambda = -load(rows.spring + at) * (l.length - load(rows.rest + at));
      if constexpr (kDamped) {
        const Vec rate = sum_by_threes(D * difference(rows, first, at, v)) * l.inverse;
        lambda -= load(rows.damping + at) * rate;
      }
      scatter.add(first, at, spread_by_threes(lambda * l.inverse) * D);
    }
  }
  scatter.finish();
  return least(smallest_gathered, least_lane(smallest));
}

double plain_forces(const DistanceView& rows, const double* q, double* f) {
  return forces<false>(rows, q, nullptr, f);
}

double damped_forces(const DistanceView& rows, const double* q, const double* v, double* f) {
  return forces<true>(rows, q, v, f);
}

double evaluate(const DistanceView& rows, const double* q, double* u, double* length, double* phi) {
  Vec smallest = broadcast(__builtin_inf());
  for (int batch = 0; batch < rows.batches; ++batch) {
    const int first = rows.run[batch];
    for (int at = kBatch * batch; at < kBatch * (batch + 1); at += kLanes) {
      const Triple D = difference(rows, first, at, q);
      const Length l = lengths(D);
      smallest = least(smallest, finite_or_nan(l.squared));
      store3(u + 3 * static_cast<long>(at), spread_by_threes(l.inverse) * D);
      if (length) store(length + at, l.length);
      store(phi + at, l.length - load(rows.rest + at));
    }
  }
  return least_lane(smallest);
}

void multiply(const DistanceView& rows, const double* u, const double* v, double* out) {
  for (int batch = 0; batch < rows.batches; ++batch)
    for (int at = kBatch * batch; at < kBatch * (batch + 1); at += kLanes)
      store(out + at,
            sum_by_threes(load3(u + 3 * static_cast<long>(at)) * difference(rows, rows.run[batch], at, v)));
}

void multiply_weighted(const DistanceView& rows, const double* u, const double* w, const double* x,
                       double* out) {
  for (int batch = 0; batch < rows.batches; ++batch) {
    const int first = rows.run[batch];
    for (int at = kBatch * batch; at < kBatch * (batch + 1); at += kLanes) {
      if (first >= 0) {
        const long a = 3 * static_cast<long>(rows.a[at]), b = 3 * static_cast<long>(rows.b[at]);
        const Triple D = load3(w + b) * load3(x + b) - load3(w + a) * load3(x + a);
        store(out + at, sum_by_threes(load3(u + 3 * static_cast<long>(at)) * D));
        continue;
      }
      for (int k = at; k < at + kLanes; ++k) {
        const long a = 3 * static_cast<long>(rows.a[k]), b = 3 * static_cast<long>(rows.b[k]);
        double sum = 0.0;
        for (int c = 0; c < 3; ++c) sum += u[3 * k + c] * (w[b + c] * x[b + c] - w[a + c] * x[a + c]);
        out[k] = sum;
      }
    }
  }
}

void add_transpose(const DistanceView& rows, const double* u, const double* y, double* f) {
  Scatter scatter(rows, f);
  for (int batch = 0; batch < rows.batches; ++batch)
    for (int at = kBatch * batch; at < kBatch * (batch + 1); at += kLanes)
      scatter.add(rows.run[batch], at, spread_by_threes(load(y + at)) * load3(u + 3 * static_cast<long>(at)));
  scatter.finish();
}

void product(std::size_t n, const double* x, const double* y, double* out) {
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) store(out + i, load(x + i) * load(y + i));
  for (; i < n; ++i) out[i] = x[i] * y[i];
}

void momentum(std::size_t n, const double* m, const double* v, double a, const double* f, double* out) {
  std::size_t i = 0;
  for (; i + 3 * kLanes <= n; i += 3 * kLanes) {
    const Triple mass = spread_by_threes(load(m + i / 3)), x = load3(v + i), y = load3(f + i);
    for (int part = 0; part < 3; ++part)
      store(out + i + kLanes * part, mass.part[part] * x.part[part] + a * y.part[part]);
  }
  for (; i < n; ++i) out[i] = m[i / 3] * v[i] + a * f[i];
}

void drift(std::size_t n, double a, const double* v, const double* x, double* out) {
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) store(out + i, load(x + i) + a * load(v + i));
  for (; i < n; ++i) out[i] = x[i] + a * v[i];
}

void kick(std::size_t n, double a, const double* w, const double* f, const double* v, double* out) {
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) store(out + i, load(v + i) + a * load(w + i) * load(f + i));
  for (; i < n; ++i) out[i] = v[i] + a * w[i] * f[i];
}

void balance(std::size_t n, const double* a, double s, const double* x, const double* y, const double* z,
             double* out, double* sums) {
  Vec part[5] = {};
  std::size_t i = 0;
  for (; i + kLanes <= n; i += kLanes) {
    const Vec ai = load(a + i), yi = load(y + i), xy = load(x + i) * yi, zi = load(z + i),
              o = ai + s * xy + zi;
    part[0] += ai * ai, part[1] += xy * xy, part[2] += zi * zi, part[3] += o * o, part[4] += yi * yi;
    if (out) store(out + i, o);
  }
  for (int j = 0; j < 5; ++j) {
    sums[j] = 0.0;
    for (int lane = 0; lane < kLanes; ++lane) sums[j] += part[j][lane];
  }
  scalar_balance(i, n, a, s, x, y, z, out, sums);
}

}  // namespace
}  // namespace feder
