#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "engine/contacts.h"
#include "solvers/contact/impact_law.h"
#include "solvers/integrators.h"

namespace feder {

/// One moment at which surfaces met, with all contacts that did.
struct Impact {
  double t = 0.0;              ///< [s]
  ContactRows rows;            ///< those closed at t
  VectorXd impulse;            ///< 3 per contact, in its frame [N s]
  double approach = 0.0;       ///< fastest, before [m/s]
  double energy_change = 0.0;  ///< kinetic [J], <= 0 but for kNaive and kPoisson
  bool jammed = false;         ///< Painleve
};

struct ImpactOptions {
  double dt = 0.0;        ///< of the steps between impacts [s]
  double end_time = 0.0;  ///< [s]
  ImpactRule rule = ImpactRule::kStronge;
  double gap_tolerance = 1e-12;  ///< how closely an impact is located, of the largest coordinate plus 1 m
  double least_approach = 1e-6;  ///< slower impacts mean that the contact stays: the run ends [m/s]
  std::int64_t most_impacts = 1'000'000;
  double max_seconds = 0.0;                         ///< wall-clock budget [s], 0: none
  std::function<bool(const State&)> observer = {};  ///< after every step and impact; false ends the run
};

struct ImpactRun {
  Status status;
  std::int64_t steps = 0, impacts = 0;
  double seconds = 0.0;
  std::vector<Impact> record;
};

/// Runs any integrator between impacts, which it locates: a step that ends in penetration is taken again,
/// shorter, until it ends where the surfaces touch; there the velocities jump by `resolve_impacts`. Between
/// impacts the order is the integrator's.
///
/// Ends with kLimitReached, naming the contact, where a contact stays closed (bounces that die out, a resting
/// or sliding start): that is what implicit_euler_notes and implicit_euler_geometric are for. Two surfaces
/// that pass through each other within one step are not seen. InputError as simulate.
ImpactRun simulate_impacts(const System& system, const std::string& integrator, const IntegratorOptions& how,
                           State& state, History& history, const ImpactOptions& options);

/// The same system without what only contacts need: for integrators that do not see them.
System without_colliders(const System& system);

}  // namespace feder
