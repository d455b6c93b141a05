// x_i = i rest_length + sum_j A_j(t) sin(i j pi / (n + 1)), each mode on its own (notes E1, E5 and E6):
//   A_j'' + (drag / mass + tau omega_j^2) A_j' + omega_j^2 A_j = 0,  omega_j = 2 sqrt(d / m) sin(j pi / (2 (n
//   + 1)))
// Neighbours differ by at most sum_j 2 |A_j| sin(j pi / (2 (n + 1))), which must stay below the rest length.
#include "models/chain.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"
#include "models/linear_motion.h"
#include "models/parameters.h"

namespace feder {
namespace {

constexpr const char* kPlace = "model chain";
constexpr FreeMask kAlongX = 1;

const Fields<Chain>& fields() {
  static const Fields<Chain> list = {
      field("n", &Chain::n, "masses", count_from(1)),
      field("mass", &Chain::mass, "kg", "of each node", kPositive),
      field("stiffness", &Chain::stiffness, "N/m", "of each of the n + 1 springs", kPositive),
      field("rest_length", &Chain::rest_length, "m", "of each spring", kPositive),
      field("modes", &Chain::modes, "initial displacement as modes and amplitudes"),
      field("damping_time", &Chain::damping_time, "s", "row damping tau", kNonNegative),
      field("drag", &Chain::drag, "kg/s", "linear drag of each node", kNonNegative),
  };
  return list;
}

State state_at(const Chain& o, double t) {
  State s{t, VectorXd::Zero(3 * (o.n + 2)), VectorXd::Zero(3 * (o.n + 2))};
  for (int i = 0; i <= o.n + 1; ++i) s.q[3 * i] = i * o.rest_length;
  for (const Mode& mode : o.modes) {
    const int j = mode_index(kPlace, mode, o.n);
    const double omega = chain_frequency(o, j);
    const double decay = 0.5 * (o.drag / o.mass + o.damping_time * omega * omega);
    const LinearMotion motion = linear_motion(omega, decay, {mode.amplitude, 0.0}, t);
    for (int i = 1; i <= o.n; ++i) {
      s.q[3 * i] += motion.x * mode_shape(o.n, j, i);
      s.v[3 * i] += motion.v * mode_shape(o.n, j, i);
    }
  }
  return s;
}

// Throws if two nodes could meet; returns the lowest frequency in the motion, or of the chain if it stands
// still.
double check_modes(const Chain& o) {
  double approach = 0.0, lowest = 0.0;
  for (const Mode& mode : o.modes) {
    const int j = mode_index(kPlace, mode, o.n);
    approach += 2.0 * std::abs(mode.amplitude) * std::sin(j * std::numbers::pi / (2.0 * (o.n + 1)));
    if (const double omega = chain_frequency(o, j); lowest == 0.0 || omega < lowest) lowest = omega;
  }
  if (!(approach < o.rest_length))
    fail_input(kPlace, "largest shortening of a spring by these modes", approach, "m",
               "less than the rest length " + to_text(o.rest_length));
  return lowest > 0.0 ? lowest : chain_frequency(o, 1);
}

}  // namespace

double chain_frequency(const Chain& o, int j) {
  return mode_frequency(o.n, j, o.stiffness, o.mass);
}

Model make_chain(const Chain& o) {
  check_fields(kPlace, fields(), o);
  const double lowest = check_modes(o);
  const State start = state_at(o, 0.0);

  SystemBuilder builder;
  Anchor last = builder.add_world_point(start.q.head<3>());
  for (int i = 1; i <= o.n + 1; ++i) {
    const Vector3d position = start.q.segment<3>(3 * i);
    const Anchor next = i <= o.n ? builder.add_particle(o.mass, position, Vector3d::Zero(), kAlongX)
                                 : builder.add_world_point(position);
    builder.add_distance(last, next, {o.stiffness, o.damping_time}, o.rest_length);
    last = next;
  }
  builder.set_drag(o.drag);
  auto [system, state] = builder.build();

  Model model{"chain", std::move(system), std::move(state)};
  model.end_time = 2.0 * 2.0 * std::numbers::pi / lowest;
  model.scene_length = (o.n + 1) * o.rest_length;
  model.exact = [o](double t) { return state_at(o, t); };
  if (o.damping_time == 0.0 && o.drag == 0.0) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo chain_model() {
  return describe("chain", "n masses between two fixed points, moving along their line; exact modes",
                  fields(), make_chain);
}

}  // namespace feder
