#include "solvers/linear/cholmod_factor.h"

#include <cholmod.h>

#include <cstring>

#include "engine/check.h"

namespace feder {
namespace {

// METIS is tried above this many predicted flops: below, AMD's cheaper ordering always won (measured on cloth
// and lattice).
constexpr double kTryMetisAbove = 1e8;
// Without fill (flops per factor entry below this) simplicial code and natural orders can win; CHOLMOD's own
// switch.
constexpr double kNoFill = 40.0;

// One CHOLMOD workspace with the settings every use here shares: silent, one ordering method, no fallback.
struct Workspace {
  cholmod_common common;
  Workspace() {
    cholmod_start(&common);
    common.print = 0;
    common.nmethods = 1;
    common.try_catch = 1;
    common.error_handler = nullptr;
  }
  ~Workspace() { cholmod_finish(&common); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
};

// A view of our arrays as CHOLMOD's matrix; CHOLMOD does not write to it.
cholmod_sparse view(const SymmetricPattern& p, const double* values) {
  cholmod_sparse a{};
  a.nrow = a.ncol = static_cast<std::size_t>(p.size);
  a.nzmax = p.row.size();
  a.p = const_cast<int*>(p.column_start.data());
  a.i = const_cast<int*>(p.row.data());
  a.x = const_cast<double*>(values);
  a.stype = p.upper ? 1 : -1;
  a.itype = CHOLMOD_INT;
  a.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  a.dtype = CHOLMOD_DOUBLE;
  a.sorted = a.packed = 1;
  return a;
}

Status cholmod_status(int status) {
  switch (status) {
    case CHOLMOD_OK:
      return {};
    case CHOLMOD_OUT_OF_MEMORY:
      return Status::failure(StatusCode::kOutOfMemory, "CHOLMOD: out of memory");
    case CHOLMOD_TOO_LARGE:
      return Status::failure(StatusCode::kOutOfMemory, "CHOLMOD: problem too large for 32-bit indices");
    default:
      return Status::failure(StatusCode::kSingular, "CHOLMOD: status " + std::to_string(status));
  }
}

Ordering order_by(int method, const char* name, const SymmetricPattern& graph, double& entries) {
  Workspace w;
  w.common.method[0].ordering = method;
  w.common.postorder = method != CHOLMOD_NATURAL;
  w.common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_sparse a = view(graph, nullptr);
  Ordering out;
  out.name = name;
  if (cholmod_factor* L = cholmod_analyze(&a, &w.common)) {
    const int* perm = static_cast<const int*>(L->Perm);
    out.order.assign(perm, perm + graph.size);
    out.flops = w.common.fl;
    entries = w.common.lnz;
    cholmod_free_factor(&L, &w.common);
  }
  return out;
}

}  // namespace

Ordering fill_reducing_order(int vertices, const std::vector<std::pair<int, int>>& edges, int unknowns) {
  const SymmetricPattern graph = make_pattern(vertices, edges);
  double entries = 0.0;
  Ordering best = order_by(CHOLMOD_AMD, "amd", graph, entries);
  FEDER_CHECK(!best.order.empty() || vertices == 0, "CHOLMOD could not order the graph");
  const double scale = static_cast<double>(unknowns) * unknowns * unknowns;
  if (best.flops < kNoFill * entries) {
    Ordering natural = order_by(CHOLMOD_NATURAL, "natural", graph, entries);
    if (natural.flops <= best.flops) best = std::move(natural);
  } else if (scale * best.flops > kTryMetisAbove) {
    Ordering metis = order_by(CHOLMOD_METIS, "metis", graph, entries);
    if (!metis.order.empty() && metis.flops < best.flops) best = std::move(metis);
  }
  best.flops *= scale;
  return best;
}

struct CholmodFactor::Data {
  Workspace workspace;
  SymmetricPattern pattern;
  cholmod_factor* L = nullptr;
  cholmod_dense *X = nullptr, *Y = nullptr, *E = nullptr;
  double flops = 0.0, entries = 0.0;
  int failed = -1;

