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
    reason_ = "dual: " + (no_primal.empty() ? sizes : no_primal);
    return analyze_named(system, geometric, DualSchur::kName);
  }
  reason_ = "primal: " + (no_dual.empty() ? sizes : no_dual);
  Status status = analyze_named(system, geometric, PrimalSchur::kName);
  reason_ += ", " + scientific(flops()) + " flops per factorisation";
  return status;
}

Status LinearSolver::analyze(const System& system, bool geometric) {
  const Stopwatch watch(times_.analyze);
  if (wanted_ == "auto") return choose(system, geometric);
  reason_ = wanted_ + ": asked for";
  return analyze_named(system, geometric, wanted_);
}

Status LinearSolver::factor(const Kkt& kkt) {
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

SolveReport LinearSolver::solve(const Kkt& kkt, VectorXd& v, VectorXd& y) {
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

std::string LinearSolver::route_name() const {
  return std::visit([](const auto& route) { return std::string(route.kName); }, route_);
}

double LinearSolver::flops() const {
  return std::visit([](const auto& route) { return route.flops(); }, route_);
}

}  // namespace feder
