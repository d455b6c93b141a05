#include "engine/drive.h"

#include "engine/system.h"

namespace feder {

Target steady_target(double start, double speed) {
  return {[=](double t) { return start + speed * t; }, [=](double) { return speed; },
          [](double) { return 0.0; }};
}

void place_driven_nodes(const System& s, double t, VectorXd& q) {
  for (const Drive& drive : s.drives) {
    const Vector3d x = drive.motion.position(t);
    q.segment(3 * drive.node, drive.dial ? 1 : 3) = x.head(drive.dial ? 1 : 3);
  }
  for (const TurnRow& row : std::get<std::vector<TurnRow>>(s.stencil_rows)) row.count_turns(q.data());
}

void set_driven_velocities(const System& s, double t, VectorXd& v) {
  for (const Drive& drive : s.drives) v.segment<3>(3 * drive.node) = drive.motion.velocity(t);
}

void drive(const System& s, State& state) {
  place_driven_nodes(s, state.t, state.q);
  set_driven_velocities(s, state.t, state.v);
}

void driven_accelerations(const System& s, double t, VectorXd& a) {
  a.setZero(3 * s.nodes);
  for (const Drive& drive : s.drives) a.segment<3>(3 * drive.node) = drive.motion.acceleration(t);
}

}  // namespace feder