  void release() {
    cholmod_common* c = &workspace.common;
    cholmod_free_factor(&L, c);
    cholmod_free_dense(&X, c);
    cholmod_free_dense(&Y, c);
    cholmod_free_dense(&E, c);
  }
  bool analyze() {
    cholmod_common& c = workspace.common;
    cholmod_free_factor(&L, &c);
    cholmod_sparse a = view(pattern, nullptr);
    L = cholmod_analyze(&a, &c);
    flops = c.fl;
    entries = c.lnz;
    return L != nullptr;
  }
  ~Data() { release(); }
};

CholmodFactor::CholmodFactor() = default;
CholmodFactor::CholmodFactor(CholmodFactor&&) noexcept = default;
CholmodFactor& CholmodFactor::operator=(CholmodFactor&&) noexcept = default;
CholmodFactor::~CholmodFactor() = default;

Status CholmodFactor::analyze(SymmetricPattern lower, Kind kind) {
  data_ = std::make_unique<Data>();
  cholmod_common& c = data_->workspace.common;
  c.method[0].ordering = CHOLMOD_NATURAL;
  c.postorder = 0;
  c.final_ll = kind == Kind::kLlt;
  c.supernodal = kind == Kind::kLlt ? CHOLMOD_AUTO : CHOLMOD_SIMPLICIAL;
  data_->pattern = std::move(lower);
  if (!data_->analyze()) return cholmod_status(c.status);
  if (data_->L->is_super) return {};
  // simplicial code reads the upper triangle
  data_->pattern = data_->pattern.flipped();
  c.supernodal = CHOLMOD_SIMPLICIAL;
  return data_->analyze() ? Status{} : cholmod_status(c.status);
}

const SymmetricPattern& CholmodFactor::pattern() const {
  return data_->pattern;
}
bool CholmodFactor::supernodal() const {
  return data_->L->is_super;
}
double CholmodFactor::flops() const {
  return data_->flops;
}
double CholmodFactor::factor_entries() const {
  return data_->entries;
}
int CholmodFactor::failed_column() const {
  return data_->failed;
}

Status CholmodFactor::factor(const double* values) {
  cholmod_common& c = data_->workspace.common;
  cholmod_sparse a = view(data_->pattern, values);
  data_->failed = -1;
  cholmod_factorize(&a, data_->L, &c);  // TRUE even if not positive definite: the news is in status and minor
  if (c.status < CHOLMOD_OK) return cholmod_status(c.status);
  if (c.status == CHOLMOD_NOT_POSDEF || data_->L->minor < data_->L->n) {
    data_->failed = static_cast<int>(data_->L->minor);
    return Status::failure(StatusCode::kSingular,
                           "pivot " + std::to_string(data_->failed) + " is not positive");
  }
  return {};
}

void CholmodFactor::solve(const double* b, double* x) {
  cholmod_dense rhs{};
  rhs.nrow = rhs.d = rhs.nzmax = static_cast<std::size_t>(data_->pattern.size);
  rhs.ncol = 1;
  rhs.x = const_cast<double*>(b);
  rhs.xtype = CHOLMOD_REAL;
  rhs.dtype = CHOLMOD_DOUBLE;
  cholmod_solve2(CHOLMOD_A, data_->L, &rhs, nullptr, &data_->X, nullptr, &data_->Y, &data_->E,
                 &data_->workspace.common);
  std::memcpy(x, data_->X->x, sizeof(double) * rhs.nrow);
}

double CholmodFactor::rcond() const {
  return cholmod_rcond(data_->L, &data_->workspace.common);
}

void CholmodFactor::read_pivots(VectorXd& out) const {
  const cholmod_factor& L = *data_->L;
  out.resize(static_cast<Eigen::Index>(L.n));
  const double* x = static_cast<const double*>(L.x);
  if (L.is_super) {
    const int *super = static_cast<const int*>(L.super), *rows = static_cast<const int*>(L.pi),
              *values = static_cast<const int*>(L.px);
    for (std::size_t s = 0; s < L.nsuper; ++s)
      for (int j = super[s]; j < super[s + 1]; ++j)
        out[j] = x[values[s] + (j - super[s]) * (rows[s + 1] - rows[s] + 1)];
  } else {
    const int* start = static_cast<const int*>(L.p);
    for (std::size_t j = 0; j < L.n; ++j) out[static_cast<Eigen::Index>(j)] = x[start[j]];
  }
  if (L.is_ll || L.is_super) out = out.cwiseAbs2();
}

CholmodFactor::Signs CholmodFactor::pivot_signs() const {
  Signs signs;
  FEDER_CHECK(!data_->L->is_super && !data_->L->is_ll, "pivot signs are those of an LDL^T");
  const int* start = static_cast<const int*>(data_->L->p);
  const double* value = static_cast<const double*>(data_->L->x);
  for (std::size_t j = 0; j < data_->L->n; ++j) {
    const double pivot = value[start[j]];
    ++(pivot > 0.0 ? signs.positive : pivot < 0.0 ? signs.negative : signs.other);
  }
  return signs;
}

}  // namespace feder
