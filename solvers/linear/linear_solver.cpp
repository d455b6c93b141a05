#include "solvers/linear/linear_solver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "engine/check.h"
#include "solvers/stopwatch.h"

namespace feder {
namespace {

// Rows per unknown up to which the dual route is taken without asking: measured, it wins at every size for m
// <= n.
constexpr double kDualRowsPerUnknown = 1.0;
// Block Cholesky was measured ahead of CHOLMOD on chains and on nets up to here (4.6e9 flops: 2.6 times).
constexpr double kMostBlockFlops = 5e9;
// A backward error at this level is rounding: another refinement changes nothing.
constexpr double kRounding = 1e-15;

// Calls visit with a fresh object of each route type, in list order.
template <class Visit, std::size_t... I>
void for_each_route(Visit&& visit, std::index_sequence<I...>) {
  (visit(std::variant_alternative_t<I, Route>{}), ...);
}
template <class Visit>
void for_each_route(Visit&& visit) {
  for_each_route(std::forward<Visit>(visit), std::make_index_sequence<std::variant_size_v<Route>>{});
}

// Dropped rows that open more than this many times the others are looked at again: they may depend no longer.
constexpr double kOpen = 10.0, kClosed = 1e-9;
// Share of a row that must be new, at closed rows and at most; what a gap of the scene's size would add.
constexpr double kDependent = 1e-8, kMostDependent = 1e-3, kDrift = 10.0;

std::string scientific(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g", x);
  return text;
}

}  // namespace

std::vector<std::string> route_names() {
  std::vector<std::string> names;
  for_each_route([&](auto&& route) { names.emplace_back(route.kName); });
  return names;
}

LinearSolver::LinearSolver(std::string route, const SolveOptions& options)
    : wanted_(std::move(route)), options_(options) {
  std::string known = "auto";
  bool found = wanted_ == known;
  for (const std::string& name : route_names()) {
    known += ", " + name;
    found = found || name == wanted_;
  }
  if (!found) throw InputError("route = " + wanted_ + ", expected one of: " + known);
}

Status LinearSolver::analyze_named(const System& system, bool geometric, const std::string& name) {
  Status status;
  for_each_route([&](auto&& candidate) {
    using Candidate = std::decay_t<decltype(candidate)>;
    if (name != Candidate::kName) return;
    if (const std::string why = Candidate::refusal(system, geometric); !why.empty()) {
      status = Status::failure(StatusCode::kRefused, why);
      return;
    }
    status = route_.emplace<Candidate>().analyze(system, geometric);
  });
  return status;
}

// Dual for m <= n; otherwise the fewest predicted flops of primal and dual; kkt where both refuse.
Status LinearSolver::choose(const System& system, bool geometric) {
  const std::string sizes =
      std::to_string(system.active_rows) + " rows, " + std::to_string(system.free_count) + " unknowns";
  const std::string no_dual = DualSchur::refusal(system, geometric),
                    no_primal = PrimalSchur::refusal(system, geometric);
  if (!no_dual.empty() && !no_primal.empty()) {
    reason_ = "kkt: " + no_dual + "; " + no_primal;
    return analyze_named(system, geometric, KktLdlt::kName);
  }
  if (no_dual.empty() &&
      (!no_primal.empty() || system.active_rows <= kDualRowsPerUnknown * system.free_count)) {
    const std::string why = no_primal.empty() ? sizes : no_primal;
    if (DualBlocks::refusal(system, geometric).empty()) {
      reason_ = "dual_blocks: ball joints alone, " + why;
      Status status = analyze_named(system, geometric, DualBlocks::kName);
      if (!status.ok() || flops() <= kMostBlockFlops) return status;
    }
    reason_ = "dual: " + why;
    return analyze_named(system, geometric, DualSchur::kName);
  }
  reason_ = "primal: " + (no_dual.empty() ? sizes : no_dual);
  Status status = analyze_named(system, geometric, PrimalSchur::kName);
  reason_ += ", " + scientific(flops()) + " flops per factorisation";
  return status;
}

Status LinearSolver::analyze(const System& system, bool geometric) {
  const Stopwatch watch(times_.analyze);
  rank_ = {};
  rank_known_ = false;
  suspicious_ = kSuspicious;
  if (wanted_ == "auto") return choose(system, geometric);
  reason_ = wanted_ + ": asked for";
  return analyze_named(system, geometric, wanted_);
}

Status LinearSolver::factor_with(const Kkt& kkt) {
  return std::visit(
      [&](auto& route) {
        {
          const Stopwatch watch(times_.assemble);
          route.assemble(kkt);
        }
        const Stopwatch watch(times_.factor);
        ++times_.factorizations;
        return route.factor(kkt);
      },
      route_);
}

Status LinearSolver::look_at_rank(Kkt& kkt) {
  kkt.drop_rows({});
  // rows that drift has opened by a gap depend on each other only up to about gap / size
  const double drift = rank_known_ && kkt.scale() > 0.0 ? kDrift * kkt.kept_gap() / kkt.scale() : 0.0;
  rank_ = hard_row_rank(kkt, std::clamp(drift, kDependent, kMostDependent));
  rank_known_ = true;
  ++times_.rank_checks;
  kkt.drop_rows(rank_.dependent);
  return factor_with(kkt);
}

Status LinearSolver::factor(Kkt& kkt) {
  if (!kkt.system->has_hard_rows) return factor_with(kkt);
  const bool dual = std::holds_alternative<DualSchur>(route_) || std::holds_alternative<DualBlocks>(route_);
  const auto least_pivot = [&] {
    return std::visit(
        [](const auto& route) {
          if constexpr (requires { route.smallest_pivot_ratio(); })
            return route.smallest_pivot_ratio();
          else
            return 1.0;
        },
        route_);
  };
  const bool open =
      !kkt.dropped().empty() && kkt.dropped_gap() > kOpen * kkt.kept_gap() + kClosed * kkt.scale();
  if (open || (!dual && !rank_known_)) {
    Status status = look_at_rank(kkt);
    return status.ok() ? judge_dropped_rows(kkt) : status;
  }
  Status status = factor_with(kkt);
  const double pivot = status.ok() ? least_pivot() : 0.0;
  if (!(pivot < suspicious_) || status.code == StatusCode::kNonFinite) return status;
  status = look_at_rank(kkt);
  if (!status.ok()) return status;
  suspicious_ = std::min(kSuspicious, 0.01 * least_pivot());
  return judge_dropped_rows(kkt);
}

// Rows that depend on others must be closed by what closes those: J_kept w = -phi_kept gives J_dropped w.
Status LinearSolver::judge_dropped_rows(Kkt& kkt) {
  constexpr double kContradiction = 1e-6;
  if (kkt.dropped().empty()) return {};
  const VectorXd p = kkt.p, r = kkt.r;
  kkt.p.setZero();
  kkt.r = kkt.phi;
  for (int k = 0; k < kkt.r.size(); ++k)
    if (kkt.gamma[k] > 0.0) kkt.r[k] = 0.0;
  VectorXd w, y;
  const SolveReport report = solve_once(kkt, w, y);
  kkt.p = p, kkt.r = r;
  if (!report.status.ok()) return report.status;
  const auto [row, gap] = kkt.dropped_gap_after(w);
  const double curvature = kkt.kept_gap() * kkt.kept_gap() / kkt.scale();  // of rows that are not closed
  if (!(gap > kContradiction * kkt.scale() + curvature)) return {};
  return Status::failure(StatusCode::kInconsistent,
                         kkt.system->row_name(row) + " contradicts rows it depends on: " + scientific(gap) +
                             " m or rad stay open when they close");
}

SolveReport LinearSolver::solve(Kkt& kkt, VectorXd& v, VectorXd& y) {
  SolveReport report = solve_once(kkt, v, y);
  if (report.status.code == StatusCode::kSingular && kkt.system->has_hard_rows &&
      report.backward_error > options_.accept_below) {
    const int before = rank_known_ ? rank_.rank : -1;
    if (Status status = look_at_rank(kkt); status.ok() && rank_.rank != before)
      report = solve_once(kkt, v, y);
  }
  report.redundant_rows = static_cast<int>(kkt.dropped().size());
  times_.worst_backward_error = std::max(times_.worst_backward_error, report.backward_error);
  return report;
}

SolveReport LinearSolver::solve_once(const Kkt& kkt, VectorXd& v, VectorXd& y) {
  SolveReport report;
  std::visit(
      [&](auto& route) {
        ++times_.solves;
        {
          const Stopwatch watch(times_.transfer);
          route.reduce(kkt, kkt.p, kkt.r);
        }
        {
          const Stopwatch watch(times_.solve);
          route.substitute();
        }
        {
          const Stopwatch watch(times_.transfer);
          route.expand(kkt, kkt.p, kkt.r, v, y);
        }
        ResidualSize size;
        {
          const Stopwatch watch(times_.residual);
          size = kkt.residual_size(v, y);
        }
        // K d = residual, x += d, as long as it halves one of the two errors
        const Stopwatch watch(times_.refine);
        bool helps = true;
        const double rounding = std::min(options_.refine_above, kRounding);
        auto too_large = [&] {
          return size.backward_error > options_.refine_above ||
                 (size.balance_error > options_.refine_above && size.backward_error > rounding);
        };
        if (too_large()) size = kkt.residual(v, y, &residual_v_, &residual_y_);
        while (helps && too_large() && report.refinements < options_.most_refinements) {
          const ResidualSize before = size;
          route.reduce(kkt, residual_v_, residual_y_);
          route.substitute();
          route.expand(kkt, residual_v_, residual_y_, correction_v_, correction_y_);
          v += correction_v_;
          y += correction_y_;
          size = kkt.residual(v, y, &residual_v_, &residual_y_);
          ++report.refinements;
          ++times_.refinements;
          helps = size.balance_error < 0.5 * before.balance_error ||
                  size.backward_error < 0.5 * before.backward_error;
          if (!helps &&
              !(size.balance_error < before.balance_error)) {  // no better: take the correction back
            v -= correction_v_;
            y -= correction_y_;
            size = before;
          }
        }
        report.backward_error = size.backward_error;
        report.balance_error = size.balance_error;
        report.inertia = route.inertia();
        if (options_.estimate_condition) report.rcond = route.rcond();
      },
      route_);
  const System& s = *kkt.system;
  if (!std::isfinite(report.balance_error))
    report.status =
        Status::failure(StatusCode::kNonFinite, "the solve by the " + route_name() + " route is not finite");
  else if (report.inertia.positive != s.free_count || report.inertia.negative != s.active_rows)
    report.status = Status::failure(
        StatusCode::kSingular,
        "inertia (" + std::to_string(report.inertia.positive) + ", " +
            std::to_string(report.inertia.negative) + ", " + std::to_string(report.inertia.zero) +
            "), expected (" + std::to_string(s.free_count) + ", " + std::to_string(s.active_rows) + ", 0)");
  else if (report.backward_error > options_.accept_below)
    report.status = Status::failure(StatusCode::kSingular,
                                    "backward error " + scientific(report.backward_error) + " of the " +
                                        route_name() + " route exceeds " + scientific(options_.accept_below));
  return report;
}

void LinearSolver::respond(const Kkt& kkt, const VectorXd& force, VectorXd& v) {
  const Stopwatch watch(times_.solve);
  no_rate_.setZero(kkt.r.size());
  std::visit(
      [&](auto& route) {
        route.reduce(kkt, force, no_rate_);
        route.substitute();
        route.expand(kkt, force, no_rate_, v, correction_y_);
      },
      route_);
}

std::string LinearSolver::route_name() const {
  return std::visit([](const auto& route) { return std::string(route.kName); }, route_);
}

double LinearSolver::flops() const {
  return std::visit([](const auto& route) { return route.flops(); }, route_);
}

}  // namespace feder
