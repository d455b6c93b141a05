#include "experiments/support/trajectory_columns.h"

#include <initializer_list>

namespace feder::experiments {
namespace {

void add_columns(std::vector<std::string>& columns, const std::string& name,
                 std::initializer_list<const char*> endings) {
  for (const char* ending : endings) columns.push_back(name + ending);
}

}  // namespace

std::vector<std::string> trajectory_columns(const Scene& scene) {
  const System& s = scene.model.system;
  std::vector<std::string> nodes, bodies;
  for (int i = 0; i < s.places(); ++i) nodes.push_back("node " + std::to_string(i));
  for (std::size_t i = 0; i < s.bodies.size(); ++i) {
    bodies.push_back("body " + std::to_string(i));
    nodes[s.bodies[i].centre] = bodies.back();
  }
  for (const SceneNode& node : scene.nodes) {
    nodes[node.node] = node.name;
    if (node.body >= 0) bodies[node.body] = node.name;
  }

  std::vector<std::string> columns = {"t"};
  for (int i = 0; i < s.places(); ++i) add_columns(columns, nodes[i], {".x", ".y", ".z"});
  for (const std::string& body : bodies) add_columns(columns, body, {".qw", ".qx", ".qy", ".qz"});
  for (int i = 0; i < s.places(); ++i) add_columns(columns, nodes[i], {".vx", ".vy", ".vz"});
  for (const std::string& body : bodies) add_columns(columns, body, {".wx", ".wy", ".wz"});
  return columns;
}

}  // namespace feder::experiments
