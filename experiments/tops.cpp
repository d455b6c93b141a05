// What does an integrator do to a spinning body? A torque-free box about its middle axis flips over and over
// (notes C2, B6, B7). With principal moments I1 < I2 < I3, L^2 = |I w|^2 and E its energy, w2 is a Jacobi sn
// of the time:
//   L^2 > 2 E I2:  rate^2 = (I3 - I2)(L^2 - 2 E I1)/(I1 I2 I3),  k^2 = (I2 - I1)(2 E I3 - L^2)/((I3 - I2)(L^2
//   - 2 E I1)) (1 and 3 exchanged otherwise), and from one flip to the next it takes 2 K(k)/rate.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>

#include "engine/energy.h"
#include "experiments/support/experiment.h"
#include "experiments/support/timing.h"
#include "models/asymmetric_top.h"
#include "models/elliptic.h"
#include "solvers/simulate.h"

namespace feder::experiments {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kMiddle = 1;  // the box's y axis has the middle moment

// ---- The exact time between two flips

double exact_flip_time(const System& s, const State& start) {
  const Body& b = s.bodies[0];
  Vector3d I = b.moments;
  const Vector3d w = start.v.segment<3>(3 * b.spin);
  std::sort(I.begin(), I.end());
  const double twice_energy = 2.0 * kinetic_energy(s, start),
               momentum2 = b.moments.cwiseProduct(w).squaredNorm();
  if (momentum2 < twice_energy * I[1]) std::swap(I[0], I[2]);
  const double a = (I[2] - I[1]) * (momentum2 - twice_energy * I[0]),
               c = (I[1] - I[0]) * (twice_energy * I[2] - momentum2);
  const double rate = std::sqrt(a / (I[0] * I[1] * I[2])), k2 = c / a;
  return 2.0 * elliptic_k({std::sqrt(k2), std::sqrt(1.0 - k2)}) / rate;
}

// ---- One run

// Times at which the middle spin changes its sign, by cubic interpolation through both ends and their slopes.
class FlipWatch {
 public:
  void look(double t, double w, double slope) {
    if (seen_ && (w > 0.0) != (w_ > 0.0)) {
      double low = 0.0, high = 1.0;
      const double h = t - t_;
      const auto at = [&](double x) {
        return (1.0 + 2.0 * x) * (1.0 - x) * (1.0 - x) * w_ + x * (1.0 - x) * (1.0 - x) * h * slope_ +
               x * x * (3.0 - 2.0 * x) * w - x * x * (1.0 - x) * h * slope;
      };
      for (int i = 0; i < 60; ++i) {
        const double middle = 0.5 * (low + high);
        ((at(middle) > 0.0) == (w_ > 0.0) ? low : high) = middle;
      }
      flips_.push_back(t_ + h * low);
    }
    t_ = t, w_ = w, slope_ = slope, seen_ = true;
  }
  /// Mean time between flips [s]; NaN for fewer than two.
  double mean() const {
    return flips_.size() < 2 ? kNaN
                             : (flips_.back() - flips_.front()) / static_cast<double>(flips_.size() - 1);
  }

