#include "experiments/support/page.h"

#include <gtest/gtest.h>

#include <cmath>

#include "experiments/support/files.h"
#include "experiments/support/html.h"
#include "experiments/support/progress.h"
#include "experiments/support/table.h"
#include "experiments/support/timing.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

/// Writes one experiment's results and returns the page.
std::string page_with(const std::string& manifest, const std::string& csv, const std::string& svg) {
  const TemporaryFolder folder;
  create_folder(folder.path() / "sample");
  write_file(folder.path() / "sample" / "manifest.json", manifest);
  write_file(folder.path() / "sample" / "sample.csv", csv);
  write_file(folder.path() / "sample" / "picture.svg", svg);
  EXPECT_EQ(write_page(folder.path()), 1);
  return read_file(folder.path() / "index.html");
}

const std::string kManifest = R"({"question": "Is <b> & 'c' safe?", "status": "ok", "table": "sample.csv",
  "does_not_model": "x < y", "charts": [{"name": "picture", "caption": "a > b"}], "notes": ["1 < 2"]})";

TEST(Page, EscapesEveryTextItShows) {
  const std::string html = page_with(kManifest, "a\n<i>\n", "<?xml?><svg id='gpDot'></svg>");
  for (const char* part :
       {"Is &lt;b&gt; &amp; &#39;c&#39; safe?", "x &lt; y", "a &gt; b", "1 &lt; 2", "&lt;i&gt;"}) {
    EXPECT_NE(html.find(part), std::string::npos) << part;
  }
  EXPECT_EQ(html.find("<?xml"), std::string::npos);
  EXPECT_NE(html.find("<svg id='sample-picture-gpDot'>"), std::string::npos);
}

TEST(Page, NeedsNoNetwork) {
  const std::string html = page_with(kManifest, "a\n1\n", "<svg></svg>");
  for (const char* part : {"http://", "https://", "<script", "<link", "@import", "url("}) {
    EXPECT_EQ(html.find(part), std::string::npos) << part;
  }
}

TEST(Page, ShowsUnreadableResultsAsSuch) {
  EXPECT_NE(page_with("{broken", "a\n", "<svg/>").find("cannot be shown"), std::string::npos);
  EXPECT_NE(page_with("[]", "a\n", "<svg/>").find("cannot be shown"), std::string::npos);
  EXPECT_NE(page_with(kManifest, "", "<svg/>").find("cannot be shown"), std::string::npos);
  EXPECT_NE(page_with(kManifest, "a\n", "no picture").find("cannot be shown"), std::string::npos);
  EXPECT_NE(
      page_with(R"({"status": "ok", "table": "../../etc/passwd"})", "a\n", "<svg/>").find("strange file"),
      std::string::npos);
}

TEST(Page, LeavesOutRunsOfSingleScenes) {
  const TemporaryFolder folder;
  create_folder(folder.path() / "rope");
  write_file(folder.path() / "rope" / "manifest.json", R"({"program": "simulate", "status": "ok"})");
  EXPECT_EQ(write_page(folder.path()), 0);
  EXPECT_EQ(read_file(folder.path() / "index.html").find("rope"), std::string::npos);
}

TEST(Page, WarnsWhenTheTableIsNotTheManifestsOwn) {
  const std::string with_hash = R"({"status": "ok", "table": "sample.csv", "results_hash": "%"})";
  const std::string csv = "a,seconds\n1,2\n";
  const auto page = [&](const std::string& hash) {
    return page_with(std::string(with_hash).replace(with_hash.find('%'), 1, hash), csv, "<svg/>");
  };
  EXPECT_EQ(page(results_hash(from_csv(csv, "test"))).find("not the one"), std::string::npos);
  EXPECT_NE(page("0123456789abcdef").find("not the one"), std::string::npos);
}

TEST(Page, NamesARunThatDidNotEndWell) {
  const std::string html = page_with(
      R"({"status": "interrupted", "reason": "by a signal", "table": "sample.csv"})", "a\n1\n", "<svg/>");
  EXPECT_NE(html.find("This run ended as interrupted: by a signal"), std::string::npos);
}

TEST(Page, RefusesAMissingFolder) {
  EXPECT_THROW(write_page("/no/such/folder"), IoError);
}

TEST(Progress, TellsCountRateAndTimeLeft) {
  EXPECT_EQ(Progress::line(5, 20, 10, "chain"), "  5/20  25 %  0.5 /s  30 s left  chain");
  EXPECT_EQ(Progress::line(20, 20, 10, ""), "  20/20  100 %  2 /s");
  EXPECT_EQ(Progress::line(0, 0, 0, ""), "  0  0 /s");
}

TEST(Timing, TakesTheBestAndTheMiddle) {
  int calls = 0;
  EXPECT_EQ(best_of(3, [&] { return 10.0 - ++calls; }), 7);
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(HtmlEscape, CoversElementsAndAttributes) {
  EXPECT_EQ(html_escape("<a b='\"'>&"), "&lt;a b=&#39;&quot;&#39;&gt;&amp;");
}

}  // namespace
}  // namespace feder::experiments
