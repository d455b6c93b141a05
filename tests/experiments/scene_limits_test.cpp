// Texts that no scene is: too large, not UTF-8, with more problems than anybody reads.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "engine/check.h"
#include "experiments/support/files.h"
#include "models/scene_file/scene_file.h"
#include "tests/experiments/temporary_folder.h"
#include "tests/experiments/wrong_scenes.h"

namespace feder::experiments {
namespace {

const std::string kScene =
    "end_time = 1\n[[particle]]\nname = \"p\"\nmass = 1\nposition = [0, 0, 0]\n"
    "[[particle]]\nname = \"q\"\nmass = 1\nposition = [1, 0, 0]\n";

std::string repeated(const std::string& text, std::size_t count) {
  std::string all;
  all.reserve(text.size() * count);
  for (std::size_t i = 0; i < count; ++i) all += text;
  return all;
}

// The only problem of a text.
std::string problem_of(const std::string& text, const std::vector<std::string>& changes = {}) {
  const std::vector<std::string> problems = problems_of(text, changes);
  return problems.size() == 1 ? problems[0] : std::to_string(problems.size()) + " problems";
}

TEST(SceneLimits, AFileOf65MebibytesIsRefused) {
  EXPECT_EQ(problem_of(repeated("# comment, comment, comment .. \n", (std::size_t{65} << 20) / 32)),
            "1:1: file of 68157440 bytes, expected at most 67108864");
}

TEST(SceneLimits, ALineOfMoreThanAMebibyteIsRefused) {
  const std::string longest(kLongestLine - 1, 'x');
  EXPECT_TRUE(problems_of(kScene + "#" + longest).empty());
  for (const std::string& text : {"#" + longest + "x", "title = \"" + longest + "\"", "a" + longest + "=1",
                                  "title = '''\n" + longest + "xx'''"})
    EXPECT_NE(problem_of(kScene + text).find(": line longer than 1048576 bytes"), std::string::npos);
}

TEST(SceneLimits, AHundredThousandDotsAreRefused) {
  const std::string dots = repeated("a.", 100'000) + "a";
  EXPECT_EQ(problem_of(dots + " = 1"), "1:66: more than 32 dots in a key");
  EXPECT_EQ(problem_of("[" + dots + "]"), "1:67: more than 32 dots in a key");
  EXPECT_EQ(problem_of(kScene, {dots + "=1"}).substr(0, 12), "--set a.a.a.");
}

TEST(SceneLimits, NestingIsRefused) {
  EXPECT_EQ(problem_of("a = " + repeated("[", 100'000)), "1:69: brackets nested deeper than 64");
  EXPECT_EQ(problem_of("a = " + repeated("{a=", 100'000)), "1:197: brackets nested deeper than 64");
}

// Each of these costs memory without an equals sign.
TEST(SceneLimits, BracketsAndDotsCountAsValues) {
  for (const std::string text : {"[[a]]\n", "a = [\n[],\n[]]\n", "a.b.c.d.e = 1\n"})
    EXPECT_NE(problem_of(repeated(text, kMostValues)).find("values, brackets and dots"), std::string::npos);
}

TEST(SceneLimits, BytesThatAreNoTextAreRefusedWithTheirPlace) {
  for (const std::string& bytes : {std::string("\xff"), std::string("\xc3"), std::string("\xed\xa0\x80"),
                                   std::string(1, '\0'), std::string("\x01"), std::string("\x7f")}) {
    // the parser names invalid UTF-8 by the place before it
    const std::string within = problem_of("drag = 1\ntitle = \"" + bytes + "\"\n").substr(0, 5);
    EXPECT_TRUE(within == "2:9: " || within == "2:10:") << within;
    EXPECT_EQ(problem_of("drag = 1\n" + bytes + "\n").substr(0, 4), "2:1:") << bytes;
  }
  EXPECT_EQ(problem_of(std::string("\xff\xfe"
                                   "e\0n\0d\0",
                                   8))
                .substr(0, 4),
            "1:1:");
}

// The parser has undefined behaviour on some of these letters.
TEST(SceneLimits, LettersOfOtherAlphabetsAreRefusedOutsideOfTexts) {
  const std::string problem = "a character that is not ASCII, expected only in texts and comments";
  EXPECT_EQ(problem_of("drag = \xcf\xa5"), "1:8: " + problem);
  EXPECT_EQ(problem_of("drag = 0[\"0.1\xd2\x85i = 2").substr(0, 4), "1:9:");  // within an open text
  EXPECT_EQ(problem_of("\xc3\xa4 = 1"), "1:1: " + problem);
  EXPECT_TRUE(
      problems_of(kScene + "[[point]]\nname = \"\xcf\xa5\"  # \xcf\xa5\nposition = [0, 1, 0]\n").empty());
}

// Where the look ahead and the parser disagreed about the end of a text, limits could be passed by.
TEST(SceneLimits, QuotesWhereNoTextStartsAreRefused) {
  EXPECT_EQ(problem_of("drag = 0Bm'''''\xd2\x95"), "1:11: a quote in the middle of a word");
  EXPECT_EQ(problem_of("drag = 1\n'''a''' = 1"), "2:1: three quotes, expected only around a value");
  EXPECT_EQ(problem_of("a.'''" + repeated("b.", 100)), "1:3: three quotes, expected only around a value");
  EXPECT_TRUE(problems_of("title = '''a'''''  # '\n" + kScene).empty());
  EXPECT_TRUE(problems_of("\"title\"=\"\"\"\\\"\"\"\"\n" + kScene).empty());
}

TEST(SceneLimits, AByteOrderMarkAndCarriageReturnsAreFine) {
  std::string windows = "\xef\xbb\xbf";
  for (const char c : kScene) windows += c == '\n' ? "\r\n" : std::string(1, c);
  EXPECT_TRUE(problems_of(windows).empty());
}

TEST(SceneLimits, TwentyProblemsAreShownAndTheOthersCounted) {
  std::string text = kScene;
  for (int i = 0; i < 50; ++i) text += "[[spring]]\nbetween = [\"p\", \"x\"]\nstiffness = -1\nlenght = 1\n";
  const std::vector<std::string> problems = problems_of(text);
  ASSERT_EQ(problems.size(), 21u);
  EXPECT_EQ(problems[0].substr(0, 25), "11:17: spring 0: 'x' is n");
  EXPECT_EQ(problems[20], "and 130 more");
}

TEST(SceneLimits, AHundredThousandProblemsTakeNoLongTime) {
  const auto start = std::chrono::steady_clock::now();
  std::string text = kScene;
  for (int i = 0; i < 100'000; ++i) text += "[[spring]]\nlenght = 1\n";
  EXPECT_EQ(problems_of(text).back(), "and 199980 more");
  std::string names = kScene;
  for (int i = 0; i < 20'000; ++i)
    names += "[[point]]\nname = \"n" + std::to_string(i) + "\"\nposition = [0, 0, 0]\n[[force]]\non = \"m" +
             std::to_string(i) + "\"\nforce = [0, 0, 1]\n";
  EXPECT_EQ(problems_of(names).back(), "and 19980 more");
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 60.0);
}

TEST(SceneLimits, AMeshBehindALinkOutOfTheFolderIsRefused) {
  const TemporaryFolder folder, outside;
  const std::filesystem::path mesh = std::filesystem::path(scenes_folder()) / "valid/tetrahedron.obj";
  std::filesystem::copy_file(mesh, outside.path() / "stone.obj");
  std::filesystem::create_symlink(outside.path() / "stone.obj", folder.path() / "link.obj");
  std::filesystem::create_symlink(outside.path(), folder.path() / "sub");
  std::filesystem::copy_file(mesh, folder.path() / "here.obj");
  for (const auto& [name, sound] :
       {std::pair("link.obj", false), {"sub/stone.obj", false}, {"here.obj", true}}) {
    const std::string text =
        kScene + "[[body]]\nname = \"b\"\nshape = \"mesh\"\ndensity = 1\nmesh = \"" + name + "\"\n";
    if (sound) {
      EXPECT_NO_THROW((void)read_scene_text(text, "s", folder.path()));
      continue;
    }
    try {
      (void)read_scene_text(text, "s", folder.path());
      ADD_FAILURE() << name << " is accepted";
    } catch (const SceneError& error) {
      EXPECT_NE(std::string(error.what())
                    .find("14:8: body 'b': mesh = '" + std::string(name) + "', expected a file inside"),
                std::string::npos)
          << error.what();
    }
    EXPECT_NO_THROW((void)read_scene_text(text, "s", folder.path(), {.allow_outside = true}));
  }
}

TEST(SceneLimits, NoFileIsAnInputErrorWithItsName) {
  const TemporaryFolder folder;
  for (const std::filesystem::path& file : {folder.path() / "none.toml", folder.path()}) try {
      (void)read_scene(file);
      ADD_FAILURE() << file << " is accepted";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(", expected a readable file"), std::string::npos)
          << error.what();
    }
}

}  // namespace
}  // namespace feder::experiments
