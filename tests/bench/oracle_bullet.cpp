// A chain as one btMultiBody: Featherstone's articulated bodies in joint coordinates, so joints cannot gape.
// Off: colliders, damping (0.04 by default), sleeping, the clamp of joint velocities (100 rad/s by default).
#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <btBulletDynamicsCommon.h>

#include "tests/bench/oracle_simulator.h"

namespace feder {
namespace {

btVector3 vector(const Vector3d& x) {
  return {x.x(), x.y(), x.z()};
}

class Bullet : public Simulator {
 public:
  explicit Bullet(const Model& chain)
      : chain_(static_cast<int>(chain.system.bodies.size()), 0.0, btVector3(0, 0, 0), true, false) {
    const auto& joints = joints_of(chain.system);
    chain_.setBasePos(vector(place_of(chain, joints[0].a)));
    for (int i = 0; i < chain_.getNumLinks(); ++i) {
      const BallRow& joint = joints[static_cast<std::size_t>(i)];
      chain_.setupSpherical(i, mass_of(chain.system, i), vector(box_inertia_of(chain.system, i)), i - 1,
                            btQuaternion::getIdentity(), vector(joint.a.point), vector(-joint.b.point), true);
    }
    chain_.finalizeMultiDof();
    chain_.setLinearDamping(0.0);
    chain_.setAngularDamping(0.0);
    chain_.setUseGyroTerm(true);
    chain_.setMaxCoordinateVelocity(1e30);
    world_.setGravity(vector(chain.system.forces.gravity));
    world_.addMultiBody(&chain_);
  }
  ~Bullet() override { world_.removeMultiBody(&chain_); }
  const char* name() const override { return "Bullet"; }
  Status step(double dt) override {
    world_.stepSimulation(dt, 0);
    if (!std::isfinite(chain_.getVelocityVector()[6]))
      return Status::failure(StatusCode::kNonFinite, "Bullet: the first joint's velocity is not finite");
    return {};
  }
  Pose pose(int body) const override {
    const auto column = [&](double x, double y, double z) {
      const btVector3 to = chain_.localDirToWorld(body, {x, y, z});
      return Vector3d(to.x(), to.y(), to.z());
    };
    const btVector3 centre = chain_.localPosToWorld(body, {0, 0, 0});
    Pose pose{{centre.x(), centre.y(), centre.z()}, {}};
    pose.axes << column(1, 0, 0), column(0, 1, 0), column(0, 0, 1);
    return pose;
  }

 private:
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
  btMultiBody chain_;
};

}  // namespace

SimulatorPtr make_bullet(const Model& chain) {
  return std::make_unique<Bullet>(chain);
}

}  // namespace feder
