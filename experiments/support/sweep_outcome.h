#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "experiments/support/sweep_child.h"
#include "experiments/support/sweep_table.h"

namespace feder::experiments {

/// What a case folder says after its child has ended: the manifest that `simulate` wrote, or the reason why
/// there is none. `limit` is the time limit the child had [s].
CaseOutcome judge(const ChildEnd& end, const std::filesystem::path& folder, double limit);

/// False for what deserves another run: interrupted cases, trouble with files, and a time limit below `limit`
/// [s].
bool is_final(const CaseOutcome& outcome, double limit);

/// The outcome a case folder keeps for the next run of the same sweep. write_outcome throws IoError;
/// read_outcome is empty if there is none, or one of another fingerprint().
void write_outcome(const std::filesystem::path& folder, const CaseOutcome& outcome,
                   std::string_view fingerprint);
std::optional<CaseOutcome> read_outcome(const std::filesystem::path& folder, std::string_view fingerprint);

}  // namespace feder::experiments
