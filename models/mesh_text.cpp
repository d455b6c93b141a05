#include "models/mesh_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

}  // namespace

bool MeshText::next_line() {
  if (line_ > 0) {
    at_ = std::min(text_.find('\n', at_), text_.size());
    if (at_ < text_.size()) ++at_;
  }
  if (at_ == text_.size()) return false;
  ++line_;
  return true;
}

bool MeshText::more_on_line() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  return at_ < text_.size() && text_[at_] != '\n' && text_[at_] != '#';
}

std::string_view MeshText::word() {
  std::size_t end = at_;
  if (more_on_line())
    for (end = at_; end < text_.size() && text_[end] != '\n' && !is_space(text_[end]);) ++end;
  else
    end = at_;
  word_ = text_.substr(at_, end - at_);
  at_ = end;
  return word_;
}

std::string_view MeshText::word_anywhere() {
  while (!more_on_line())
    if (!next_line()) return word_ = {};
  return word();
}

double MeshText::number(const char* what) {
  std::string_view digits = word();
  if (digits.starts_with('+') && !digits.starts_with("+-")) digits.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (error != std::errc() || end != digits.data() + digits.size() || !std::isfinite(value))
    fail(std::string(what) + " that is a finite number");
  return value;
}

void MeshText::fail(const std::string& expected) const {
  fail_line("found " +
            (!word_.empty()        ? quoted(std::string(word_))
             : at_ == text_.size() ? "the end of the file"
                                   : "the end of the line") +
            ", expected " + expected);
}

void MeshText::fail_at(int line, const std::string& what) const {
  throw InputError(where_ + ":" + std::to_string(line) + ": " + what);
}

}  // namespace feder
