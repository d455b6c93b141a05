#pragma once

#include <string>
#include <vector>

#include "models/scene_file/scene.h"

namespace feder::experiments {

/// "t", then a name for every entry of State::q and State::v in their order: crank.x ... crank.qw ...,
/// crank.vx ..., crank.wx ... . Quaternions and angular velocities are the state's own: of and in the
/// principal axes. Nodes the scene gives no name are "node 12", bodies "body 0".
std::vector<std::string> trajectory_columns(const Scene& scene);

}  // namespace feder::experiments
