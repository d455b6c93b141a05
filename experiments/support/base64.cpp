#include "experiments/support/base64.h"

#include <array>
#include <cstdint>
#include <cstring>

namespace feder::experiments {
namespace {

constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// The two digits of every 12-bit number.
constexpr auto kPairs = [] {
  std::array<std::array<char, 2>, 4096> pairs{};
  for (std::size_t i = 0; i < pairs.size(); ++i) pairs[i] = {kDigits[i >> 6], kDigits[i & 63]};
  return pairs;
}();

std::uint32_t three_bytes(const unsigned char* at) {
  return static_cast<std::uint32_t>(at[0]) << 16 | static_cast<std::uint32_t>(at[1]) << 8 | at[2];
}

void put(std::uint32_t bits, char* out) {
  std::memcpy(out, kPairs[bits >> 12].data(), 2);
  std::memcpy(out + 2, kPairs[bits & 4095].data(), 2);
}

}  // namespace

void encode_base64(std::string_view bytes, char* out) {
  const auto* at = reinterpret_cast<const unsigned char*>(bytes.data());
  std::size_t left = bytes.size();
  for (; left >= 3; left -= 3, at += 3, out += 4) put(three_bytes(at), out);
  if (left == 0) return;
  const unsigned char last[3] = {at[0], left == 2 ? at[1] : static_cast<unsigned char>(0), 0};
  put(three_bytes(last), out);
  out[3] = '=';
  if (left == 1) out[2] = '=';
}

}  // namespace feder::experiments
