#include "experiments/support/energy_csv.h"

#include "engine/energy.h"

namespace feder::experiments {

void EnergyCsv::add(const Frame& frame, TextBuffer& text) const {
  const State& state = frame.state;
  const double kinetic = kinetic_energy(*system_, state), rows = row_energy(*system_, state),
               external = external_energy(*system_, state);
  const double energies[] = {kinetic, rows, external, kinetic + rows + external};
  text.add_number(state.t);
  text.add_cells(energies, 4);
  text.add_cells(linear_momentum(*system_, state).data(), 3);
  text.add_cells(angular_momentum(*system_, state).data(), 3);
  text.add("\n");
}

}  // namespace feder::experiments
