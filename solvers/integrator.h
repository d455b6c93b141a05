#pragma once

#include <string>

#include "engine/energy.h"
#include "engine/kkt.h"
#include "engine/status.h"
#include "solvers/linear/linear_solver.h"

namespace feder {

/// How a sweep shares a correction among the nodes of a row.
enum class RowWeights {
  kMass,    ///< by inverse mass: closes the row
  kHalved,  ///< half of that, as the notes print it (H5): kept to show what is lost
};

/// What every integrator is built with; each takes what it needs.
struct IntegratorOptions {
  std::string route = "auto";  ///< linear route of the implicit ones
  SolveOptions solve = {};
  RotationUpdate rotation_update = RotationUpdate::kExponential;  ///< explicit Euler, one-step implicit Euler
  double newton_tolerance = 1e-14;  ///< relative residual of the momentum balance
  int most_newton_iterations = 200;
  int sweeps = 20;           ///< over the rows, per substep
  int substeps = 1;          ///< equal parts a step of the sweeping ones is cut into
  bool frozen_rows = false;  ///< sweeps keep J and the linear phi of the substep's start
  RowWeights row_weights = RowWeights::kMass;
};

/// What an integrator tells about itself.
struct IntegratorInfo {
  const char* name;
  int order;  ///< of the position error at a fixed time
  bool implicit;
  bool symmetric;  ///< its own adjoint: the error has even powers of dt only; symplectic without damping
  const char* summary;
  bool contacts = false;        ///< keeps colliders apart within its step; others run between impacts
  bool iterative = false;       ///< rows are held only as well as its sweeps do
  bool incompressible = false;  ///< holds a fluid of infinite sound speed
};

/// Work done since prepare().
struct StepCounts {
  long steps = 0;
  long force_evaluations = 0;
  long newton_iterations = 0;
  long line_search_cuts = 0;
  double position_drift = 0.0, velocity_drift = 0.0;  ///< largest |phi| and |J v + phi_t| before a projection
  long indefinite_matrices = 0;  ///< with the Kg tried; tried again with less of its negative part
};

/// Seconds of the phases of a step that are not the linear solver's.
struct StepTimes {
  double evaluate = 0.0, update = 0.0;
};

/// The contract of an integrator type T (checked by the compiler where the list is used):
///   static constexpr IntegratorInfo kInfo;
///   static std::string refusal(const System&);            empty if it admits the scene
///   T(const System&, const IntegratorOptions&);           keeps a pointer to the system
///   Status prepare();                                     analysis, once
///   Status step(double dt, State&, History&, EnergyLedger*);
/// A step starts at state.t and adds dt to it; on failure state and history are as before, bitwise. `ledger`
/// may be null.
template <class T>
concept IntegratorType = requires(T integrator, const System& system, const IntegratorOptions& options,
                                  State& state, History& history, EnergyLedger* ledger) {
  T(system, options);
  { T::kInfo.name } -> std::convertible_to<const char*>;
  { T::refusal(system) } -> std::convertible_to<std::string>;
  { integrator.prepare() } -> std::same_as<Status>;
  { integrator.step(0.1, state, history, ledger) } -> std::same_as<Status>;
  { integrator.counts() } -> std::convertible_to<const StepCounts&>;
};

/// Why an explicit integrator cannot take the scene: it has no matrix to hold a hard row. Empty if it can.
std::string refuse_hard_rows(const System& system, const char* integrator);

}  // namespace feder
