#include "experiments/support/states_csv.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "experiments/support/table.h"

namespace feder::experiments {
namespace {

/// (w, x, y, z) of R(quaternion) axes^T; follows the state's quaternion without jumps of sign.
Eigen::Vector4d given_quaternion(const Body& body, const VectorXd& q) {
  const double* p = q.data() + body.quaternion;
  const Eigen::Quaterniond axes(body.axes);
  const Eigen::Quaterniond given =
      (Eigen::Quaterniond(p[0], p[1], p[2], p[3]) * axes.conjugate()).normalized();
  return {given.w(), given.x(), given.y(), given.z()};
}

}  // namespace

StatesCsv::StatesCsv(const Scene& scene) : scene_(&scene) {
  for (const SceneNode& node : scene.nodes) names_.push_back(fmt::format(",{}", csv_field(node.name)));
}

void StatesCsv::add(const Frame& frame, TextBuffer& text) {
  const State& state = frame.state;
  time_.clear();
  time_.add_number(state.t);
  for (std::size_t i = 0; i < names_.size(); ++i) {
    const SceneNode& node = scene_->nodes[i];
    text.add(time_.text());
    text.add(names_[i]);
    text.add_cells(state.q.data() + 3 * node.node, 3);
    if (node.body < 0) {
      text.add(",,,,");
      text.add_cells(state.v.data() + 3 * node.node, 3);
      text.add(",,,\n");
      continue;
    }
    const Body& body = scene_->model.system.bodies[node.body];
    text.add_cells(given_quaternion(body, state.q).data(), 4);
    text.add_cells(state.v.data() + 3 * node.node, 3);
    text.add_cells(angular_velocity(body, state).data(), 3);
    text.add("\n");
  }
}

}  // namespace feder::experiments
