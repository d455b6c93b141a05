#include "models/scene_file/assembly.h"

#include <algorithm>

#include "models/scene_file/start_check.h"

namespace feder {
namespace {

// What a message calls the kinds of names.
const char* called(SceneNode::Kind kind) {
  switch (kind) {
    case SceneNode::Kind::kParticle:
      return "particle";
    case SceneNode::Kind::kPoint:
      return "point";
    case SceneNode::Kind::kBody:
      return "body";
  }
  return "";
}

constexpr const char* kNoBrackets =
    ", expected a name without '[': brackets count the parts of chains and the like";

}  // namespace

Assembly::Assembly(const Document& document, const AssemblyLimits& limits, Diagnostics& problems)
    : document_(document), limits_(limits), problems_(problems) {}

void Assembly::tell(const Entry& entry, TextPlace place, const std::string& message) {
  problems_.add(place, entry.label + ": " + message);
}

bool Assembly::claim(const Entry& entry, const NameText& name) {
  if (!name.given) return false;  // its absence has been told
  if (name.value == "world") {
    tell(entry, name.place, "name = 'world', expected another name: this one stands for the world");
    return false;
  }
  if (name.value.find('[') != std::string::npos) {
    tell(entry, name.place, "name = " + quoted(name.value) + kNoBrackets);
    return false;
  }
  if (const auto other = names_.find(name.value);
      other != names_.end() && other->second.kind == Kind::kGroup) {
    tell(entry, name.place, "name = " + quoted(name.value) + ", expected a name that no group has");
    return false;
  }
  const auto [at, fresh] = claimed_.emplace(name.value, name.place);
  if (!fresh)
    tell(entry, name.place,
         "name = " + quoted(name.value) + ", expected a name that is not taken; it is used in line " +
             std::to_string(at->second.line));
  return fresh;
}

int Assembly::group(const std::string& name) {
  const auto [at, fresh] =
      names_.emplace(name, Named{Kind::kGroup, {}, static_cast<int>(scene_.groups.size())});
  if (!fresh && at->second.kind == Kind::kBroken) {  // a generator that turned out sound
    at->second = {Kind::kGroup, {}, static_cast<int>(scene_.groups.size())};
    scene_.groups.push_back({name, {}});
  }
  if (fresh) scene_.groups.push_back({name, {}});
  return at->second.kind == Kind::kGroup ? at->second.index : -1;
}

void Assembly::name_node(const Entry& entry, const std::string& name, SceneNode::Kind kind,
                         const Anchor& anchor, const NameText& group_name) {
  const int index = static_cast<int>(scene_.nodes.size());
  scene_.nodes.push_back({name, kind, anchor.node, anchor.body});
  const Kind named = kind == SceneNode::Kind::kBody    ? Kind::kBody
                     : kind == SceneNode::Kind::kPoint ? Kind::kPoint
                                                       : Kind::kParticle;
  names_[name] = {named, anchor, index};
  if (!group_name.given) return;
  const int at = claimed_.count(group_name.value) ? -1 : group(group_name.value);
  if (at < 0)
    tell(entry, group_name.place,
         "group = " + quoted(group_name.value) + ", expected a name that no entry has");
  else
    scene_.groups[static_cast<std::size_t>(at)].members.push_back(index);
}

const Assembly::Named* Assembly::look_up(const Entry& entry, const NameText& name,
                                         const std::vector<Kind>& kinds, const char* expectation) {
  if (!name.given) return nullptr;
  const auto found = names_.find(name.value);
  const auto whole = names_.find(name.value.substr(0, name.value.find('[')));  // the generator it is part of
  if (found == names_.end() && whole != names_.end() && whole->second.kind == Kind::kBroken) return nullptr;
  if (found == names_.end()) {
    std::vector<std::string> known;
    if (problems_.shows(name.place))
      for (const auto& [other, named] : names_)
        if (std::find(kinds.begin(), kinds.end(), named.kind) != kinds.end()) known.push_back(other);
    if (name.value == "world" && std::find(kinds.begin(), kinds.end(), Kind::kPoint) != kinds.end())
      return tell(entry, name.place,
                  std::string("'world' is no place, expected ") + expectation + ", or a place [x, y, z]"),
             nullptr;
    tell(entry, name.place,
         quoted(name.value) + " is no name of this scene, expected " + expectation +
             (known.empty() ? "" : "; did you mean '" + nearest(name.value, known) + "'?"));
    return nullptr;
  }
  if (found->second.kind == Kind::kBroken) return nullptr;
  if (std::find(kinds.begin(), kinds.end(), found->second.kind) == kinds.end()) {
    const Named& named = found->second;
    tell(entry, name.place,
         quoted(name.value) + " is a " +
             (named.kind == Kind::kGroup ? "group"
                                         : called(scene_.nodes[static_cast<std::size_t>(named.index)].kind)) +
             ", expected " + expectation);
    return nullptr;
  }
  return &found->second;
}

Vector3d Assembly::place_of(const Anchor& anchor) const {
  if (anchor.body < 0) return places_[static_cast<std::size_t>(anchor.node)];
  const Pose& pose = poses_[static_cast<std::size_t>(anchor.body)];
  return pose.position + pose.axes * anchor.point;
}

bool Assembly::claim_row(const Entry& entry, const NameText& name, const std::string& type) {
  const std::string& known = name.given ? name.value : entry.label;
  if (known.find('[') != std::string::npos) {
    tell(entry, name.place, "name = " + quoted(known) + kNoBrackets);
    return false;
  }
  const bool fresh = row_names_.emplace(known, type).second;
  if (!fresh)
    tell(entry, name.given ? name.place : entry.place,
         "name = " + quoted(known) + ", expected a name that no other row of type '" + type + "' has");
  return fresh;
}

void Assembly::record(const Entry& entry, const NameText& name, const std::vector<int>& ids,
                      const std::vector<std::string>& types, const std::vector<Anchor>& nodes) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (!claim_row(entry, name, types[i])) return;
    rows_.push_back({{name.given ? name.value : entry.label, types[i], 0, 1, nodes}, ids[i], &entry});
  }
}

