#pragma once

#include <string>
#include <string_view>

namespace feder::experiments {

/// Text made safe inside HTML elements and quoted attributes: & < > " '.
std::string html_escape(std::string_view text);

}  // namespace feder::experiments
