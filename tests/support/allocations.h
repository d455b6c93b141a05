// Counts heap requests of the test executable: operator new, and malloc as Eigen calls it (linked with
// --wrap=malloc).
#pragma once

namespace feder {

/// Requests since the program started.
long allocations();

}  // namespace feder
