#pragma once

#include <nlohmann/json.hpp>

namespace feder::experiments {

/// What every manifest says about the program. For sources alone: no other header includes this one.
nlohmann::ordered_json build_json();
/// What every manifest says about the machine; `threads` are those of the linear algebra.
nlohmann::ordered_json machine_json(int threads);

}  // namespace feder::experiments
