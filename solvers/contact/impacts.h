#pragma once

#include "engine/contacts.h"
#include "solvers/contact/contact_problem.h"
#include "solvers/contact/delassus.h"
#include "solvers/contact/impact_law.h"
#include "solvers/linear/linear_solver.h"

namespace feder {

/// What simultaneous impacts did.
struct ImpactOutcome {
  Status status;
  VectorXd impulse;            ///< 3 per contact, in its frame [N s]
  double energy_change = 0.0;  ///< y.(u + u')/2 <= 0 [J]
  int rounds = 0;
  bool jammed = false;  ///< some contact was in a Painleve configuration
};

/// Resolves the impacts of all contacts that approach, given how velocities answer impulses; `v` is changed.
/// Springs and gravity do nothing in no time; hard rows do, through `respond`.
///
/// Round by round, until no contact approaches: a contact that approaches alone takes the rule of
/// impact_law.h. Several at once take (1 + e) times the impulse that would stop them all together (the
/// contact law with u_n >= 0): it lies in the friction cones, and with one e it never gains energy, since
/// with u_c the velocity stopped
///   dE = (1 + e) (y.u_c - (1 - e)/2 y.W y) <= 0,   y.u_c = y_t.u_ct <= 0
/// (generalised reflections, Smith et al. 2012, with friction). Where the contacts' e differ the rebound is
/// scaled back until energy does not rise.
ImpactOutcome resolve_impacts(const ContactRows& rows, const Response& respond, ImpactRule rule, VectorXd& v);

/// Answers impulses at a pose: by M^-1, and through the hard rows of the system where it has some.
class ImpactResponse {
 public:
  explicit ImpactResponse(const System& system);
  /// Before resolve_impacts, for every new q.
  Status at(const VectorXd& q);
  void operator()(const VectorXd& force, VectorXd& v);

 private:
  const System* system_;
  Kkt kkt_;
  LinearSolver solver_;
  bool analyzed_ = false;
};

}  // namespace feder
