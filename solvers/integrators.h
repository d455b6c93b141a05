#pragma once

#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "solvers/explicit_euler.h"
#include "solvers/implicit_euler.h"
#include "solvers/implicit_euler_newton.h"
#include "solvers/leapfrog.h"
#include "solvers/rk4.h"
#include "solvers/symplectic_euler.h"
#include "solvers/xpbd.h"

namespace feder {

/// THE LIST of time integrators. Adding one is its file pair and its name here; tests and experiments pick it
/// up.
using Integrator = std::variant<ExplicitEuler, SymplecticEuler, Leapfrog, Rk4, ImplicitEulerNotes,
                                ImplicitEulerGeometric, ImplicitEulerNewton, Xpbd>;

/// Calls visit.template operator()<T>() for every integrator type, in list order.
template <class Visit>
void for_each_integrator(Visit&& visit) {
  [&]<std::size_t... I>(std::index_sequence<I...>) {
    (visit.template operator()<std::variant_alternative_t<I, Integrator>>(), ...);
  }
  (std::make_index_sequence<std::variant_size_v<Integrator>>{});
}

std::vector<IntegratorInfo> integrator_list();

/// By name; throws InputError listing the names if there is none like it. The system must outlive the
/// integrator.
Integrator make_integrator(const std::string& name, const System& system,
                           const IntegratorOptions& options = {});

const IntegratorInfo& info(const Integrator& integrator);
/// Empty if the integrator admits the scene, otherwise the reason, naming the row.
std::string refusal(const Integrator& integrator, const System& system);
const StepCounts& counts(const Integrator& integrator);
/// The linear solver of an implicit integrator, or of an explicit one that holds or damps rows with one; null
/// for the others.
LinearSolver* linear_solver(Integrator& integrator);

}  // namespace feder