Scene Assembly::build() {
  for (const MaterialEntry& material : document_.materials)
    if (material.name.given && !materials_.emplace(material.name.value, &material).second)
      tell(material, material.name.place,
           "name = " + quoted(material.name.value) + ", expected a name that no other material has");
  builder_.set_gravity(document_.gravity);
  builder_.set_drag(document_.drag);
  add_points();
  add_particles();
  add_chains();
  add_cloths();
  add_lattices();
  add_bodies();
  add_nets();

  add_springs();
  add_law_springs();
  add_bendings();
  add_joints();
  add_turns();
  add_slides();
  add_perpendiculars();
  add_forces();
  add_torques();

  if (scene_.nodes.empty() && problems_.empty())
    tell(document_, document_.place, "it holds nothing, expected particles, bodies, or a model");
  if (!problems_.empty()) return {};
  for (const Recorded& recorded : rows_)
    builder_.label_row(recorded.id, "row " + quoted(recorded.row.name) + " (" + recorded.row.type + ")");
  attempt(document_, [&] {
    auto [system, state] = builder_.build();
    close(scene_, system);
    scene_.model.system = std::move(system);
    scene_.model.state = std::move(state);
    check_start(scene_);
    check_hard_rows(scene_);
  });
  return std::move(scene_);
}

// What is known only of the finished system: centres of bodies, rows.
void Assembly::close(Scene& scene, const System& system) const {
  for (SceneNode& node : scene.nodes)
    if (node.body >= 0) node.node = system.bodies[static_cast<std::size_t>(node.body)].centre;
  for (const Recorded& recorded : rows_) {
    scene.rows.push_back(recorded.row);
    SceneRow& row = scene.rows.back();
    row.first_row = system.row_of_id[static_cast<std::size_t>(recorded.id)];
    row.rows = row.type.starts_with("ball") || row.type.starts_with("curvature") ? 3 : 1;
  }
}

// A rigid row that is open would be closed by a jump; a velocity across it would be lost in the first step.
void Assembly::check_hard_rows(const Scene& scene) {
  const System& s = scene.model.system;
  const State& start = scene.model.state;
  if (!s.has_hard_rows) return;
  auto recorded_at = [&](int row) -> const Recorded& {
    std::size_t i = 0;
    while (row < scene.rows[i].first_row || row >= scene.rows[i].first_row + scene.rows[i].rows) ++i;
    return rows_[i];
  };
  for (const Misfit& open : open_rows(s, start)) {
    const Recorded& recorded = recorded_at(open.row);
    const std::string& type = recorded.row.type;
    const char* unit = type.starts_with("perpendicular")   ? ""
                       : type == "turn" || type == "angle" ? " rad"
                                                           : " m";
    tell(*recorded.entry, recorded.entry->place,
         "this rigid " + type + " is open by " + to_text(open.size) + unit +
             " at the start, expected 0: a length as placed, a target that starts at 0");
  }
  const std::vector<Misfit> moving = moving_rows(s, start);
  const auto worst = std::max_element(moving.begin(), moving.end(),
                                      [](const Misfit& x, const Misfit& y) { return x.size < y.size; });
  if (worst != moving.end())
    notes_.push_back("the velocities at the start do not fit " + std::to_string(moving.size()) +
                     (moving.size() == 1 ? " rigid row, " : " rigid rows, ") + s.row_name(worst->row) +
                     " the most (" + to_text(worst->size) +
                     " m/s or rad/s across it): the first step takes that motion and its energy away");
}

}  // namespace feder
