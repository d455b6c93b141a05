// The gallery shows all there is: every table, key, choice and model of the reference page.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>

#include "experiments/support/method.h"
#include "models/catalog.h"

namespace feder::experiments {
namespace {

using Words = std::set<std::string>;

// "spring.length", "joint.type=hinge", "output.files=vtu", "model=cloth": all that a scene says.
void collect(const Value& value, const std::string& path, Words& said) {
  said.insert(path);
  if (value.type == Value::Type::kText) said.insert(path + "=" + value.text.substr(0, value.text.find(':')));
  for (const Value& item : value.items) collect(item, path, said);
  for (const Value::Member& member : value.members)
    collect(member.value, path.empty() ? member.key : path + "." + member.key, said);
}

const Words& said_by_the_gallery() {
  static const Words all = [] {
    Words said;
    for (const auto& file : std::filesystem::directory_iterator(FEDER_SCENES)) {
      if (file.path().extension() != ".toml") continue;
      Diagnostics problems(file.path().string());
      collect(parse_toml(read_scene_bytes(file.path()), problems), "", said);
      problems.throw_if_any();
    }
    return said;
  }();
  return all;
}

std::vector<TableInfo> tables() {
  std::vector<TableInfo> list = scene_tables();
  for (const TableInfo& table : method_tables()) list.push_back(table);
  return list;
}

// The words after "one of " or "out of ", if it is such an expectation.
std::vector<std::string> choices(const std::string& expectation) {
  std::size_t at = expectation.find("one of ");
  if (at != 0) at = expectation.find("out of ");
  std::vector<std::string> words;
  if (at == std::string::npos) return words;
  for (at += 7; at < expectation.size();) {
    const std::size_t end = std::min(expectation.find(", ", at), expectation.size());
    words.push_back(expectation.substr(at, end - at));
    at = end + 2;
  }
  return words;
}

// A rod has no inertia about itself: it can only be a part of a body.
const Words kLeftOut = {"body.shape=rod", "body.length"};

std::string missing(const std::vector<std::string>& wanted) {
  std::vector<std::string> list;
  for (const std::string& word : wanted)
    if (!said_by_the_gallery().count(word) && !kLeftOut.count(word)) list.push_back(word);
  return join(list);
}

std::string path_of(const TableInfo& table, const KeyInfo& key) {
  return (table.name.empty() ? "" : table.name + ".") + key.name;
}

TEST(Gallery, ShowsEveryTableAndKey) {
  std::vector<std::string> wanted;
  for (const TableInfo& table : tables())
    for (const KeyInfo& key : table.keys) wanted.push_back(path_of(table, key));
  ASSERT_GT(wanted.size(), 150u);
  EXPECT_EQ(missing(wanted), "");
}

TEST(Gallery, ShowsEveryChoice) {
  std::vector<std::string> wanted;
  for (const TableInfo& table : tables())
    for (const KeyInfo& key : table.keys)
      for (const std::string& word : choices(key.expectation))
        wanted.push_back(path_of(table, key) + "=" + word);
  ASSERT_GT(wanted.size(), 50u);
  EXPECT_EQ(missing(wanted), "");
}

TEST(Gallery, ShowsEveryModelOfTheCatalogue) {
  std::vector<std::string> wanted;
  for (const ModelInfo& model : catalog()) wanted.push_back("model=" + model.name);
  EXPECT_EQ(missing(wanted), "");
}

TEST(Gallery, ShowsEveryFormOfAnAnchorAndAnOrientation) {
  EXPECT_EQ(missing({"spring.between.body", "spring.between.point", "spring.between.place",
                     "joint.between=world", "body.orientation.axis", "body.orientation.angle"}),
            "");
}

}  // namespace
}  // namespace feder::experiments
