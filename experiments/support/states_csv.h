#pragma once

#include <string>
#include <vector>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// states.csv: one line per time and SceneNode with place [m] and velocity [m/s]; of a body those of its
/// centre of mass, the quaternion of the axes it was given in, and the angular velocity in world axes
/// [rad/s]. These two are empty for particles and points.
class StatesCsv {
 public:
  explicit StatesCsv(const Scene& scene);

  static std::string name() { return "states.csv"; }
  static std::string start(std::int64_t) { return "t,name,x,y,z,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz\n"; }
  void add(const Frame& frame, TextBuffer& text);
  static std::string end() { return {}; }

 private:
  const Scene* scene_;
  std::vector<std::string> names_;  ///< ",name" per SceneNode
  TextBuffer time_;
};

}  // namespace feder::experiments
