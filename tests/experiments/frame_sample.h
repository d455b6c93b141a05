// A scene with particles, world points, a moving point, two bodies and every row type; frames of it; and what
// a folder holds.
#pragma once

#include <Eigen/Geometry>
#include <filesystem>
#include <map>
#include <string>

#include "engine/drive.h"
#include "engine/joints.h"
#include "experiments/support/files.h"
#include "experiments/support/frame_files.h"
#include "models/scene_file/scene_of.h"
#include "tests/support/random.h"

namespace feder::experiments {

/// Node names "plain", "with,comma", "say \"hi\"", "moving"; bodies "crank" (principal axes tilted against
/// the given ones, centre off the origin) and "<box> & more".
inline Scene sample_scene() {
  SystemBuilder builder;
  const Anchor world = builder.add_world_point({0.0, 0.0, 0.0});
  const Anchor p = builder.add_particle(0.3, {1.0, 0.1, 0.0}), r = builder.add_particle(0.7, {2.0, 0.0, 0.3});
  const Anchor moving = builder.add_moving_point({[](double t) { return Vector3d(3.0, t, 0.2); },
                                                  [](double) { return Vector3d(0.0, 1.0, 0.0); },
                                                  [](double) { return Vector3d::Zero().eval(); }});
  const Anchor crank = builder.add_body(
      point_masses("crank",
                   {{1.0, {1, 0, 0}}, {2.0, {0.2, 1, 0}}, {1.5, {0, 0.3, 1}}, {0.4, {0.1, 0.2, 0.3}}}),
      {.position = {4.0, 0.5, 0.0},
       .orientation = Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix()});
  const Anchor box = builder.add_body(solid_box("box", 2.0, {0.1, 0.2, 0.4}), {.position = {5.0, 0.0, 0.0}});

  builder.add_distance(world, p, {10.0});
  builder.add_distance(p, r, {kRigid});
  builder.add_distance(r, moving, {5.0, 0.1}, 0.0);
  builder.add(CurvatureRow{{world.node, p.node, r.node}, 4.0, 0.03});
  builder.add(AngleRow{{p.node, r.node, moving.node}, 6.0, 0.0, 1.0});
  AnchorDistanceRow rope;
  rope.a = p;
  rope.b = builder.anchor_at(crank, {4.2, 0.6, 0.1});
  rope.stiffness = 20.0;
  rope.rest = 2.5;
  builder.add(rope);
  add_hinge(builder, crank, box, {4.5, 0.2, 0.0}, {0.0, 0.0, 1.0});
  add_turn(builder, crank, box, {0.0, 0.0, 1.0}, {3.0}, steady_target(0.0, 2.0));
  add_cylindrical(builder, box, Anchor{}, {5.0, 0.0, 0.0}, {1.0, 0.0, 0.0}, {{100.0}, {10.0}});
  builder.set_gravity({0.0, -9.81, 0.0});
  auto [system, state] = builder.build();

  Scene scene = scene_of({.name = "sample 1/2", .system = std::move(system), .state = std::move(state)});
  const std::map<int, std::string> names = {
      {p.node, "plain"}, {r.node, "with,comma"}, {moving.node, "moving"}};
  for (SceneNode& node : scene.nodes) {
    if (names.contains(node.node)) node.name = names.at(node.node);
    if (node.node == world.node) node.name = "say \"hi\"";
    if (node.body >= 0) node.name = node.body == 0 ? "crank" : "<box> & more";
  }
  scene.surfaces = {{1,
                     {{0.1, 0.0, 0.0}, {0.0, 0.2, 0.0}, {0.0, 0.0, 0.4}, {0.0, 0.0, 0.0}},
                     {{0, 1, 2}, {1, 0, 3}, {2, 1, 3}, {0, 2, 3}}}};
  return scene;
}

inline constexpr FrameOptions kEveryFile{true, true, true, true, true, true};
inline constexpr std::int64_t kSampleFrames = 12;

/// Frame i, the same whenever it is asked for. Frame 0 has no multipliers yet.
inline State sample_state(const Scene& scene, std::int64_t i) {
  const System& s = scene.model.system;
  Random random(1000 + static_cast<std::uint64_t>(i));
  State state = scene.model.state;
  state.t = 0.1 * static_cast<double>(i);
  state.q += random.numbers(static_cast<int>(state.q.size()), 0.1);
  state.v += random.numbers(static_cast<int>(state.v.size()), 1e3);
  state.v[3] = -0.0;
  state.v[4] = 5e-324;
  normalise_quaternions(s, state.q);
  drive(s, state);
  return state;
}

inline History sample_history(const Scene& scene, std::int64_t i) {
  if (i == 0) return {};
  Random random(2000 + static_cast<std::uint64_t>(i));
  History history;
  history.lambda = random.numbers(scene.model.system.rows, 1e6);
  history.force = random.numbers(3 * scene.model.system.nodes, 10.0);
  history.suggested_dt = random.uniform(0.0, 1.0);
  history.last_dt = random.uniform(0.0, 1.0);
  history.contacts = random.numbers(12, 1.0);
  return history;
}

inline void add_frames(FrameFiles& files, const Scene& scene, std::int64_t first, std::int64_t end) {
  for (std::int64_t i = first; i < end; ++i) files.add(i, sample_state(scene, i), sample_history(scene, i));
}

/// Writes frames 0 to frames - 1 of the sample, all files of them.
inline void write_sample(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder) {
  FrameFiles files(scene, kSampleFrames, folder, kEveryFile);
  add_frames(files, scene, 0, frames);
  files.finish();
}

/// Name in the folder -> content, of every file below it.
inline std::map<std::string, std::string> contents(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.is_regular_file())
      files[std::filesystem::relative(entry.path(), folder).string()] = read_file(entry.path());
  return files;
}

/// The names alone, and whether all contents are equal: a readable message where they are not.
inline std::string difference(const std::map<std::string, std::string>& a,
                              const std::map<std::string, std::string>& b) {
  for (const auto& [name, text] : a)
    if (!b.contains(name))
      return name + " is missing";
    else if (b.at(name) != text)
      return name + " differs";
  for (const auto& [name, text] : b)
    if (!a.contains(name)) return name + " is too many";
  return "";
}

}  // namespace feder::experiments
