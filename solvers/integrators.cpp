#include "solvers/integrators.h"

#include <optional>

#include "engine/check.h"
#include "engine/fluid/fluid.h"

namespace feder {

std::vector<IntegratorInfo> integrator_list() {
  std::vector<IntegratorInfo> list;
  for_each_integrator([&]<IntegratorType T>() { list.push_back(T::kInfo); });
  return list;
}

Integrator make_integrator(const std::string& name, const System& system, const IntegratorOptions& options) {
  std::optional<Integrator> made;
  std::string known;
  for_each_integrator([&]<IntegratorType T>() {
    known += (known.empty() ? "" : ", ") + std::string(T::kInfo.name);
    if (name == T::kInfo.name) made.emplace(T(system, options));
  });
  if (!made) throw InputError("integrator = " + name + ", expected one of: " + known);
  return std::move(*made);
}

const IntegratorInfo& info(const Integrator& integrator) {
  return std::visit([](const auto& i) -> const IntegratorInfo& { return i.kInfo; }, integrator);
}

std::string refusal(const Integrator& integrator, const System& system) {
  if (!system.colliders.empty() && !info(integrator).contacts)
    return std::string(info(integrator).name) +
           " does not see colliders in its step: run it between impacts (simulate_impacts), or take one of "
           "implicit_euler_notes, implicit_euler_geometric";
  if (system.fluid && system.fluid->incompressible() && !info(integrator).incompressible)
    return std::string(info(integrator).name) +
           " has no rows for the density of an incompressible fluid: give it a sound speed, or take "
           "symplectic_euler";
  return std::visit([&](const auto& i) { return i.refusal(system); }, integrator);
}

const StepCounts& counts(const Integrator& integrator) {
  return std::visit([](const auto& i) -> const StepCounts& { return i.counts(); }, integrator);
}

LinearSolver* linear_solver(Integrator& integrator) {
  return std::visit(
      [](auto& i) -> LinearSolver* {
        if constexpr (requires { i.solver(); })
          return &i.solver();
        else if constexpr (requires { i.row_solver(); })
          return i.row_solver();
        else
          return nullptr;
      },
      integrator);
}

}  // namespace feder
