#include "experiments/support/chart.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <regex>
#include <set>
#include <sstream>

#include "engine/check.h"
#include "experiments/support/chart_range.h"
#include "experiments/support/files.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Chart chart_with(std::vector<Series> series, bool log = true) {
  const Panel panel{.title = "panel", .x = {"x [s]", log}, .y = {"y [m]", log}, .series = std::move(series)};
  return {.name = "chart", .title = "title", .caption = "caption", .panels = {panel}};
}

/// Draws and returns the picture; gnuplot complains by an exception.
std::string drawn(const Chart& chart) {
  const TemporaryFolder folder;
  draw(chart, folder.path());
  std::string svg = read_file(folder.path() / (chart.name + ".svg"));
  EXPECT_FALSE(std::regex_search(svg, std::regex("&(?!lt;|gt;|amp;|quot;)"))) << "not well-formed XML";
  return svg;
}

/// All numbers of the data blocks.
std::vector<std::string> data_words(const std::string& script) {
  std::vector<std::string> words;
  const std::regex block("<< EOD\n([^E]*)EOD");
  for (auto i = std::sregex_iterator(script.begin(), script.end(), block); i != std::sregex_iterator(); ++i) {
    std::istringstream lines((*i)[1].str());
    for (std::string word; lines >> word;) words.push_back(word);
  }
  return words;
}

TEST(Chart, ScriptAloneDrawsTheSamePicture) {
  const TemporaryFolder folder;
  const Chart chart = chart_with({{.label = "implicit_euler", .x = {0.1, 0.01}, .y = {1, 0.1}}});
  draw(chart, folder.path());
  const std::string before = read_file(folder.path() / "chart.svg");
  std::filesystem::remove(folder.path() / "chart.svg");
  ASSERT_EQ(std::system(("cd '" + folder.path().string() + "' && gnuplot chart.gp").c_str()), 0);
  EXPECT_EQ(read_file(folder.path() / "chart.svg"), before);
  EXPECT_NE(before.find("implicit_euler"), std::string::npos);
}

TEST(Chart, LetsNoValueThroughThatGnuplotCannotPlace) {
  const std::vector<double> bad = {kNan, kInfinity, -kInfinity, 0, -1, 1e305, 1e-305, 5e-324};
  Series series{.label = "bad", .x = {1, 10}, .y = {1, 10}, .failed_x = bad};
  for (const double value : bad) {
    series.add(2, value);
    series.add(value, 2);
  }
  const std::string script = gnuplot_script(chart_with({series}));
  ASSERT_FALSE(data_words(script).empty());
  for (const std::string& word : data_words(script)) {
    const double value = std::stod(word);
    EXPECT_TRUE(std::isfinite(value) && value > 0 && value < 1e300) << word;
  }
  EXPECT_NE(script.find("24 points are not drawn"), std::string::npos);
  EXPECT_NO_THROW(drawn(chart_with({series})));
}

TEST(Chart, DrawsWithoutAnyData) {
  EXPECT_NE(drawn(chart_with({})).find("no data"), std::string::npos);
  EXPECT_NE(drawn(chart_with({{.label = "empty"}})).find("no data"), std::string::npos);
  EXPECT_NE(drawn(chart_with({{.label = "nan", .x = {kNan}, .y = {kNan}}})).find("no data"),
            std::string::npos);
  EXPECT_NO_THROW(drawn({.name = "no_panels"}));
}

TEST(Chart, DrawsASinglePointAndAConstant) {
  EXPECT_NO_THROW(drawn(chart_with({{.label = "one", .x = {1e-20}, .y = {1e200}}})));
  EXPECT_NO_THROW(drawn(chart_with({{.label = "flat", .x = {1, 2}, .y = {0, 0}}}, false)));
  EXPECT_NO_THROW(drawn(chart_with({{.label = "huge", .x = {-1e299, 1e299}, .y = {-1e299, 1e299}}}, false)));
  EXPECT_NO_THROW(drawn(chart_with({{.label = "failed", .failed_x = {0.1}}})));
}

TEST(Chart, ShowsTextAsItIs) {
  const std::string text = "a_b^c {x} \\n 'q' <&amp;> @~ `ls` μ";
  Chart chart = chart_with({{.label = text, .x = {1, 2}, .y = {1, 2}}});
  Panel& panel = chart.panels[0];
  chart.title = panel.title = panel.x.label = panel.y.label = text;
  panel.marks = {{1.5, text}};
  panel.slopes = {{1, text}};
  const std::string svg = drawn(chart);
  const std::string shown = "a_b^c {x} \\n 'q' &lt;&amp;amp;> @~ `ls` μ";
  std::size_t count = 0;
  for (std::size_t at = svg.find(shown); at != std::string::npos; at = svg.find(shown, at + 1)) ++count;
  EXPECT_EQ(count, 7u) << "chart, panel, two axes, legend, mark, slope";
}

TEST(Chart, DrawsPointsBelowTheJudgesErrorHollow) {
  Series series{.label = "rk4", .x = {1, 2, 3}, .y = {1e-3, 1e-9, 1e-2}, .floor = {1e-6, 1e-6, 1e-6}};
  const std::string script = gnuplot_script(chart_with({series}));
  EXPECT_NE(script.find("below the judge"), std::string::npos);
  series.floor = {1e-12, 1e-12, 1e-12};
  EXPECT_EQ(gnuplot_script(chart_with({series})).find("below the judge"), std::string::npos);
}

