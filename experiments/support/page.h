#pragma once

#include <filesystem>

namespace feder::experiments {

/// Writes <folder>/index.html from every <folder>/*/manifest.json: one page that needs no network and no
/// other file. An experiment whose files cannot be read gets a section that says so. Returns the number of
/// experiments shown. Throws IoError.
int write_page(const std::filesystem::path& folder);

}  // namespace feder::experiments
