#include "experiments/support/chart_panel.h"

#include <fmt/format.h>

#include "experiments/support/chart_slope.h"
#include "experiments/support/chart_space.h"

namespace feder::experiments {
namespace {

/// Collects the data blocks, the decoration and the elements of one `plot` command.
class PanelScript {
 public:
  PanelScript(const Panel& panel, const PanelRanges& ranges, const StyleBook& styles, std::size_t number)
      : panel_(panel), ranges_(ranges), styles_(styles), number_(number), space_(panel, ranges) {}

  std::string text() {
    if (panel_.judge_error) add_judge(*panel_.judge_error);
    for (const Slope& slope : panel_.slopes) add_slope(slope);
    for (const Mark& mark : panel_.marks) add_mark(mark);
    for (const Series& series : panel_.series) add_series(series);
    add_failed();
    if (ranges_.empty) add_label("no data", 0.5, 0.5, "center");
    if (elements_.empty()) elements_.push_back("NaN notitle");
    return data_ + decoration_ + fmt::format("plot {}\n", fmt::join(elements_, ", \\\n     "));
  }

 private:
  bool visible(const Series& series, std::size_t i) const { return drawable(panel_, series, i); }

  /// A data block with the points that `keep` accepts, a gap for each other one; "" without any.
  template <typename Keep>
  std::string add_points(const Series& series, Keep&& keep) {
    std::string lines;
    bool any = false;
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      const bool kept = visible(series, i) && keep(i);
      lines += kept ? fmt::format("{:.9g} {:.9g}\n", series.x[i], series.y[i]) : "\n";
      any = any || kept;
    }
    return any ? add_block(lines) : "";
  }

  std::string add_block(const std::string& lines) {
    std::string name = fmt::format("$panel{}_{}", number_, ++blocks_);
    data_ += fmt::format("{} << EOD\n{}EOD\n", name, lines);
    return name;
  }

  void add_element(const std::string& block, const std::string& how) {
    if (!block.empty()) elements_.push_back(fmt::format("{} using 1:2 {} notitle", block, how));
  }

  /// A straight line between two points given as fractions of the axes.
  void add_line(double x0, double y0, double x1, double y1, const std::string& style) {
    decoration_ += fmt::format(
        "set arrow from graph {:.5f}, graph {:.5f} to graph {:.5f}, graph {:.5f} nohead back {}\n", x0, y0,
        x1, y1, style);
  }

  void add_label(const std::string& label, double x, double y, const std::string& how) {
    decoration_ +=
        fmt::format("set label {} at graph {:.5f}, graph {:.5f} {} front textcolor rgb '#444444'\n",
                    gnuplot_text(label), x, y, how);
  }

  /// Puts the label where it disturbs least.
  void place_label(const std::string& label, const std::vector<LabelPlace>& places) {
    if (label.empty()) return;
    const LabelPlace place = space_.choose(label, places);
    add_label(label, place.x, place.y, place.how());
  }

  // The region below the judge's own error is shaded: nothing can be told apart there.
  void add_judge(double error) {
    if (!drawable(panel_.y, error)) return;
    const double height = ranges_.y.fraction(error);
    const std::string label = fmt::format("judge's own error {:.1e}", error);
    if (height < 0 || height > 1) {
      add_label(label + (height < 0 ? " (below)" : " (above)"), 0.02, 0.04, "left");
      return;
    }
    decoration_ += fmt::format(
        "set object rectangle from graph 0, graph 0 to graph 1, graph {:.5f} behind fillcolor rgb '#eeeeee' "
        "fillstyle solid noborder\n",
        height);
    add_line(0, height, 1, height, "linecolor rgb '#777777' linewidth 1.5 dashtype (8,5)");
    const double y = height > 0.08 ? height - 0.035 : height + 0.035;
    place_label(label, {{0.02, y, 1}, {0.98, y, -1}});
  }

  void add_slope(const Slope& slope) {
    if (!panel_.x.log || !panel_.y.log) return;
    const SlopeLine line = place_slope(panel_, ranges_, slope);
    if (!line.found) return;
    add_line(line.x0, line.y0, line.x1, line.y1, "linecolor rgb '#666666' linewidth 1.5 dashtype (2,3)");
    // Below the middle or the right end, or before the left end.
    place_label(slope.label.empty() ? fmt::format("slope {:g}", slope.order) : slope.label,
                {{0.5 * (line.x0 + line.x1) + 0.03, 0.5 * (line.y0 + line.y1) - 0.025, 1},
                 {line.x1 + 0.01, line.y1 - 0.03, 1},
                 {line.x0 - 0.01, line.y0 - 0.01, -1},
                 {line.x0, line.y0 - 0.045, 1}});
  }

  void add_mark(const Mark& mark) {
    if (!drawable(mark.vertical ? panel_.x : panel_.y, mark.at)) return;
    const std::string style = "linecolor rgb '#555555' linewidth 1.5 dashtype (6,3,2,3)";
    const double place = (mark.vertical ? ranges_.x : ranges_.y).fraction(mark.at);
    if (place < 0 || place > 1) return;
    if (mark.vertical) {
      const double top = ranges_.failed_from - 0.02;
      const double left = place - 0.02;
      const double right = place + 0.025;
      add_line(place, 0, place, 1, style);
      place_label(
          mark.label,
          {{left, top, -1, true}, {left, 0.02, 1, true}, {right, top, -1, true}, {right, 0.02, 1, true}});
    } else {
      const double y = place < 0.9 ? place + 0.035 : place - 0.035;
      add_line(0, place, 1, place, style);
      place_label(mark.label, {{0.98, y, -1}, {0.02, y, 1}});
    }
  }

  void add_series(const Series& series) {
    const SeriesStyle style = styles_.style(series);
    if (series.line || series.theory)
      add_element(add_points(series, [](std::size_t) { return true; }), style.lines());
    if (!series.markers || series.theory) return;
    add_element(add_points(series, [&](std::size_t i) { return trusted(series, i); }), style.solid_points());
    const std::string untrusted = add_points(series, [&](std::size_t i) { return !trusted(series, i); });
    add_element(untrusted, style.blank_points());
    add_element(untrusted, style.open_points());
  }

  // Crosses along the top edge, one row per series so that none hides another.
  void add_failed() {
    std::vector<const Series*> failing;
    for (const Series& series : panel_.series) {
      if (has_failures(panel_, series)) failing.push_back(&series);
    }
    for (std::size_t row = 0; row < failing.size(); ++row) {
      const double part = (0.5 + static_cast<double>(row)) / static_cast<double>(failing.size());
      const double y = ranges_.y.at(1 - part * (1 - ranges_.failed_from));
      std::string lines;
      for (const double x : failing[row]->failed_x) {
        if (drawable(panel_.x, x)) lines += fmt::format("{:.9g} {:.9g}\n", x, y);
      }
      add_element(add_block(lines), styles_.style(*failing[row]).failed_points());
    }
    if (!failing.empty()) {
      add_line(0, ranges_.failed_from, 1, ranges_.failed_from, "linecolor rgb '#bbbbbb' linewidth 1");
    }
  }

  const Panel& panel_;
  const PanelRanges& ranges_;
  const StyleBook& styles_;
  std::size_t number_;
  FreeSpace space_;
  int blocks_ = 0;
  std::string data_;
  std::string decoration_;
  std::vector<std::string> elements_;
};

}  // namespace

std::string panel_script(const Panel& panel, const PanelRanges& ranges, const StyleBook& styles,
                         std::size_t number) {
  return PanelScript(panel, ranges, styles, number).text();
}

}  // namespace feder::experiments
