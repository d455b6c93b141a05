#pragma once

#include <cstddef>
#include <string_view>

namespace feder::experiments {

/// Characters of `bytes` bytes in base64, padding included.
constexpr std::size_t base64_size(std::size_t bytes) {
  return (bytes + 2) / 3 * 4;
}
/// RFC 4648, section 4: writes base64_size(bytes.size()) characters.
void encode_base64(std::string_view bytes, char* out);

}  // namespace feder::experiments
