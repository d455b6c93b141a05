#pragma once

#include <string>
#include <vector>

namespace feder::experiments {

/// A scene that must be refused, of a file in scenes/wrong.
struct WrongScene {
  std::string where;                  ///< "names.txt: a name twice"
  std::string text;                   ///< of the scene
  std::vector<std::string> changes;   ///< of --set
  std::vector<std::string> problems;  ///< all of them in order: how each starts, "3:8: drag = -1"
};

/// A case is "=== TITLE", lines "! PROBLEM", lines "$ KEY=VALUE", then the scene. Unless its title starts
/// with "alone" the scene is followed by then.toml, and has the end time 1 where it gives none.
std::vector<WrongScene> wrong_scenes();

/// What the reader says about a text, its lines apart, those of the scene without the file's name and the
/// folder's path (FOLDER). A scene that is accepted gives nothing; every other exception than SceneError goes
/// through.
std::vector<std::string> problems_of(const std::string& text, const std::vector<std::string>& changes = {});

std::string scenes_folder();

}  // namespace feder::experiments
