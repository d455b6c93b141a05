// Valid scenes, mutated: each becomes a scene or a SceneError with places, soon, and nothing else.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <random>

#include "experiments/support/files.h"
#include "experiments/support/method.h"
#include "models/scene_file/scene_file.h"
#include "tests/experiments/wrong_scenes.h"
#include "tests/support/campaign.h"

namespace feder::experiments {
namespace {

constexpr double kMostSeconds = 2.0;

const std::vector<std::string> kHostile = {"nan",
                                           "-inf",
                                           "inf",
                                           "1e999",
                                           "1e308",
                                           "-1e308",
                                           "1e-320",
                                           "0",
                                           "-1",
                                           "-0.0",
                                           "1",
                                           "2",
                                           "3.5",
                                           "1e7",
                                           "9223372036854775807",
                                           "-9223372036854775808",
                                           "99999999999999999999",
                                           "10000000",
                                           "true",
                                           "\"\"",
                                           "\"rigid\"",
                                           "\"fixed\"",
                                           "\"p\"",
                                           "\"world\"",
                                           "\"rope[1]\"",
                                           "\"b\"",
                                           "[]",
                                           "[0, 0, 0]",
                                           "[1e200, 1e-200, 0]",
                                           "[0, 0, 1]",
                                           "[1000000, 1000000]",
                                           "[3, 3]",
                                           "[3, 3, 3]",
                                           "[[]]",
                                           "[[0, 0], [1, 1]]",
                                           "{}",
                                           "{body = \"b\", point = [0, 0, 0]}",
                                           "{axis = [0, 0, 1e-170], angle = 1}",
                                           "1979-05-27",
                                           "07:32:00",
                                           "\"sqrt(t - 1)\"",
                                           "\"1/0\"",
                                           "\"((((((t))))))\"",
                                           "\"t ? 1 : 2\"",
                                           "'\\u0000'",
                                           "\"\\u0000\"",
                                           "\"\xff\"",
                                           "\"../../etc/passwd\"",
                                           "\"tetrahedron.obj\"",
                                           "\"then.toml\"",
                                           "\"mesh\"",
                                           "\"parts\"",
                                           "\"box\"",
                                           "",
                                           "="};

class Mutator {
 public:
  explicit Mutator(std::uint64_t seed) : random_(seed) {
    const std::filesystem::path folder = std::filesystem::path(scenes_folder()) / "valid";
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".toml") files_.push_back(entry.path());
    std::sort(files_.begin(), files_.end());
    for (const auto& file : files_) seeds_.push_back(lines_of(read_file(file)));
  }

  std::string next() {
    std::vector<std::string> lines = pick(seeds_);
    for (std::size_t i = 0, n = 1 + below(4); i < n && !lines.empty(); ++i) mutate(lines);
    std::string text;
    for (const std::string& line : lines) text += line + "\n";
    if (below(20) == 0) text.resize(below(text.size() + 1));
    if (below(20) == 0 && !text.empty())
      for (std::size_t i = 0, n = 1 + below(8); i < n; ++i)
        text[below(text.size())] = static_cast<char>(below(256));
    return text;
  }
  std::size_t seeds() const { return seeds_.size(); }

 private:
  static std::vector<std::string> lines_of(const std::string& text) {
    std::vector<std::string> lines;
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      lines.push_back(text.substr(begin, end - begin));
      begin = end + 1;
    }
    return lines;
  }
  std::size_t below(std::size_t n) { return n == 0 ? 0 : random_() % n; }
  template <class T>
  const T& pick(const std::vector<T>& list) {
    return list[below(list.size())];
  }

  void mutate(std::vector<std::string>& lines) {
    std::string& line = lines[below(lines.size())];
    const std::size_t equals = line.find('=');
    switch (below(9)) {
      case 0:
        return std::swap(line, lines[below(lines.size())]);
      case 1:
        lines.erase(lines.begin() + (&line - lines.data()));
        return;
      case 2:
        lines.insert(lines.begin() + static_cast<long>(below(lines.size())), std::string(line));
        return;
      case 3:
      case 4:
        if (equals != std::string::npos) line = line.substr(0, equals + 1) + " " + pick(kHostile);
        return;
      case 5:
        return change_token(line);
      case 6: {  // a stretch of another scene
        const std::vector<std::string>& other = pick(seeds_);
        const std::size_t from = below(other.size()),
                          count = below(std::min<std::size_t>(12, other.size() - from) + 1);
        lines.insert(lines.begin() + static_cast<long>(below(lines.size())),
                     other.begin() + static_cast<long>(from),
                     other.begin() + static_cast<long>(from + count));
        return;
      }
      case 7:
        if (!line.empty()) line.erase(below(line.size()), 1 + below(3));
        return;
      default:
        line.insert(below(line.size() + 1), pick(kHostile));
    }
  }

