#include "tests/bench/oracle_simulator.h"

#include <variant>

#include "solvers/integrators.h"

namespace feder {
namespace {

const Body& body_of(const System& system, int body) {
  return system.bodies[static_cast<std::size_t>(body)];
}

class Feder : public Simulator {
 public:
  Feder(const Model& model, const char* method, const char* route)
      : system_(model.system),
        state_(model.state),
        integrator_(make_integrator(method, model.system, {.route = route})),
        prepared_(std::visit([](auto& i) { return i.prepare(); }, integrator_)) {}
  const char* name() const override { return "Feder"; }
  Status step(double dt) override {
    if (!prepared_.ok()) return prepared_;
    return std::visit([&](auto& i) { return i.step(dt, state_, history_, nullptr); }, integrator_);
  }
  Pose pose(int body) const override { return pose_of(system_, state_, body); }

 private:
  const System& system_;
  State state_;
  History history_;
  Integrator integrator_;
  Status prepared_;
};

}  // namespace

Pose pose_of(const System& system, const State& state, int body) {
  return {state.q.segment<3>(3 * body_of(system, body).centre), orientation(body_of(system, body), state.q)};
}

Vector3d place_of(const Model& model, const Anchor& anchor, const Simulator& simulator) {
  if (anchor.body < 0) return place_of(model, anchor);
  const Pose pose = simulator.pose(anchor.body);
  return pose.centre + pose.axes * (anchor.point - body_of(model.system, anchor.body).centre_point);
}

Vector3d place_of(const Model& model, const Anchor& anchor) {
  return position(model.system, anchor, model.state.q);
}

double mass_of(const System& system, int body) {
  return system.mass[body_of(system, body).centre];
}

Vector3d box_inertia_of(const System& system, int body) {
  const Body& b = body_of(system, body);
  return (b.axes * b.moments.asDiagonal() * b.axes.transpose()).diagonal();
}

const std::vector<BallRow>& joints_of(const System& system) {
  return std::get<std::vector<BallRow>>(system.stencil_rows);
}

SimulatorPtr make_feder(const Model& model, const char* method, const char* route) {
  return std::make_unique<Feder>(model, method, route);
}

}  // namespace feder
