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

  void add(TextPlace place, const std::string& message);
  std::size_t count() const { return problems_.size(); }
  bool empty() const { return problems_.empty(); }
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
  std::vector<Problem> problems_;
};

}  // namespace feder
