#include "tests/experiments/wrong_scenes.h"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "experiments/support/files.h"
#include "experiments/support/method.h"
#include "models/scene_file/scene_file.h"

namespace feder::experiments {
namespace {

constexpr const char* kName = "scene.toml";

void finish(WrongScene& scene, const std::string& title, const std::string& then) {
  if (title.starts_with("alone")) return;
  scene.text += then;
  if (("\n" + scene.text).find("\nend_time = ") == std::string::npos)
    scene.changes.insert(scene.changes.begin(), "end_time=1");
}

void read_cases(const std::filesystem::path& file, const std::string& then, std::vector<WrongScene>& scenes) {
  std::istringstream lines(read_file(file));
  std::string title;
  WrongScene* scene = nullptr;
  bool head = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("=== ")) {
      if (scene) finish(*scene, title, then);
      title = line.substr(4), head = true;
      scene = &scenes.emplace_back();
      scene->where = file.filename().string() + ": " + title;
    } else if (head && line.starts_with("! ")) {
      scene->problems.push_back(line.substr(2));
    } else if (head && line.starts_with("$ ")) {
      scene->changes.push_back(line.substr(2));
    } else {
      head = false;
      scene->text += line + "\n";
    }
  }
  finish(*scene, title, then);
}

}  // namespace

std::string scenes_folder() {
  return FEDER_TEST_SCENES;
}

std::vector<WrongScene> wrong_scenes() {
  const std::filesystem::path folder = std::filesystem::path(scenes_folder()) / "wrong";
  const std::string then = read_file(folder / "then.toml");
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    if (entry.path().extension() == ".txt") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<WrongScene> scenes;
  for (const std::filesystem::path& file : files) read_cases(file, then, scenes);
  return scenes;
}

std::vector<std::string> problems_of(const std::string& text, const std::vector<std::string>& changes) {
  Method method;
  Output output;
  try {
    (void)read_scene_text(text, kName, std::filesystem::path(scenes_folder()) / "wrong",
                          {.changes = changes, .others = method_readers(method, output)});
    return {};
  } catch (const SceneError& error) {
    std::vector<std::string> problems;
    std::istringstream lines(error.what());
    const std::string prefix = std::string(kName) + ":";
    const std::string folder = scenes_folder() + "/wrong";
    for (std::string line; std::getline(lines, line);) {
      if (const std::size_t at = line.find(folder); at != std::string::npos)
        line.replace(at, folder.size() + (line[at + folder.size()] == '/'),
                     line[at + folder.size()] == '/' ? "" : "FOLDER");
      problems.push_back(line.starts_with(prefix) ? line.substr(prefix.size()) : line);
    }
    return problems;
  }
}

}  // namespace feder::experiments
