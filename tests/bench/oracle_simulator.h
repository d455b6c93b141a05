#pragma once

#include <memory>

#include "engine/status.h"
#include "models/model.h"

namespace feder {

/// Centre of mass and axes of a body, those its anchors are given in.
struct Pose {
  Vector3d centre = Vector3d::Zero();
  Matrix3d axes = Matrix3d::Identity();
};

/// One engine running one scene of boxes and ball joints, built from the same Model for every engine.
class Simulator {
 public:
  Simulator() = default;
  Simulator(const Simulator&) = delete;
  Simulator& operator=(const Simulator&) = delete;
  virtual ~Simulator() = default;
  virtual const char* name() const = 0;
  virtual Status step(double dt) = 0;
  virtual Pose pose(int body) const = 0;
};
using SimulatorPtr = std::unique_ptr<Simulator>;

/// At the start of the model.
Pose pose_of(const System& system, const State& state, int body);
/// World place of an anchor when the bodies stand as in the simulator, or as at the start of the model.
Vector3d place_of(const Model& model, const Anchor& anchor, const Simulator& simulator);
Vector3d place_of(const Model& model, const Anchor& anchor);
/// Mass of a body [kg], and its inertia in the axes of its anchors [kg m^2]: a box has a diagonal one.
double mass_of(const System& system, int body);
Vector3d box_inertia_of(const System& system, int body);
const std::vector<BallRow>& joints_of(const System& system);

SimulatorPtr make_feder(const Model& model, const char* method, const char* route);
// Each exists if its engine was found. The model must outlive the simulator.
SimulatorPtr make_bullet(const Model& chain);
SimulatorPtr make_ode(const Model& model);
SimulatorPtr make_mujoco(const Model& model);

}  // namespace feder
