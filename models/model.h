#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/state.h"
#include "engine/system.h"

namespace feder {

/// A number that stays constant along every motion of the model.
struct Conserved {
  std::string name;
  std::string unit;
  std::function<double(const System&, const State&)> value;
};

/// kinetic + row + external energy [J].
Conserved conserved_energy();

/// What one can study: a system, where it starts, how long to watch, and what is known about its motion.
struct Model {
  std::string name;  ///< the spec it was made from, for example "chain:n=100"
  System system;
  State state;                ///< at t = 0
  double end_time = 0.0;      ///< [s]
  double scene_length = 0.0;  ///< turns position errors into fractions [m]
  /// The exact motion in the model's own node numbering, q and v; empty if unknown. exact(0) is `state`.
  std::function<State(double t)> exact = nullptr;
  bool exact_is_smooth = true;  ///< false where impacts or switches limit the order that can be measured
  std::vector<Conserved> conserved = {};
};

/// key = value, as text.
struct Setting {
  std::string key, value;
};
using Settings = std::vector<Setting>;

/// A parameter as the user sees it; all parts are text ready to print.
struct Parameter {
  std::string name, default_value, unit, what, expectation;
};

/// A named scene "S1(N)" or "S3b(N,M)": the sizes go to the parameters `arguments`, "n" or "nx,ny"; `fixed`
/// are further settings.
struct Preset {
  std::string name, arguments;
  Settings fixed;
  std::string what;
};

/// An entry of the catalogue.
struct ModelInfo {
  std::string name, description;
  std::vector<Parameter> parameters;
  std::vector<Preset> presets;
  std::function<Model(const Settings&)> build;  ///< throws InputError with the place and the value
};

}  // namespace feder