TEST(Chart, GivesEverySeriesItsOwnColourMarkerAndDash) {
  std::vector<Series> all;
  for (int i = 0; i < 12; ++i)
    all.push_back({.label = "method_" + std::to_string(i), .x = {1, 2}, .y = {1, 2}});
  const std::string script = gnuplot_script(chart_with(all));
  const std::regex entry("keyentry with linespoints ([^\n]*) title");
  std::set<std::string> looks;
  for (auto i = std::sregex_iterator(script.begin(), script.end(), entry); i != std::sregex_iterator(); ++i) {
    looks.insert((*i)[1].str());
  }
  EXPECT_EQ(looks.size(), all.size());
}

// Limits of an axis as the script sets them.
double axis_length(const std::string& script, char axis) {
  std::smatch found;
  const std::regex range(std::string("set ") + axis + "range \\[([^:]*):([^\\]]*)\\]");
  EXPECT_TRUE(std::regex_search(script, found, range));
  return std::stod(found[2]) - std::stod(found[1]);
}

TEST(Chart, DrawsACircleAsACircleIfAxesAreEqual) {
  Chart chart = chart_with({{.label = "circle", .x = {-1, 0, 1, 0}, .y = {0, 1, 0, -1}}}, false);
  const auto ratio = [&] {
    const std::string script = gnuplot_script(chart);
    return axis_length(script, 'x') / axis_length(script, 'y');
  };
  EXPECT_NEAR(ratio(), 1.0, 0.1);  // of a plot that is wider than high
  chart.panels[0].equal = true;
  EXPECT_NEAR(ratio(), (720.0 - 120.0) / (520.0 - 114.0), 1e-6);
  chart.panels[0].x.min = -1.5;
  EXPECT_NE(gnuplot_script(chart).find("set xrange [-1.5:"), std::string::npos);
  EXPECT_NEAR(ratio(), (720.0 - 120.0) / (520.0 - 114.0), 1e-6);
  chart.panels[0].x.min = {};
  chart.panels[0].series[0].x = {-100, 0, 100, 0};
  EXPECT_NEAR(ratio(), (720.0 - 120.0) / (520.0 - 114.0), 1e-6);
}

TEST(Chart, DrawsCloudsOfSmallMarkersWithAFullOneInTheLegend) {
  const Series cloud{.label = "cloud", .x = {1, 2}, .y = {1, 2}, .line = false, .marker_size = 0.3};
  const std::string script = gnuplot_script(chart_with({cloud}));
  EXPECT_NE(script.find("pointsize 0.3 linecolor"), std::string::npos);
  EXPECT_NE(script.find("keyentry with points pointtype 7 pointsize 0.9"), std::string::npos) << script;
}

TEST(Chart, KeepsTextAtTenPointsOrMore) {
  const std::string svg = drawn(chart_with({{.label = "a", .x = {1, 100}, .y = {1, 100}}}));
  const std::regex size("font-size=\"([0-9.]+)\"");
  double smallest = 1e9;
  for (auto i = std::sregex_iterator(svg.begin(), svg.end(), size); i != std::sregex_iterator(); ++i) {
    // Exponents are set smaller, as in print.
    smallest = std::min(smallest, std::stod((*i)[1].str()));
  }
  EXPECT_GE(smallest, 0.79 * 14);  // 11.2 px exponents of 14 px (10.5 pt) text
}

TEST(Chart, RefusesWhatItsCallerGotWrong) {
  EXPECT_THROW((void)gnuplot_script(chart_with({{.label = "a", .x = {1, 2}, .y = {1}}})), MisuseError);
  EXPECT_THROW((void)gnuplot_script(chart_with({{.label = "a", .x = {1}, .y = {1}, .floor = {1, 2}}})),
               MisuseError);
  EXPECT_THROW((void)gnuplot_script({.name = "../escape"}), MisuseError);
  EXPECT_THROW((void)gnuplot_script({.name = ""}), MisuseError);
}

TEST(Chart, LeavesNothingBehindWhenTheFolderIsMissing) {
  EXPECT_THROW(draw(chart_with({}), "/no/such/folder"), IoError);
}

TEST(Ranges, HoldTheDataAndLeaveRoomForFailedRuns) {
  Chart chart = chart_with({{.label = "a", .x = {1, 100}, .y = {1e-3, 1}, .failed_x = {1000}}});
  const PanelRanges ranges = ranges_of(chart.panels[0]);
  EXPECT_LT(ranges.x.lo, 1);
  EXPECT_GT(ranges.x.hi, 1000);
  EXPECT_GT(ranges.y.at(ranges.failed_from), 1);
  EXPECT_GT(ranges.y.hi, ranges.y.at(ranges.failed_from));
}

TEST(SeriesBy, SplitsByGroupAndKeepsFailedRuns) {
  Table table({"integrator", "dt", "status", "error", "reference_error"});
  table.add(
      {{"integrator", "rk4"}, {"dt", 0.1}, {"status", "ok"}, {"error", 1e-4}, {"reference_error", 1e-9}});
  table.add({{"integrator", "rk4"}, {"dt", 0.5}, {"status", "diverged"}});
  table.add(
      {{"integrator", "bdf2"}, {"dt", 0.1}, {"status", "ok"}, {"error", 1e-3}, {"reference_error", 1e-9}});
  const std::vector<Series> series = series_by(table, "integrator", "dt", "error");
  ASSERT_EQ(series.size(), 2u);
  EXPECT_EQ(series[0].label, "rk4");
  EXPECT_EQ(series[0].y, std::vector<double>{1e-4});
  EXPECT_EQ(series[0].floor, std::vector<double>{1e-9});
  EXPECT_EQ(series[0].failed_x, std::vector<double>{0.5});
  const auto only_bdf2 = [&](std::size_t row) { return table.at(row, "integrator").text() == "bdf2"; };
  EXPECT_EQ(series_by(table, "integrator", "dt", "error", only_bdf2).size(), 1u);
}

}  // namespace
}  // namespace feder::experiments