  // One number, name or text between separators becomes a hostile one.
  void change_token(std::string& line) {
    const std::string separators = " ,[]{}=";
    std::vector<std::pair<std::size_t, std::size_t>> tokens;
    for (std::size_t at = line.find_first_not_of(separators); at != std::string::npos;) {
      const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
      tokens.emplace_back(at, end - at);
      at = line.find_first_not_of(separators, end);
    }
    if (tokens.empty()) return;
    const auto [at, size] = tokens[below(tokens.size())];
    line.replace(at, size, pick(kHostile));
  }

  std::mt19937_64 random_;
  std::vector<std::filesystem::path> files_;
  std::vector<std::vector<std::string>> seeds_;
};

// "scene.toml:12:3: ...", or the count of those that are not shown.
bool has_place(const std::string& line) {
  const std::string name = "scene.toml:";
  if (line.starts_with("and ")) return true;
  if (!line.starts_with(name)) return false;
  const std::size_t first = line.find(':', name.size()), second = line.find(": ", first + 1);
  const auto number = [&](std::size_t from, std::size_t to) {
    return from < to &&
           std::all_of(line.begin() + static_cast<long>(from), line.begin() + static_cast<long>(to),
                       [](char c) { return c >= '0' && c <= '9'; });
  };
  return second != std::string::npos && number(name.size(), first) && number(first + 1, second) &&
         second + 2 < line.size();
}

enum class Outcome { kScene, kError };

Outcome read(const std::string& text) {
  Method method;
  Output output;
  SceneOptions options{.others = method_readers(method, output)};
  options.most_nodes = 500, options.most_rows = 5000;
  try {
    const SceneFile file = read_scene_text(text, "scene.toml", scenes_folder() + "/valid", options);
    EXPECT_FALSE(file.scene.nodes.empty());
    EXPECT_TRUE(file.scene.model.state.q.allFinite() && file.scene.model.state.v.allFinite());
    EXPECT_GT(file.scene.model.end_time, 0.0);
    return Outcome::kScene;
  } catch (const SceneError& error) {
    std::string what = std::string(error.what()) + "\n";
    EXPECT_LE(std::count(what.begin(), what.end(), '\n'), 21);
    for (std::size_t begin = 0; begin < what.size();) {
      const std::size_t end = what.find('\n', begin);
      EXPECT_TRUE(has_place(what.substr(begin, end - begin))) << what.substr(begin, end - begin);
      begin = end + 1;
    }
    return Outcome::kError;
  } catch (const std::exception& error) {
    ADD_FAILURE() << error.what();
    return Outcome::kError;
  }
}

TEST(MutatedScenes, AreScenesOrErrorsWithPlaces) {
  Mutator mutator(1);
  ASSERT_GE(mutator.seeds(), 10u);
  const int cases = test::campaign_cases(1'000'000);
  int scenes = 0, errors = 0;
  double slowest = 0.0;
  for (int i = 0; i < cases && !HasFailure(); ++i) {
    const std::string text = mutator.next();
    SCOPED_TRACE(text);
    const auto start = std::chrono::steady_clock::now();
    (read(text) == Outcome::kScene ? scenes : errors) += 1;
    slowest =
        std::max(slowest, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    EXPECT_LT(slowest, kMostSeconds);
  }
  RecordProperty("scenes", scenes);
  RecordProperty("errors", errors);
  std::printf("%d scenes, %d errors, slowest %.3f s\n", scenes, errors, slowest);
  EXPECT_GT(scenes, cases / 100);
  EXPECT_GT(errors, cases / 4);
}

}  // namespace
}  // namespace feder::experiments
