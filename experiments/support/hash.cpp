#include "experiments/support/hash.h"

#include <fmt/format.h>

#include <cstdint>

namespace feder::experiments {

std::string text_hash(std::string_view text) {
  std::uint64_t hash = 14695981039346656037ULL;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
  return fmt::format("{:016x}", hash);
}

}  // namespace feder::experiments
