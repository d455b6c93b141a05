#pragma once

#include <string>
#include <string_view>

namespace feder {

/// Reads a text word by word; messages are "<where>:<line>: found '...', expected ...".
class MeshText {
 public:
  MeshText(const std::string& where, std::string_view text) : where_(where), text_(text) {}

  /// Goes to the start of the next line (first of all, of the first). False at the end.
  bool next_line();
  /// Another word before the line ends or a comment (#) starts?
  bool more_on_line();
  /// The next word of this line, empty at its end.
  std::string_view word();
  /// The next word, on whichever line; empty at the end.
  std::string_view word_anywhere();
  /// The next word of this line as a finite number.
  double number(const char* what);

  int line() const { return line_; }
  /// Throws InputError: the last word is not what was expected.
  [[noreturn]] void fail(const std::string& expected) const;
  [[noreturn]] void fail_line(const std::string& what) const { fail_at(line_, what); }
  [[noreturn]] void fail_at(int line, const std::string& what) const;

 private:
  std::string where_;
  std::string_view text_, word_;
  std::size_t at_ = 0;
  int line_ = 0;
};

}  // namespace feder
