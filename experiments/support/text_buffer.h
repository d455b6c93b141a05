#pragma once

#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>

namespace feder::experiments {

/// Text that grows and is used again: no allocation once it has reached its size.
class TextBuffer {
 public:
  void clear() { size_ = 0; }
  std::string_view text() const { return {storage_.data(), size_}; }

  void add(std::string_view text) {
    std::memcpy(room(text.size()), text.data(), text.size());
    size_ += text.size();
  }
  /// The shortest digits (at most 17) that read back to the same bits.
  template <class Number>
  requires std::same_as<Number, double> || std::integral<Number>
  void add_number(Number value) {
    char* begin = room(kLongestNumber);
    size_ += static_cast<std::size_t>(std::to_chars(begin, begin + kLongestNumber, value).ptr - begin);
  }
  /// Each number with a comma in front.
  void add_cells(const double* values, std::ptrdiff_t count) {
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      add(",");
      add_number(values[i]);
    }
  }
  void add_bytes(const double* values, std::ptrdiff_t count) {
    add({reinterpret_cast<const char*>(values), static_cast<std::size_t>(count) * sizeof(double)});
  }

 private:
  static constexpr std::size_t kLongestNumber = 32;  // "-1.7976931348623157e+308" has 24

  char* room(std::size_t count) {
    if (storage_.size() < size_ + count) storage_.resize(2 * (size_ + count));
    return storage_.data() + size_;
  }

  std::string storage_;
  std::size_t size_ = 0;
};

}  // namespace feder::experiments
