#include "models/model.h"

#include "engine/energy.h"

namespace feder {

Conserved conserved_energy() {
  return {"energy", "J", total_energy};
}

}  // namespace feder
