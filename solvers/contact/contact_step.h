#pragma once

#include <vector>

#include "engine/contacts.h"
#include "solvers/contact/contact_problem.h"
#include "solvers/contact/held_contacts.h"
#include "solvers/linear/linear_solver.h"

namespace feder {

/// What contacts cost and did since prepare().
struct ContactCounts {
  long steps = 0;                          ///< with at least one contact row
  long contacts = 0;                       ///< rows / 3, summed over steps
  long newton_iterations = 0, sweeps = 0;  ///< of the contact law on the Delassus matrix
  long passes = 0;                         ///< solves that held contacts took beyond the step's own
  long factorizations = 0;                 ///< of the step matrix beyond the step's own
  long corrections = 0;                    ///< steps whose penetration was pushed out
  double deepest = 0.0;                    ///< penetration met [m]
  double violation = 0.0;      ///< worst violation of the law that was accepted, relative to the largest |b|
  double seconds_own = 0.0;    ///< the step's own factorisation and solve
  double seconds_find = 0.0;   ///< finding contacts
  double seconds_solve = 0.0;  ///< everything else beyond the step's own factorisation and solve
};

/// Contacts of an implicit step, on top of the step matrix A of the system's own rows. With v* = A^-1 [p; r]
/// the velocity without contacts, the impulses y solve the contact law for
///
///     u = J v' = J v* + J A^-1 J^T y,      v' = A^-1 [p + J^T y; r]
///
/// The normal row asks for u_n >= -gap/dt where the gap is open (the step ends touching at most), u_n >= 0
/// where it is closed, and u_n >= -e u_n(start) where the surfaces meet within the step faster than
/// `threshold`. Penetration beyond kSlop is pushed out by a second set of impulses that moves places but not
/// velocities, so it adds no energy.
class ContactStep {
 public:
  explicit ContactStep(const System& system) : system_(&system), finder_(system) {}
  /// Between assembling p and r and taking v: replaces solver.factor and solver.solve. v and y as theirs.
  Status solve(double dt, const State& state, const History& history, Kkt& kkt, LinearSolver& solver,
               VectorXd& v, VectorXd& y, SolveReport& report);
  /// Velocity that moves places over this step: v' and what pushes penetrations out.
  const VectorXd& place_velocity(const VectorXd& v) const { return pushed_ ? place_velocity_ : v; }
  /// Impulses of the step, for the next one's start.
  void remember(History& history) const;
  /// p without what contacts added, for the ledger [N s]; v.B v of the blocks that hold particles [J].
  const VectorXd& momentum() const { return p_; }
  double block_work(const VectorXd& v) const { return held_.block_work(rows_, v); }
  double work(const VectorXd& v) const;  ///< of the contacts, y.(J v') [J]

  const ContactRows& rows() const { return rows_; }
  const VectorXd& impulses() const { return impulse_; }  ///< 3 per contact, in its frame [N s]
  const ContactCounts& counts() const { return counts_; }
  ContactOptions& options() { return options_; }
  double threshold = 1e-2;  ///< approach below which a contact does not rebound [m/s]

 private:
  void set_targets(double dt, const State& state);
  void start_from(double dt, const History& history);
  Status solve_free(Kkt& kkt, LinearSolver& solver, bool factored, VectorXd& v, VectorXd& y,
                    SolveReport& report);
  Status push_out(double dt, const VectorXd& v);

  const System* system_;
  ContactFinder finder_;
  ContactOptions options_;
  ContactRows rows_, free_rows_;  // all, and those that go through W
  std::vector<int> free_;         // their places among all
  HeldContacts held_;
  ContactProblem problem_;
  Eigen::MatrixXd responses_;  // A^-1 J^T of the free ones
  VectorXd target_;            // least normal velocity per contact [m/s]
  VectorXd impulse_, free_impulse_, velocity_, place_velocity_, p_;
  bool pushed_ = false;
  ContactCounts counts_;
};

}  // namespace feder
