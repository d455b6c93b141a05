#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "engine/check.h"
#include "experiments/support/files.h"
#include "experiments/support/sweep_merge.h"
#include "experiments/support/sweep_outcome.h"
#include "experiments/support/sweep_plan.h"
#include "tests/experiments/temporary_folder.h"

namespace feder::experiments {
namespace {

using Texts = std::vector<std::string>;

SweepPlan grid(const Texts& axes) {
  SweepPlan plan{.scene = "rope.toml", .scene_hash = "1234"};
  std::vector<SweepAxis> parsed;
  for (const std::string& axis : axes) parsed.push_back(parse_axis(axis));
  set_grid(plan, parsed);
  return plan;
}

SweepPlan list(const std::string& csv) {
  SweepPlan plan{.scene = "rope.toml", .scene_hash = "1234"};
  set_list(plan, csv, "cases.csv");
  return plan;
}

template <typename Action>
std::string message(Action&& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SweepAxis, KeepsTheTextOfItsWords) {
  EXPECT_EQ(parse_axis("method.dt=1e-3,0.0010,x y").values, (Texts{"1e-3", "0.0010", "x y"}));
}

TEST(SweepAxis, DoesNotSplitInsideBrackets) {
  EXPECT_EQ(parse_axis("gravity=[0,0,-9.81],[0,0,-1.62]").values, (Texts{"[0,0,-9.81]", "[0,0,-1.62]"}));
}

TEST(SweepAxis, MixesLogarithmicAndLinearGridsWithWords) {
  EXPECT_EQ(parse_axis("k=1:100:3,rigid,0:1:3:lin").values,
            (Texts{"1", "10", "100", "rigid", "0", "0.5", "1"}));
}

TEST(SweepAxis, TakesAColonAfterAWordAsText) {
  EXPECT_EQ(parse_axis("material=steel:hard").values, (Texts{"steel:hard"}));
}

TEST(SweepAxis, KeepsEverythingAfterTheFirstEqualsSign) {
  EXPECT_EQ(parse_axis("law=a=b").values, (Texts{"a=b"}));
}

TEST(SweepAxis, RefusesWhatIsNotAnAxis) {
  for (const char* text : {"", "k", "k=", "=1", "k=a,,b", "k=1:2", "k=1:2:1", "k=0:1:3", "k=1:2:3:log",
                           "-k=1", "a b=1", "k=a\nb", "k=a\x7f", "k=1:2:0:lin"})
    EXPECT_NE(message([&] { (void)parse_axis(text); }), "accepted") << text;
}

TEST(SweepPlan, IsTheProductWithTheLastKeyFastest) {
  const SweepPlan plan = grid({"a=1,2", "b=x,y,z"});
  ASSERT_EQ(plan.cases.size(), 6u);
  EXPECT_EQ(plan.cases[1].values, (Texts{"1", "y"}));
  EXPECT_EQ(plan.cases[5].values, (Texts{"2", "z"}));
}

TEST(SweepPlan, RefusesRepeatedKeysAndCases) {
  EXPECT_NE(message([] { grid({"a=1", "a=2"}); }).find("'a' is swept twice"), std::string::npos);
  EXPECT_NE(message([] { grid({"a=1,2,1"}); }).find("a=1 appears twice"), std::string::npos);
  EXPECT_NE(message([] { grid({"error=1,2"}); }).find("result column"), std::string::npos);
}

TEST(SweepPlan, RefusesAMillionCasesBeforeItMakesThem) {
  EXPECT_EQ(message([] { grid({"a=1:2:1001", "b=1:2:1000"}); }), "--grid: more than 1000000 cases");
  EXPECT_NE(message([] {
              grid({"a=1:2:100000", "b=1:2:100000", "c=1:2:100000", "d=1:2:100000"});
            }),
            "accepted");
}

TEST(SweepPlan, ReadsOneCasePerLine) {
  const SweepPlan plan = list("method.integrator,method.rho\nbdf2,\nalpha,0.8\n\"a,\"\"b\",1e-3\n");
  EXPECT_EQ(plan.keys, (Texts{"method.integrator", "method.rho"}));
  ASSERT_EQ(plan.cases.size(), 3u);
  EXPECT_EQ(plan.cases[0].values, (Texts{"bdf2", ""}));
  EXPECT_EQ(plan.cases[2].values, (Texts{"a,\"b", "1e-3"}));
}

TEST(SweepPlan, RefusesBadLists) {
  for (const char* csv :
       {"", "a,b\n", "a,a\n1,2\n", "a,b\n1\n", "a,b\n,\n", "a\n1\n1\n", "a b\n1\n", "a\n\"x\ny\"\n"})
    EXPECT_NE(message([&] { list(csv); }), "accepted") << csv;
}

TEST(SweepPlan, LeavesAnEmptyFieldToTheScene) {
  const SweepPlan plan = list("a,b\n1,\n");
  const Texts command = command_of(plan, plan.cases[0], "simulate", "out");
  EXPECT_EQ(std::count(command.begin(), command.end(), "--set"), 1);
  EXPECT_EQ(std::count(command.begin(), command.end(), "a=1"), 1);
}

TEST(CaseId, IsTheSameOnEveryMachine) {
  // FNV-1a of "17:9:method.dt4:1e-3", computed by another program
  EXPECT_EQ(grid({"method.dt=1e-3"}).cases[0].id, "93393563ca8f6c4f");
}

TEST(CaseId, DoesNotDependOnTheOrderOfTheKeys) {
  EXPECT_EQ(grid({"a=1", "b=2"}).cases[0].id, grid({"b=2", "a=1"}).cases[0].id);
  EXPECT_NE(grid({"a=1", "b=2"}).cases[0].id, grid({"a=2", "b=1"}).cases[0].id);
}

TEST(CaseId, IsAHarmlessFileNameWhateverTheValue) {
  for (const char* axis : {"a=../../etc/passwd", "a=/", "a=..", "a=$(reboot)", "a=\xc3\xa9", "a=a b;c"}) {
    const std::string id = grid({axis}).cases[0].id;
    EXPECT_EQ(id.size(), 16u);
    EXPECT_EQ(id.find_first_not_of("0123456789abcdef"), std::string::npos) << id;
  }
}

TEST(CaseId, TellsTenThousandCasesApart) {
  const SweepPlan plan = grid({"a=1:2:100", "b=1:2:100"});
  std::set<std::string> ids;
  for (const SweepCase& one : plan.cases) ids.insert(one.id);
  EXPECT_EQ(ids.size(), 10000u);
}

TEST(Fingerprint, ChangesWithEverythingThatDecidesAResult) {
  const SweepPlan plan = grid({"a=1,2"});
  std::set<std::string> prints = {fingerprint(plan, plan.cases[0]), fingerprint(plan, plan.cases[1])};
  const auto add = [&](auto&& change) {
    SweepPlan other = plan;
    change(other);
    prints.insert(fingerprint(other, other.cases[0]));
  };
  add([](SweepPlan& p) { p.scene_hash = "1235"; });
  add([](SweepPlan& p) { p.preset = "quick"; });
  add([](SweepPlan& p) { p.threads = 2; });
  add([](SweepPlan& p) { p.reference = true; });
  add([](SweepPlan& p) { p.fixed = {{"b", "1"}}; });
  add([](SweepPlan& p) { p.fixed = {{"b", "2"}}; });
  EXPECT_EQ(prints.size(), 8u);
}

TEST(Fingerprint, DoesNotChangeWithShardAndOrder) {
  SweepPlan plan = grid({"a=1", "c=3"}), other = grid({"c=3", "a=1"});
  plan.fixed = {{"x", "1"}, {"y", "2"}};
  other.fixed = {{"y", "2"}, {"x", "1"}};
  other.shard = {2, 3};
  EXPECT_EQ(fingerprint(plan, plan.cases[0]), fingerprint(other, other.cases[0]));
}

TEST(Shard, CoversEachCaseExactlyOnce) {
  SweepPlan plan = grid({"a=1:2:13"});
  for (int count = 1; count <= 8; ++count) {
    std::vector<int> owners(plan.cases.size(), 0);
    for (int index = 1; index <= count; ++index) {
      plan.shard = {index, count};
      std::size_t size = 0;
      for (std::size_t i = 0; i < owners.size(); ++i)
        owners[i] += plan.shard.owns(i), size += plan.shard.owns(i);
      EXPECT_EQ(size, shard_size(plan)) << index << "/" << count;
    }
    EXPECT_EQ(owners, std::vector<int>(owners.size(), 1)) << count;
  }
}

TEST(Shard, MayBeEmpty) {
  SweepPlan plan = grid({"a=1,2"});
  plan.shard = {3, 8};
  EXPECT_EQ(shard_size(plan), 0u);
}

TEST(Shard, RefusesWhatIsNotAPart) {
  EXPECT_EQ(parse_shard("3/8"), (Shard{3, 8}));
  for (const char* text :
       {"", "1", "0/3", "4/3", "1/0", "-1/3", "1/3/5", "a/3", "1/", "/3", "1/99999999999", "1.0/3"})
    EXPECT_NE(message([&] { (void)parse_shard(text); }), "accepted") << text;
}

TEST(PlanFile, ReadsBackWhatWasWritten) {
  SweepPlan plan = grid({"a=\"x\",[1,2]", "b=\xc3\xa9,2"});
  plan.fixed = {{"c", "x=\\y"}};
  plan.shard = {2, 3};
  plan.reference = true;
  plan.arguments = {"rope.toml", "--grid", "a=1"};
  const SweepPlan back = parse_plan(plan_json(plan), "plan.json");
  EXPECT_EQ(plan_json(back), plan_json(plan));
  EXPECT_EQ(difference(plan, back), "");
  EXPECT_EQ(back.shard, plan.shard);
}

TEST(PlanFile, RefusesWhatIsNotOne) {
  for (const char* text : {"", "{", "{}", "[]", "null", "{\"scene\": 1}"})
    EXPECT_NE(message([&] { (void)parse_plan(text, "plan.json"); }).find("plan.json: not the plan"),
              std::string::npos)
        << text;
  SweepPlan plan = grid({"a=1"});
  plan.cases[0].values.push_back("2");
  EXPECT_NE(message([&] { (void)parse_plan(plan_json(plan), "plan.json"); }), "accepted");
}

TEST(PlanFile, RefusesTextThatIsNotUtf8) {
  EXPECT_EQ(message([] { (void)plan_json(grid({"a=\xff"})); }), "the plan holds text that is not UTF-8");
}

TEST(Outcome, IsReadBackToTheSameRow) {
  const TemporaryFolder folder;
  const SweepPlan plan = grid({"a=1"});
  const CaseOutcome outcome{
      "diverged",
      "at \"t\" = 0.1 s, no,",
      1.5,
      0,
      {{"error", 0.1}, {"steps", 1234567}, {"dt", -0.0}, {"scene", "rope"}, {"route", {}}}};
  write_outcome(folder.path(), outcome, "print");
  const std::optional<CaseOutcome> back = read_outcome(folder.path(), "print");
  ASSERT_TRUE(back);
  Table before = sweep_table(plan), after = sweep_table(plan);
  add_row(before, plan, plan.cases[0], outcome);
  add_row(after, plan, plan.cases[0], *back);
  EXPECT_EQ(to_csv(before), to_csv(after));
  EXPECT_NE(to_csv(before).find(",-0,"), std::string::npos);
}

TEST(Outcome, OfAnotherPlanIsNone) {
  const TemporaryFolder folder;
  write_outcome(folder.path(), {"ok", ""}, "print");
  EXPECT_TRUE(read_outcome(folder.path(), "print"));
  EXPECT_FALSE(read_outcome(folder.path(), "other"));
}

TEST(Outcome, ThatIsCutOffIsNone) {
  const TemporaryFolder folder;
  write_outcome(folder.path(), {"ok", ""}, "print");
  const std::string text = read_file(folder.path() / "outcome.json");
  for (std::size_t size = 0; size + 2 < text.size(); ++size) {
    write_file(folder.path() / "outcome.json", text.substr(0, size));
    EXPECT_FALSE(read_outcome(folder.path(), "print")) << size;
  }
}

TEST(Outcome, IsTriedAgainAfterAnInterruptTroubleWithFilesOrAShorterLimit) {
  EXPECT_TRUE(is_final({"ok", ""}, 10));
  EXPECT_TRUE(is_final({"internal_error", ""}, 10));
  EXPECT_FALSE(is_final({"interrupted", ""}, 10));
  EXPECT_FALSE(is_final({"io_error", ""}, 10));
  EXPECT_FALSE(is_final({"limit_reached", "", 5, 5}, 10));
  EXPECT_TRUE(is_final({"limit_reached", "", 10, 10}, 10));
  EXPECT_TRUE(is_final({"limit_reached", ""}, 10));
}

}  // namespace
}  // namespace feder::experiments
