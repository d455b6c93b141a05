// ODE QuickStep: projected Gauss-Seidel on the joints' rows, 20 sweeps, the engine's own ERP and CFM.
#include <ode/ode.h>

#include "tests/bench/oracle_simulator.h"

namespace feder {
namespace {

constexpr int kSweeps = 20;

class Ode : public Simulator {
 public:
  explicit Ode(const Model& model) {
    dInitODE2(0);
    world_ = dWorldCreate();
    const Vector3d g = model.system.forces.gravity;
    dWorldSetGravity(world_, g.x(), g.y(), g.z());
    dWorldSetQuickStepNumIterations(world_, kSweeps);
    dWorldSetAutoDisableFlag(world_, 0);
    for (int i = 0; i < std::ssize(model.system.bodies); ++i) add_body(model, i);
    for (const BallRow& joint : joints_of(model.system)) {
      const dJointID ball = dJointCreateBall(world_, nullptr);
      dJointAttach(ball, body(joint.a), body(joint.b));
      const Vector3d at = place_of(model, joint.a);
      dJointSetBallAnchor(ball, at.x(), at.y(), at.z());
    }
  }
  ~Ode() override {
    dWorldDestroy(world_);
    dCloseODE();
  }
  const char* name() const override { return "ODE QuickStep"; }
  Status step(double dt) override {
    if (!dWorldQuickStep(world_, dt)) return Status::failure(StatusCode::kOutOfMemory, "ODE: out of memory");
    if (!std::isfinite(dBodyGetPosition(bodies_.back())[0]))
      return Status::failure(StatusCode::kNonFinite, "ODE: the last body's place is not finite");
    return {};
  }
  Pose pose(int i) const override {
    const dReal* x = dBodyGetPosition(bodies_[static_cast<std::size_t>(i)]);
    const dReal* r = dBodyGetRotation(bodies_[static_cast<std::size_t>(i)]);
    Pose pose{{x[0], x[1], x[2]}, {}};
    pose.axes << r[0], r[1], r[2], r[4], r[5], r[6], r[8], r[9], r[10];
    return pose;
  }

 private:
  void add_body(const Model& model, int i) {
    const Pose pose = pose_of(model.system, model.state, i);
    const Vector3d inertia = box_inertia_of(model.system, i);
    const Matrix3d& r = pose.axes;
    const dMatrix3 rotation = {r(0, 0), r(0, 1), r(0, 2), 0.0,     r(1, 0), r(1, 1),
                               r(1, 2), 0.0,     r(2, 0), r(2, 1), r(2, 2), 0.0};
    dMass mass;
    dMassSetParameters(&mass, mass_of(model.system, i), 0, 0, 0, inertia.x(), inertia.y(), inertia.z(), 0, 0,
                       0);
    bodies_.push_back(dBodyCreate(world_));
    dBodySetMass(bodies_.back(), &mass);
    dBodySetPosition(bodies_.back(), pose.centre.x(), pose.centre.y(), pose.centre.z());
    dBodySetRotation(bodies_.back(), rotation);
  }
  dBodyID body(const Anchor& anchor) const {
    return anchor.body < 0 ? nullptr : bodies_[static_cast<std::size_t>(anchor.body)];
  }

  dWorldID world_ = nullptr;
  std::vector<dBodyID> bodies_;
};

}  // namespace

SimulatorPtr make_ode(const Model& model) {
  return std::make_unique<Ode>(model);
}

}  // namespace feder
