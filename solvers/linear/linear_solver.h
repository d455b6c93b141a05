#pragma once

#include <string>
#include <vector>

#include "engine/kkt.h"
#include "solvers/linear/routes.h"
#include "solvers/linear/row_rank.h"

namespace feder {

/// Limits of a solve. Errors as in ResidualSize: always those of the unreduced KKT system.
struct SolveOptions {
  double refine_above = 1e-12;  ///< refine while an error exceeds this and refinement halves one
  double accept_below = 1e-11;  ///< backward error above which the solve has failed
  int most_refinements = 10;
  bool estimate_condition = false;  ///< fill SolveReport::rcond
};

/// The certificate of a solve.
struct SolveReport {
  Status status;
  double backward_error = 0.0, balance_error = 0.0;
  Inertia inertia;      ///< of the KKT matrix; anything but (n, m, 0) is a failure
  double rcond = -1.0;  ///< estimate from the factor of the route's own matrix; -1 if not asked for
  int refinements = 0;
  /// Hard rows dropped because they depend on others. Then v and the rows' force are right, the multipliers
  /// are one of many (0 on those dropped); `least_norm_multipliers` gives the smallest.
  int redundant_rows = 0;
};

/// Seconds spent per phase since the last reset, and how often.
struct PhaseTimes {
  double analyze = 0.0, assemble = 0.0, factor = 0.0, residual = 0.0, refine = 0.0;
  double transfer = 0.0;  ///< right-hand side to the route's unknowns, and back
  double solve = 0.0;     ///< forward and back substitution
  long rank_checks = 0;
  long factorizations = 0, solves = 0, refinements = 0;
  double worst_backward_error = 0.0;  ///< of those solves
};

/// A route in use: analyze once per scene, factor per linearisation, solve per right-hand side.
///
///     LinearSolver solver("auto");
///     if (Status s = solver.analyze(system, false); !s.ok()) ...
///     if (Status s = solver.factor(kkt); !s.ok()) ...
///     SolveReport report = solver.solve(kkt, v, y);     // kkt.p and kkt.r are the right-hand side
class LinearSolver {
 public:
  /// "kkt", "primal", "dual", "dual_blocks", "dense" or "auto". Throws InputError for any other name.
  explicit LinearSolver(std::string route = "auto", const SolveOptions& options = {});

  /// Chooses (for "auto") and analyses. kRefused, with the reason, if the named route does not admit the
  /// scene.
  Status analyze(const System& system, bool geometric);
  /// Hard rows: looks at their rank after analyze (dual route: where a pivot is suspicious), again where
  /// those dropped open or a solve misses its residual, and drops dependent ones from `kkt`. kInconsistent,
  /// naming one, if what closes the others does not close it.
  Status factor(Kkt& kkt);
  SolveReport solve(Kkt& kkt, VectorXd& v, VectorXd& y);

  /// v = the velocities of A^-1 [force; 0] by the last factor, without certificate or refinement: columns of
  /// the Delassus matrix of contacts.
  void respond(const Kkt& kkt, const VectorXd& force, VectorXd& v);

  std::string route_name() const;
  /// Why this route: rows against unknowns, predicted flops of those considered.
  const std::string& choice_reason() const { return reason_; }
  double flops() const;
  /// Of the hard rows, as last looked at; full if never suspicious.
  const RowRank& rank() const { return rank_; }
  const Route& route() const { return route_; }
  const PhaseTimes& times() const { return times_; }
  void reset_times() { times_ = {}; }
  SolveOptions& options() { return options_; }

 private:
  Status analyze_named(const System& system, bool geometric, const std::string& name);
  Status choose(const System& system, bool geometric);

  static constexpr double kSuspicious = 1e-12;

  Status factor_with(const Kkt& kkt);
  Status look_at_rank(Kkt& kkt);
  Status judge_dropped_rows(Kkt& kkt);
  SolveReport solve_once(const Kkt& kkt, VectorXd& v, VectorXd& y);

  std::string wanted_, reason_;
  SolveOptions options_;
  Route route_;
  PhaseTimes times_;
  bool rank_known_ = false;          // looked at since analyze
  double suspicious_ = kSuspicious;  // pivot ratio (squared sine) below which rows may depend on each other
  RowRank rank_;
  VectorXd residual_v_, residual_y_, correction_v_, correction_y_, no_rate_;
};

/// Names of all routes in the list, "dense" last.
std::vector<std::string> route_names();

}  // namespace feder
