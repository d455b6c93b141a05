#pragma once

#include <string>

#include "experiments/support/chart_range.h"
#include "experiments/support/chart_style.h"

namespace feder::experiments {

/// The gnuplot commands that draw the inside of one panel: data blocks, reference lines, labels and `plot`.
/// Limits, margins and axes are set by the caller. `number` makes the names of the data blocks unique.
std::string panel_script(const Panel& panel, const PanelRanges& ranges, const StyleBook& styles,
                         std::size_t number);

}  // namespace feder::experiments
