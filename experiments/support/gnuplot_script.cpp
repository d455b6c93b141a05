#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/check.h"
#include "experiments/support/chart_panel.h"

namespace feder::experiments {
namespace {

// Pixels. 14 px text is 10.5 pt.
constexpr int kLeft = 100, kRight = 20, kTop = 46, kBottom = 68, kTitle = 34, kNote = 26, kLegendLine = 23;

/// Places of the panels and the legend, in pixels from the upper left corner.
struct Layout {
  int columns, rows, cell_width, cell_height, top, legend_width, width, height;
};

std::size_t longest_label(const StyleBook& styles) {
  std::size_t longest = 24;  // the fixed entries
  for (const Series* series : styles.legend()) longest = std::max(longest, series->label.size());
  return longest;
}

Layout layout_of(const Chart& chart, const StyleBook& styles) {
  Layout layout{};
  const int panels = std::max(1, static_cast<int>(chart.panels.size()));
  layout.columns = std::clamp(chart.grid_columns, 1, panels);
  layout.rows = (panels + layout.columns - 1) / layout.columns;
  layout.cell_width = panels == 1 ? 720 : 540;
  layout.cell_height = panels == 1 ? 520 : 410;
  layout.top = chart.title.empty() ? 0 : kTitle;
  layout.legend_width = 70 + 8 * static_cast<int>(longest_label(styles));
  layout.width = layout.columns * layout.cell_width + layout.legend_width;
  const int legend_height = kTop + kLegendLine * (static_cast<int>(styles.legend().size()) + 3);
  layout.height = layout.top + std::max(layout.rows * layout.cell_height, legend_height) + kNote;
  return layout;
}

std::string margins(const Layout& layout, int left, int right, int top, int bottom) {
  const double w = layout.width;
  const double h = layout.height;
  return fmt::format(
      "set lmargin at screen {:.5f}\nset rmargin at screen {:.5f}\nset tmargin at screen {:.5f}\n"
      "set bmargin at screen {:.5f}\n",
      left / w, right / w, 1 - top / h, 1 - bottom / h);
}

/// Places for labels on a log axis too short for powers of ten: 1 2 5 if that is enough, else round steps.
std::vector<double> short_log_places(const Range& range) {
  std::vector<double> places;
  const auto add = [&](double place) {
    if (place >= range.lo && place <= range.hi) places.push_back(place);
  };
  const int first = static_cast<int>(std::floor(std::log10(range.lo)));
  for (int decade = first; decade <= first + 3; ++decade) {
    for (const double digit : {1.0, 2.0, 5.0}) add(digit * std::pow(10, decade));
  }
  if (places.size() >= 3) return places;
  const double magnitude = std::pow(10, std::floor(std::log10((range.hi - range.lo) / 3)));
  const double digit = (range.hi - range.lo) / (3 * magnitude);
  const double step = magnitude * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
  places.clear();
  for (double i = std::ceil(range.lo / step); i * step <= range.hi && places.size() < 20; ++i) add(i * step);
  return places;
}

std::string log_tics(char letter, const Range& range) {
  if (range.hi / range.lo > 30) {
    return fmt::format("set format {0} '10^{{%T}}'\nset {0}tics auto\nset m{0}tics 10\n", letter);
  }
  return fmt::format("set format {0} '%g'\nset {0}tics ({1:.9g})\nunset m{0}tics\n", letter,
                     fmt::join(short_log_places(range), ", "));
}

std::string axis_script(char letter, const Axis& axis, const Range& range) {
  std::string text = fmt::format("set {0}label {1}\n", letter, gnuplot_text(axis.label));
  text += axis.log
              ? fmt::format("set logscale {0} 10\n{1}", letter, log_tics(letter, range))
              : fmt::format("unset logscale {0}\nset format {0} '%g'\nset {0}tics auto\nunset m{0}tics\n",
                            letter);
  return text + fmt::format("set {}range [{:.9g}:{:.9g}]\n", letter, range.lo, range.hi);
}

/// Widens the shorter axis until a unit is as long on both; a lower limit that was given stays.
void make_equal(const Panel& panel, const Layout& layout, PanelRanges& ranges) {
  const double width = layout.cell_width - kLeft - kRight, height = layout.cell_height - kTop - kBottom;
  const auto widen = [](const Axis& axis, Range& range, double length) {
    const double more = std::max(0.0, length - (range.hi - range.lo)), below = axis.min ? 0.0 : 0.5 * more;
    range.lo -= below, range.hi += more - below;
  };
  const double unit = std::max((ranges.x.hi - ranges.x.lo) / width, (ranges.y.hi - ranges.y.lo) / height);
  widen(panel.x, ranges.x, unit * width);
  widen(panel.y, ranges.y, unit * height);
}

std::string panel_block(const Panel& panel, const Layout& layout, const StyleBook& styles,
                        std::size_t number) {
  const int column = static_cast<int>(number) % layout.columns;
  const int row = static_cast<int>(number) / layout.columns;
  const int left = column * layout.cell_width;
  const int top = layout.top + row * layout.cell_height;
  PanelRanges ranges = ranges_of(panel);
  if (panel.equal && !panel.x.log && !panel.y.log) make_equal(panel, layout, ranges);
  return fmt::format("\n# Panel {}\nunset arrow\nunset label\nunset object\n", number + 1) +
         margins(layout, left + kLeft, left + layout.cell_width - kRight, top + kTop,
                 top + layout.cell_height - kBottom) +
         fmt::format("set title {}\n", gnuplot_text(panel.title)) + axis_script('x', panel.x, ranges.x) +
         axis_script('y', panel.y, ranges.y) + panel_script(panel, ranges, styles, number + 1);
}

bool has_untrusted(const Panel& panel) {
  for (const Series& series : panel.series) {
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (drawable(panel, series, i) && !trusted(series, i)) return true;
    }
  }
  return false;
}

bool has_failed(const Panel& panel) {
  return std::any_of(panel.series.begin(), panel.series.end(),
                     [&](const Series& s) { return has_failures(panel, s); });
}

/// The part of a series that its legend entry shows.
std::string legend_sample(const Series& series, const SeriesStyle& style) {
  if (series.theory || !series.markers) return style.lines();
  if (!series.line) {
    SeriesStyle full = style;
    full.size = SeriesStyle{}.size;
    return full.solid_points();
  }
  return fmt::format(
      "with linespoints linecolor rgb '{}' linewidth {} dashtype {} pointtype {} pointsize 0.9", style.colour,
      style.width, style.dash, style.solid_marker);
}

std::string legend_entries(const Chart& chart, const StyleBook& styles) {
  std::string entries;
  const auto add = [&](const std::string& how, const std::string& label) {
    entries += fmt::format(", \\\n     keyentry {} title {}", how, gnuplot_text(label));
  };
  for (const Series* series : styles.legend())
    add(legend_sample(*series, styles.style(*series)), series->label);
  const SeriesStyle grey{"#555555", 7, 6, "solid", 2};
  const std::vector<Panel>& panels = chart.panels;
  if (std::any_of(panels.begin(), panels.end(), has_untrusted))
    add(grey.open_points(), "below the judge's error");
  if (std::any_of(panels.begin(), panels.end(), has_failed)) add(grey.failed_points(), "failed run");
  return entries;
}

/// Title, legend and the note on points left out: a plot of its own without axes, so it can never cover data.
std::string frame_block(const Chart& chart, const Layout& layout, const StyleBook& styles) {
  long hidden = 0;
  for (const Panel& panel : chart.panels) hidden += undrawable_points(panel);
  std::string text =
      "\n# Title and legend\nunset arrow\nunset label\nunset object\nunset logscale\nunset border\nunset "
      "tics\n"
      "unset grid\nunset title\nunset xlabel\nunset ylabel\n";
  if (!chart.title.empty()) {
    text += fmt::format("set label {} at screen {:.5f}, screen {:.5f} center font ',17'\n",
                        gnuplot_text(chart.title), 0.5 * layout.columns * layout.cell_width / layout.width,
                        1 - 22.0 / layout.height);
  }
  if (hidden > 0) {
    text += fmt::format(
        "set label '{} not drawn: no finite place on these axes' at screen {:.5f}, screen {:.5f} left\n",
        hidden == 1 ? "1 point is" : fmt::format("{} points are", hidden),
        static_cast<double>(kLeft) / layout.width, 12.0 / layout.height);
  }
  const int left = layout.columns * layout.cell_width;
  return text + margins(layout, left, layout.width - 1, layout.top + kTop, layout.height - kNote) +
         fmt::format(
             "set key at screen {:.5f}, screen {:.5f} left top Left reverse samplen 3.2 spacing 1.35\n",
             (left + 4.0) / layout.width, 1 - static_cast<double>(layout.top + kTop) / layout.height) +
         "set xrange [0:1]\nset yrange [0:1]\nplot NaN notitle" + legend_entries(chart, styles) + "\n";
}

void require_sound(const Chart& chart) {
  const std::string letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  FEDER_CHECK(!chart.name.empty() && chart.name.find_first_not_of(letters) == std::string::npos,
              "a chart's name becomes a file name: letters, digits, '_' and '-' only");
  for (const Panel& panel : chart.panels) {
    for (const Series& series : panel.series) {
      FEDER_CHECK(series.x.size() == series.y.size(), "a series needs as many x as y");
      FEDER_CHECK(series.floor.empty() || series.floor.size() == series.y.size(),
                  "a series needs as many floors as y");
    }
    for (const Axis& axis : {panel.x, panel.y}) {
      FEDER_CHECK(!axis.min || drawable(axis, *axis.min), "an axis limit cannot be drawn");
      FEDER_CHECK(!axis.max || drawable(axis, *axis.max), "an axis limit cannot be drawn");
    }
  }
}

}  // namespace

std::string gnuplot_script(const Chart& chart) {
  require_sound(chart);
  const StyleBook styles(chart);
  const Layout layout = layout_of(chart, styles);
  std::string text = fmt::format(
      "# Run \"gnuplot {0}.gp\" in this folder to draw {0}.svg again.\n"
      "if (!exists('output_file')) output_file = '{0}.svg'\n"
      "set encoding utf8\n"
      "set terminal svg size {1},{2} fixed enhanced font 'sans-serif,14' background 'white' name '{0}'\n"
      "set output output_file\n"
      "set border linecolor rgb '#444444'\nset grid xtics ytics linecolor rgb '#dddddd' linewidth 1 dashtype "
      "solid\n"
      "set key off\nset title offset 0, -0.3\n",
      chart.name, layout.width, layout.height);
  text += "set multiplot\n";
  for (std::size_t i = 0; i < chart.panels.size(); ++i)
    text += panel_block(chart.panels[i], layout, styles, i);
  text += frame_block(chart, layout, styles);
  return text + "unset multiplot\nset output\n";
}

}  // namespace feder::experiments
