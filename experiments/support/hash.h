#pragma once

#include <string>
#include <string_view>

namespace feder::experiments {

/// FNV-1a 64 as 16 hexadecimal digits: the same on every machine.
std::string text_hash(std::string_view text);

}  // namespace feder::experiments
