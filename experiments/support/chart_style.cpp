#include "experiments/support/chart_style.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace feder::experiments {
namespace {

// Okabe-Ito, with the wine of Tol's muted set for its yellow, which is too faint on white.
constexpr std::array kColours = {"#0072B2", "#D55E00", "#009E73", "#CC79A7",
                                 "#E69F00", "#56B4E9", "#000000", "#882255"};
// gnuplot marker numbers, filled and open: circle, square, triangle, diamond, inverted triangle, pentagon.
constexpr std::array kSolidMarkers = {7, 5, 9, 13, 11, 15};
constexpr std::array kOpenMarkers = {6, 4, 8, 12, 10, 14};
constexpr std::array kDashes = {"solid", "(14,5)", "(4,4)", "(14,4,3,4)", "(9,3,3,3,3,3)"};
constexpr std::array kTheoryDashes = {"(10,4)", "(3,3)", "(10,3,3,3)"};

}  // namespace

std::string SeriesStyle::lines() const {
  return fmt::format("with lines linecolor rgb '{}' linewidth {} dashtype {}", colour, width, dash);
}

std::string SeriesStyle::solid_points() const {
  return fmt::format("with points pointtype {} pointsize {} linecolor rgb '{}'", solid_marker, size, colour);
}

std::string SeriesStyle::blank_points() const {
  return fmt::format("with points pointtype {} pointsize {} linecolor rgb 'white'", solid_marker, size);
}

std::string SeriesStyle::open_points() const {
  return fmt::format("with points pointtype {} pointsize {} linewidth 1.5 linecolor rgb '{}'", open_marker,
                     size, colour);
}

std::string SeriesStyle::failed_points() const {
  return fmt::format("with points pointtype 2 pointsize 0.9 linewidth 2 linecolor rgb '{}'", colour);
}

StyleBook::StyleBook(const Chart& chart) {
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      const auto same = [&](const Series* other) { return other->label == series.label; };
      if (std::none_of(legend_.begin(), legend_.end(), same)) legend_.push_back(&series);
    }
  }
}

SeriesStyle StyleBook::style(const Series& series) const {
  std::size_t measured = 0;
  std::size_t theory = 0;
  for (const Series* entry : legend_) {
    if (entry->label == series.label) break;
    ++(entry->theory ? theory : measured);
  }
  if (series.theory) return {"#555555", 7, 6, kTheoryDashes[theory % kTheoryDashes.size()], 2.5};
  if (series.look) measured = *series.look;
  return {kColours[measured % kColours.size()],
          kSolidMarkers[measured % kSolidMarkers.size()],
          kOpenMarkers[measured % kOpenMarkers.size()],
          kDashes[measured % kDashes.size()],
          2,
          series.marker_size};
}

std::string gnuplot_text(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) {
    const bool control = static_cast<unsigned char>(c) < 0x20 || c == 0x7F;
    if (c == '\'') {
      quoted += "''";
    } else if (c == '&') {
      quoted += "\\046";  // as itself it would enter the SVG file unescaped
    } else if (std::string_view("\\_^{}@~").find(c) != std::string_view::npos) {
      quoted += std::string("\\") + c;
    } else {
      quoted += control ? ' ' : c;
    }
  }
  return quoted + "'";
}

}  // namespace feder::experiments
