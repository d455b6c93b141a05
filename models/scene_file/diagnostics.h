#pragma once

#include <string>
#include <vector>

#include "engine/check.h"
#include "models/scene_file/value.h"

namespace feder {

/// Bad input in a scene file; what() holds one line per problem, "file:line:column: ...".
class SceneError : public InputError {
 public:
  using InputError::InputError;
};

/// Collects the problems of one file, so that all are told at once.
class Diagnostics {
 public:
  /// `file` as messages name it; `changes` are the texts of --set.
  explicit Diagnostics(std::string file, std::vector<std::string> changes = {});

  /// Of a million problems, only those that will be shown are kept.
  void add(TextPlace place, const std::string& message);
  /// Would a problem here be among those shown? Saves the search for words like a misspelt one.
  bool shows(TextPlace place) const;
  std::size_t count() const { return count_; }
  bool empty() const { return count_ == 0; }
  /// Throws SceneError with the problems in file order, at most kMostShown of them.
  void throw_if_any() const;

  static constexpr std::size_t kMostShown = 20;

 private:
  struct Problem {
    TextPlace place;
    std::string message;
  };
  std::string file_;
  std::vector<std::string> changes_;
  std::vector<Problem> problems_;  // the first kMostShown in file order
  std::size_t count_ = 0;
};

}  // namespace feder