 private:
  bool seen_ = false;
  double t_ = 0.0, w_ = 0.0, slope_ = 0.0;
  std::vector<double> flips_;
};

double middle_slope(const Body& b, const Vector3d& w) {
  return -w.cross(b.moments.cwiseProduct(w))[kMiddle] / b.moments[kMiddle];
}

struct Outcome {
  Status status;
  std::int64_t steps = 0;
  double momentum = kNaN, energy = kNaN, energy_gain = 0.0, flip_time = kNaN, seconds = 0.0;
};

struct Method {
  std::string integrator;
  RotationUpdate update;
  std::string label() const {
    return update == RotationUpdate::kNormalisedEuler ? integrator + ", normalised Euler" : integrator;
  }
};

Outcome run_method(const Model& model, const Method& method, double dt) {
  const System& s = model.system;
  const Body& b = s.bodies[0];
  Integrator integrator = make_integrator(method.integrator, s, {.rotation_update = method.update});
  State state = model.state;
  History history;
  Outcome out;
  FlipWatch flips;
  const Vector3d L = angular_momentum(s, state);
  const double E = kinetic_energy(s, state);
  const auto observe = [&](const State& at, const History&) {
    const Vector3d w = at.v.segment<3>(3 * b.spin);
    flips.look(at.t, w[kMiddle], middle_slope(b, w));
    out.energy_gain = std::max(out.energy_gain, kinetic_energy(s, at) / E - 1.0);
    return true;
  };
  const RunResult run =
      simulate(s, integrator, state, history, {.dt = dt, .end_time = model.end_time, .observer = observe});
  out.status = run.status;
  out.steps = run.steps;
  out.seconds = run.seconds;
  out.momentum = (angular_momentum(s, state) - L).norm() / L.norm();
  out.energy = std::abs(kinetic_energy(s, state) / E - 1.0);
  out.flip_time = flips.mean();
  return out;
}

// The failing twin of notes B6: R += dt R [w]x leaves the rotations; its columns grow and so does R I w.
Outcome run_rotation_matrix(const Model& model, double dt) {
  const Body& b = model.system.bodies[0];
  Vector3d w = model.state.v.segment<3>(3 * b.spin);
  Matrix3d R = rotation_matrix(model.state.q.data() + b.quaternion);
  const Vector3d L = R * b.moments.cwiseProduct(w);
  const double E = w.dot(b.moments.cwiseProduct(w));
  Outcome out;
  FlipWatch flips;
  out.steps = step_count(0.0, model.end_time, dt);
  for (std::int64_t n = 0; n < out.steps; ++n) {
    R += dt * R * skew(w);
    w -= dt * w.cross(b.moments.cwiseProduct(w)).cwiseQuotient(b.moments);
    flips.look(static_cast<double>(n + 1) * dt, w[kMiddle], middle_slope(b, w));
    out.energy_gain = std::max(out.energy_gain, w.dot(b.moments.cwiseProduct(w)) / E - 1.0);
  }
  out.momentum = (R * b.moments.cwiseProduct(w) - L).norm() / L.norm();
  out.energy = std::abs(w.dot(b.moments.cwiseProduct(w)) / E - 1.0);
  out.flip_time = flips.mean();
  if (!std::isfinite(out.momentum))
    out.status = Status::failure(StatusCode::kNonFinite, "the rotation matrix is not finite");
  return out;
}

// ---- The experiment

Cell if_finite(double x) {
  return std::isfinite(x) ? Cell(x) : Cell();
}

Chart make_chart(const Table& table) {
  Chart chart{.name = "tops",
              .title = "A free box spinning about its middle axis",
              .caption = "Errors after the run, relative, against the time step; crosses are failed runs.",
              .grid_columns = 3};
  constexpr std::pair<const char*, const char*> kColumns[] = {{"angular momentum", "momentum_drift"},
                                                              {"energy", "energy_drift"},
                                                              {"time between flips", "flip_error"}};
  const std::vector<std::string> methods = table.distinct("method");
  for (const auto& [title, column] : kColumns) {
    Panel panel{.title = title,
                .x = {.label = "time step dt [s]", .log = true},
                .y = {.label = "relative error", .log = true, .min = 1e-16, .max = 10.0}};
    for (std::size_t look = 0; look < methods.size(); ++look)
      for (Series& series : series_by(table, "method", "dt", column, [&, column = column](std::size_t row) {
             return table.at(row, "method").text() == methods[look] &&
                    (table.at(row, column).number() > 0.0 || table.at(row, column).empty());
           })) {
        series.look = look;
        panel.series.push_back(std::move(series));
      }
    chart.panels.push_back(std::move(panel));
  }
  return chart;
}

void body(Context& context) {
  AsymmetricTop options;
  options.speed = context.settings.number("speed");
  Model model = make_asymmetric_top(options);
  model.end_time = context.settings.number("end_time");
  const double exact = exact_flip_time(model.system, model.state);
  std::vector<Method> methods;
  for (const IntegratorInfo& info : integrator_list())
    methods.push_back({info.name, RotationUpdate::kExponential});
  methods.push_back({"implicit_euler_notes", RotationUpdate::kNormalisedEuler});

  const std::vector<double> steps = context.settings.numbers("dt");
  context.progress.start(static_cast<long>(steps.size() * (methods.size() + 1)));
  double best_rk4 = kNaN;
  const auto add = [&](const std::string& label, const Method& method, double dt, const Outcome& out) {
    const double flip_error = std::abs(out.flip_time / exact - 1.0);
    context.table.add({{"scene", model.name},
                       {"method", label},
                       {"integrator", method.integrator},
                       {"dt", dt},
                       {"status", to_string(out.status.code)},
                       {"reason", out.status.reason},
                       {"steps", out.steps},
                       {"momentum_drift", if_finite(out.momentum)},
                       {"energy_drift", if_finite(out.energy)},
                       {"energy_gain", if_finite(out.energy_gain)},
                       {"flip_time", if_finite(out.flip_time)},
                       {"flip_time_exact", exact},
                       {"flip_error", if_finite(flip_error)},
                       {"seconds", out.seconds}});
    if (label == "rk4" && !(best_rk4 <= flip_error)) best_rk4 = flip_error;
    context.progress.advance(fmt::format("{} {:.3g}", label, dt));
  };
  for (const double dt : steps) {
    for (const Method& method : methods) {
      if (context.interrupted()) return;
      add(method.label(), method, dt, run_method(model, method, dt));
    }
    add("rotation matrix, explicit Euler", {"none", RotationUpdate::kExponential}, dt,
        run_rotation_matrix(model, dt));
  }
  context.add_chart(make_chart(context.table));
  context.note(
      fmt::format("It flips every {:.6f} s; rk4 misses that by {:.1e} of it at best.", exact, best_rk4));
  double gain = 0.0;
  for (std::size_t row = 0; row < context.table.rows(); ++row)
    if (context.table.at(row, "integrator").text().starts_with("implicit") &&
        context.table.at(row, "status").text() == "ok")
      gain = std::max(gain, context.table.at(row, "energy_gain").number());
  context.note(fmt::format("Largest energy gain of any implicit run: {:.1e} of the energy.", gain));
}

ExperimentInfo about() {
  return {.name = "tops",
          .question = "What does each integrator do to the momentum, energy and flips of a spinning body?",
          .not_modelled = "Torques, joints and flexible parts.",
          .settings = {{"dt", Kind::kNumbers, "1e-3:1e-1:5", "1e-4:1e-1:13", "time steps, s"},
                       {"speed", Kind::kNumber, "10", "10", "of the rotation, rad/s"},
                       {"end_time", Kind::kNumber, "20", "100", "length of a run, s"}},
          .columns = {"scene", "method", "integrator", "dt", "status", "reason", "steps", "momentum_drift",
                      "energy_drift", "energy_gain", "flip_time", "flip_time_exact", "flip_error", "seconds"},
          .cases = {"asymmetric_top"}};
}

}  // namespace
}  // namespace feder::experiments

int main(int argc, char** argv) {
  return feder::experiments::run_experiment(feder::experiments::about(), argc, argv,
                                            feder::experiments::body);
}
