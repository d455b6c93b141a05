#include "experiments/support/table.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "engine/check.h"

namespace feder::experiments {
namespace {

TEST(Table, WritesSeventeenDigitsThatReadBackExactly) {
  std::mt19937_64 random(1);
  Table table({"value"});
  std::vector<double> values = {0.1, -0.0, 1e-308, 5e-324, 1.7976931348623157e308, 1.0 / 3};
  for (int i = 0; i < 2000; ++i) {
    const double value = std::bit_cast<double>(random());
    if (std::isfinite(value)) values.push_back(value);
  }
  for (const double value : values) table.add({{"value", value}});
  const Table back = from_csv(to_csv(table), "test");
  ASSERT_EQ(back.rows(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_EQ(back.at(i, "value").number(), values[i]);
}

TEST(Table, QuotesCommasQuotesAndLineBreaks) {
  const std::vector<std::string> words = {"a,b", "say \"no\"", "two\nlines", "carriage\r\nreturn",
                                          "",    " space ",    "\""};
  Table table({"first, column", "second"});
  for (const std::string& word : words) table.add({{"first, column", word}, {"second", 1}});
  const std::string csv = to_csv(table);
  EXPECT_TRUE(csv.starts_with("\"first, column\",second\n\"a,b\",1\n\"say \"\"no\"\"\",1\n")) << csv;
  const Table back = from_csv(csv, "test");
  ASSERT_EQ(back.rows(), words.size());
  for (std::size_t i = 0; i < words.size(); ++i) EXPECT_EQ(back.at(i, "first, column").text(), words[i]);
}

TEST(Table, LeavesMissingCellsEmpty) {
  Table table({"dt", "status", "error"});
  table.add({{"status", "diverged"}, {"dt", 0.5}});
  EXPECT_EQ(to_csv(table), "dt,status,error\n0.5,diverged,\n");
  EXPECT_TRUE(table.at(0, "error").empty());
  EXPECT_TRUE(std::isnan(table.at(0, "error").number()));
}

TEST(Table, KeepsWholeNumbersWhole) {
  Table table({"steps"});
  table.add({{"steps", std::int64_t{9007199254740993}}});  // 2^53 + 1 has no double
  EXPECT_EQ(to_csv(table), "steps\n9007199254740993\n");
}

TEST(Table, RefusesUnknownAndRepeatedColumns) {
  Table table({"dt"});
  EXPECT_THROW(table.add({{"dT", 1.0}}), MisuseError);
  EXPECT_THROW(table.add({{"dt", 1.0}, {"dt", 2.0}}), MisuseError);
  EXPECT_THROW((void)table.at(0, "dt"), MisuseError);
  EXPECT_THROW(Table({"dt", "dt"}), MisuseError);
  EXPECT_EQ(table.rows(), 0u);
}

TEST(Table, RefusesBrokenCsvByRecord) {
  const auto message = [](const std::string& csv) -> std::string {
    try {
      (void)from_csv(csv, "file.csv");
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_NE(message("a,b\n1,2\n3\n").find("file.csv: record 3: 1 fields, expected 2"), std::string::npos);
  EXPECT_NE(message("a,a\n1,2\n").find("record 1: the column 'a' appears twice"), std::string::npos);
  EXPECT_NE(message("a\n\"open\n").find("record 2: a quoted field does not end"), std::string::npos);
  EXPECT_NE(message("a\n\"b\"c\n").find("record 2: text after a closing quote"), std::string::npos);
  EXPECT_NE(message("").find("empty"), std::string::npos);
}

TEST(Table, AlignsColumnsByCharactersNotBytes) {
  Table table({"name", "value"});
  table.add({{"name", "μ"}, {"value", 1.23456789}});
  table.add({{"name", "long\tname"}, {"value", 100}});
  EXPECT_EQ(to_text(table), "name       value\nμ          1.235\nlong name    100\n");
  EXPECT_NE(to_text(table, 1).find("... and 1 more rows"), std::string::npos);
}

TEST(Table, EscapesHtmlAndMarksFailedRuns) {
  Table table({"scene", "status", "dt"});
  table.add({{"scene", "<script>\"&'"}, {"status", "diverged"}, {"dt", 0.123456789}});
  const std::string html = to_html(table);
  EXPECT_EQ(html.find("<script>"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;&quot;&amp;&#39;"), std::string::npos);
  EXPECT_NE(html.find("<tr class=\"failed\">"), std::string::npos);
  EXPECT_NE(html.find(">0.1235</td>"), std::string::npos);
}

Table timed_table(double error, double seconds) {
  Table table({"dt", "error", "seconds", "seconds_solve"});
  table.add({{"dt", 0.1}, {"error", error}, {"seconds", seconds}, {"seconds_solve", seconds / 2}});
  return table;
}

TEST(ResultsHash, IgnoresTimingColumnsOnly) {
  const std::string hash = results_hash(timed_table(1e-3, 1.0));
  EXPECT_EQ(hash.size(), 16u);
  EXPECT_EQ(hash, results_hash(timed_table(1e-3, 2.0)));
  const double next = std::nextafter(1e-3, 1.0);
  EXPECT_NE(hash, results_hash(timed_table(next, 1.0)));
}

TEST(ResultsHash, SurvivesTheCsvFile) {
  const Table table = timed_table(1.0 / 3, 1.0);
  EXPECT_EQ(results_hash(from_csv(to_csv(table), "test")), results_hash(table));
}

TEST(ResultsHash, IsFnv1a) {
  // FNV-1a 64 of "a\n" worked out by hand from the two published constants.
  std::uint64_t expected = 0xcbf29ce484222325ULL;
  for (const unsigned char c : {'a', '\n'}) expected = (expected ^ c) * 0x100000001b3ULL;
  EXPECT_EQ(std::stoull(results_hash(Table({"a"})), nullptr, 16), expected);
}

}  // namespace
}  // namespace feder::experiments
