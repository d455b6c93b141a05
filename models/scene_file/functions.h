#pragma once

#include <optional>
#include <string>

#include "models/scene_file/keys.h"
#include "models/scene_file/laws.h"

namespace feder {

// What the file writes as a number, an expression or a table, made callable. Problems are told with the
// column inside the text; then nothing is returned.

/// Of time.
std::optional<Target> target_of(const FunctionText& text, const std::string& where, Diagnostics& problems);
/// Of length and rate; its energy counts from `rest` [m].
std::optional<SpringLaw> law_of(const FunctionText& text, double rest, const std::string& where,
                                Diagnostics& problems);
/// In the given variables; a number is the constant.
std::optional<Expression> expression_of(const FunctionText& text, const std::vector<std::string>& variables,
                                        const std::string& where, Diagnostics& problems);

}  // namespace feder
