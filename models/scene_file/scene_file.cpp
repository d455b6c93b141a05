#include "models/scene_file/scene_file.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>

#include "engine/fluid/fluid.h"
#include "models/catalog.h"
#include "models/scene_file/assembly.h"
#include "models/scene_file/scene_of.h"

namespace feder {
namespace {

// The text of --set up to its '=', and what follows.
void apply_changes(Value& root, const std::vector<std::string>& changes, Diagnostics& problems) {
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const std::string& change = changes[i];
    const std::size_t equals = change.find('=');
    const int number = static_cast<int>(i) + 1;
    if (equals == std::string::npos)
      problems.add({0, number}, "expected key=value");
    else
      set_value(root, change.substr(0, equals), change.substr(equals + 1), number, problems);
  }
}

// A catalogue model is whole: nothing is added to it.
Scene model_scene(const Value& root, const Document& document, const std::vector<std::string>& others,
                  Diagnostics& problems) {
  const std::vector<std::string> allowed = {"title", "model", "end_time", "quick_end_time", "scene_length"};
  auto among = [](const std::vector<std::string>& list, const std::string& word) {
    return std::find(list.begin(), list.end(), word) != list.end();
  };
  for (const Value::Member& member : root.members)
    if (!among(allowed, member.key) && !among(others, member.key))
      problems.add(member.place,
                   "scene: " + quoted(member.key) + " beside a model, expected nothing but " + join(allowed));
  try {
    return scene_of(make_model(document.model.value));
  } catch (const InputError& error) {
    problems.add(document.model.place, std::string("scene: ") + error.what());
    return {};
  }
}

double diagonal(const System& s, const VectorXd& q) {
  Vector3d least = Vector3d::Constant(kRigid), greatest = -least;
  for (int i = 0; i < s.places(); ++i) {
    least = least.cwiseMin(Vector3d(q.segment<3>(3 * i)));
    greatest = greatest.cwiseMax(Vector3d(q.segment<3>(3 * i)));
  }
  return (greatest - least).norm();
}

// Energy is kept where nothing takes or gives any.
bool conservative(const System& s) {
  return !s.has_damping && !s.forces.has_drag && !s.forces.user && !s.forces.has_torques &&
         s.drives.empty() && s.law_springs.empty() && !(s.fluid && s.fluid->dissipates());
}

void set_times(const Value& root, const Document& document, const SceneOptions& options, Model& model,
               Diagnostics& problems) {
  if (document.end_time.given) model.end_time = document.end_time.value;
  if (options.quick && document.quick_end_time.given) model.end_time = document.quick_end_time.value;
  if (!root.find("end_time") && !root.find("model"))
    problems.add(document.place, "scene: 'end_time' is missing, expected a finite number > 0 in s");
  if (document.scene_length.given) model.scene_length = document.scene_length.value;
  for (const OtherTable& other : options.others)
    if (other.check && model.end_time > 0.0) other.check(model.end_time, problems);
}

}  // namespace

SceneFile read_scene_text(const std::string& text, const std::string& name,
                          const std::filesystem::path& folder, const SceneOptions& options) {
  Diagnostics problems(name, options.changes);
  SceneFile file;
  Value root = parse_toml(text, problems);
  problems.throw_if_any();
  apply_changes(root, options.changes, problems);
  problems.throw_if_any();
  std::vector<std::string> others;
  for (const OtherTable& other : options.others) others.push_back(other.name);
  const Document document = read_document(root, others, problems);
  for (const OtherTable& other : options.others) {
    const Value* table = root.find(other.name);
    if (table && table->type == Value::Type::kTable)
      other.read(*table, problems);
    else if (table)
      problems.add(table->place,
                   other.name + " = " + table->shown() + ", expected a table [" + other.name + "]");
  }
  file.title = document.title;
  if (document.model.given) {
    file.scene = model_scene(root, document, others, problems);
  } else {
    Assembly assembly(document, {options.most_nodes, options.most_rows, folder, options.allow_outside},
                      problems);
    file.scene = assembly.build();
    file.notes = assembly.notes();
  }
  Model& model = file.scene.model;
  set_times(root, document, options, model, problems);
  problems.throw_if_any();
  if (!document.model.given) {
    model.name = std::filesystem::path(name).stem().string();
    if (!document.scene_length.given) model.scene_length = diagonal(model.system, model.state.q);
    if (!(model.scene_length > 0.0)) {
      problems.add(document.place,
                   "scene: 'scene_length' is missing, expected it where all places of the start coincide");
      problems.throw_if_any();
    }
    if (conservative(model.system)) model.conserved = {conserved_energy()};
  }
  return file;
}

std::string read_scene_bytes(const std::filesystem::path& file) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);
  if (error)
    throw InputError("scene " + quoted(file.string()) + ": " + error.message() +
                     ", expected a readable file");
  if (size > kMostBytes)
    throw SceneError(file.string() + ":1:1: file of " + std::to_string(size) + " bytes, expected at most " +
                     std::to_string(kMostBytes));
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  if (!stream) throw InputError("scene " + quoted(file.string()) + ": cannot be read");
  return text.str();
}

SceneFile read_scene(const std::filesystem::path& file, const SceneOptions& options) {
  const std::filesystem::path folder =
      file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  return read_scene_text(read_scene_bytes(file), file.string(), folder, options);
}

}  // namespace feder
