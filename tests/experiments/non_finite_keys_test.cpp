// nan and inf in every key of every table, and in every place of its value where a number may stand.
#include <gtest/gtest.h>

#include <algorithm>

#include "experiments/support/method.h"
#include "tests/experiments/wrong_scenes.h"

namespace feder::experiments {
namespace {

// The head of a table, each line ended.
std::string head_of(const TableInfo& table) {
  if (table.name.empty()) return "";
  if (table.name == "body.parts") return "[[body]]\nname = \"x\"\nshape = \"parts\"\n[[body.parts]]\n";
  return (table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]") + "\n";
}

std::vector<TableInfo> all_tables() {
  std::vector<TableInfo> tables = scene_tables();
  for (const TableInfo& table : method_tables()) tables.push_back(table);
  return tables;
}

const std::vector<std::string> kForms = {"#",
                                         "[#]",
                                         "[#, 0, 0]",
                                         "[0, #, 1]",
                                         "[1, 0, 0, #]",
                                         "[0, 1, 1, 0, 0, #]",
                                         "[[0, 0, #], \"p\"]",
                                         "[\"p\", {body = \"b\", point = [0, #, 0]}]",
                                         "[{body = \"b\", place = [#, 0, 0]}, \"p\"]",
                                         "{axis = [0, 0, #], angle = 0}",
                                         "{axis = [0, 0, 1], angle = #}",
                                         "[[#, 0], [1, 1]]",
                                         "[[0, 0], [1, #]]",
                                         "[0, 0, [[0, #], [1, 1]]]"};

TEST(NonFiniteKeys, AreRefusedEverywhereWithTheirPlace) {
  int tried = 0;
  for (const TableInfo& table : all_tables())
    for (const KeyInfo& key : table.keys)
      for (const std::string value : {"nan", "inf", "-inf"})
        for (std::string form : kForms) {
          form.replace(form.find('#'), 1, value);
          const std::string head = head_of(table), text = head + key.name + " = " + form + "\n";
          const std::string line = std::to_string(std::count(head.begin(), head.end(), '\n') + 1) + ":";
          SCOPED_TRACE(text);
          const std::vector<std::string> problems = problems_of(text);
          EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const std::string& problem) {
            const bool here = problem.starts_with(line),
                       expects = problem.find(", expected ") != std::string::npos;
            return here && expects && problem.find(key.name) != std::string::npos;
          })) << (problems.empty() ? "accepted" : problems.front());
          ++tried;
        }
  EXPECT_GE(tried, 100 * 3 * static_cast<int>(kForms.size()));
}

TEST(MisspeltKeys, AreToldWithTheKeyThatWasMeant) {
  for (const TableInfo& table : all_tables())
    for (const KeyInfo& key : table.keys) {
      std::string misspelt = key.name + "x";
      if (key.name.size() > 2) misspelt = key.name.substr(1);
      const auto same = [&](const KeyInfo& other) { return other.name == misspelt; };
      if (std::any_of(table.keys.begin(), table.keys.end(), same)) continue;
      const std::string head = head_of(table), text = head + misspelt + " = 1\n";
      const std::string line = std::to_string(std::count(head.begin(), head.end(), '\n') + 1);
      SCOPED_TRACE(text);
      const std::vector<std::string> problems = problems_of(text);
      EXPECT_TRUE(std::any_of(problems.begin(), problems.end(), [&](const std::string& problem) {
        return problem.starts_with(line + ":1: ") &&
               problem.find("no key '" + misspelt + "', did you mean '" + key.name + "'?") !=
                   std::string::npos;
      })) << (problems.empty() ? "accepted" : problems.front());
    }
}

}  // namespace
}  // namespace feder::experiments
