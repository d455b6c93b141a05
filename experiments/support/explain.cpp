// What is known of a scene before its first step: counts, rank and gaps of the hard rows, frequencies and
// step limits of the linearised system, admitted routes, the judge. Everything is asked of the code that
// would run.
#include "experiments/support/explain.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "engine/check.h"
#include "engine/fluid/fluid.h"
#include "experiments/support/recommend.h"
#include "solvers/integrators.h"
#include "solvers/linear/pattern.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"
#include "solvers/stability.h"

namespace feder::experiments {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// ---- Counts

void count_nodes(const System& s, Explanation& e) {
  e.unknowns = s.free_count;
  e.bodies = static_cast<int>(s.bodies.size());
  e.driven = static_cast<int>(s.drives.size());
  for (int i = 0; i < s.places() - e.bodies; ++i) ++(s.mass[i] > 0.0 ? e.particles : e.world_points);
  e.world_points -= e.driven;
}

void count_row(const System& s, int row, RowCount& count) {
  const bool hard = std::isinf(s.stiffness[row]);
  ++(hard ? count.hard : s.active(row) ? count.finite : count.inactive);
  count.damped += hard ? s.damping_time[row] > 0.0 : s.damping[row] > 0.0;
}

void count_rows(const System& s, Explanation& e) {
  const auto add = [&](const RowCount& count) {
    if (count.total() == 0) return;
    e.rows.push_back(count);
    e.all_rows.finite += count.finite, e.all_rows.hard += count.hard;
    e.all_rows.inactive += count.inactive, e.all_rows.damped += count.damped;
  };
  RowCount distance{.type = "distance"};
  for (int k = 0; k < s.distance.size(); ++k)
    if (s.distance.public_row[k] >= 0) count_row(s, k, distance);
  add(distance);
  int row = s.distance.size();
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    using Row = typename std::decay_t<decltype(list)>::value_type;
    RowCount count{.type = Row::kName};
    for (std::size_t i = 0; i < Row::kRows * list.size(); ++i) count_row(s, row++, count);
    add(count);
  });
}

void count_nonzeros(const System& s, Explanation& e) {
  double jacobian = 0.0;
  for (const Incidence& i : incidences(s)) {
    const int free = s.free[i.node];
    jacobian += (free & 1) + (free >> 1 & 1) + (free >> 2 & 1);
  }
  e.matrix_nonzeros = s.free_count + s.active_rows + 2.0 * jacobian;
}

// ---- Hard rows

void look_at_hard_rows(const System& s, const State& start, Explanation& e) {
  Kkt kkt;
  kkt.prepare(s);
  kkt.set_step(0.0, 0.0);  // hard rows alone act
  e.gap = e.velocity_gap = e.all_rows.hard > 0 ? kNaN : 0.0;
  if (const Status status = kkt.evaluate(start.q); !status.ok()) {
    e.not_linearised = e.rank_note = status.reason;
    return;
  }
  VectorXd rate;
  kkt.multiply_jacobian(start.v, rate);
  if (e.all_rows.hard > 0) e.gap = e.velocity_gap = 0.0;
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k])) {
      e.gap = std::max(e.gap, std::abs(kkt.phi[k]));
      e.velocity_gap = std::max(e.velocity_gap, std::abs(rate[k]));
    }
  if (e.all_rows.hard > kMostRankRows) {
    e.rank_note = fmt::format("not computed above {} hard rows", kMostRankRows);
    return;
  }
  const RowRank rank = e.all_rows.hard > 0 ? hard_row_rank(kkt) : RowRank{};
  e.rank = rank.rank;
  e.dependent = static_cast<int>(rank.dependent.size());
  e.degrees_of_freedom = s.free_count - rank.rank;
  for (int i = 0; i < std::min(e.dependent, kNamedRows); ++i)
    e.dependent_rows.push_back(s.row_name(rank.dependent[i]));
}

// ---- Time scales

void find_rates(const System& s, const State& start, Explanation& e) {
  double shortest = kInfinity;
  for (const Body& body : s.bodies) {
    if (s.free[body.spin] == kPinned) continue;
    e.turning_rate = std::max(e.turning_rate, start.v.segment<3>(3 * body.spin).norm());
    if (s.mass[body.centre] > 0.0)
      shortest = std::min(shortest, std::sqrt(body.moments.maxCoeff() / s.mass[body.centre]));
  }
  for (int k = 0; k < s.distance.size(); ++k) {
    if (!std::isinf(s.stiffness[k]) || s.distance.public_row[k] < 0) continue;
    const int a = 3 * s.distance.a[k], b = 3 * s.distance.b[k];
    const Vector3d d = start.q.segment<3>(b) - start.q.segment<3>(a);
    const Vector3d w = start.v.segment<3>(b) - start.v.segment<3>(a);
    if (!(d.norm() > 0.0)) continue;
    e.turning_rate = std::max(e.turning_rate, d.cross(w).norm() / d.squaredNorm());
    shortest = std::min(shortest, d.norm());
  }
  // without hard rows a fall is smooth, and what holds against it has a frequency
  if (e.all_rows.hard > 0) e.swing_rate = std::sqrt(s.forces.gravity.norm() / shortest);
}

std::vector<std::string> integrator_names() {
  std::vector<std::string> names;
  for (const IntegratorInfo& integrator : integrator_list()) names.emplace_back(integrator.name);
  return names;
}

StabilityForecast forecast(const System& s, const State& start, Explanation& e) {
  const std::vector<std::string> names = integrator_names();
  if (s.free_count > kMostFrequencyUnknowns) {
    const std::string why = fmt::format("not computed above {} unknowns", kMostFrequencyUnknowns);
    return {{kNaN, kNaN, kNaN, kNaN, why}, std::vector<StabilityLimit>(names.size(), {kNaN, why})};
  }
  const LanczosOptions lanczos = s.free_count <= kMostSharpUnknowns
                                     ? LanczosOptions{.tolerance = 1e-6, .most_restarts = 500}
                                     : LanczosOptions{.tolerance = 1e-3, .most_restarts = 50};
  if (s.free_count > kLargestDenseSize) e.frequency_accuracy = lanczos.tolerance;
  return forecast_stability(s, start, names, lanczos);
}

// Number of steps to the end as `simulate` counts them.
double steps_at(double dt, double end_time) {
  if (std::isinf(dt)) return 1.0;
  return std::ceil(end_time / dt - 1e-9);
}

std::string judge_step(const MethodOutlook& method, double dt) {
  if (dt == 0.0) return "";
  if (!method.refusal.empty()) return "refused";
  if (std::isnan(method.limit)) return "unknown";
  return dt <= method.limit ? "stable" : "unstable";
}

void look_at_methods(const System& s, const std::vector<StabilityLimit>& limits, Explanation& e) {
  for_each_integrator([&]<IntegratorType T>() {
    const StabilityLimit& limit = limits[e.methods.size()];
    MethodOutlook method{.name = T::kInfo.name,
                         .order = T::kInfo.order,
                         .refusal = T::refusal(s),
                         .limit = limit.dt,
                         .why = limit.why,
                         .steps = steps_at(limit.dt, e.end_time),
                         .dt_asked = {}};
    method.dt_asked = judge_step(method, e.dt_asked);
    e.methods.push_back(std::move(method));
  });
}

void look_at_spectrum(const System& s, const State& start, Explanation& e) {
  const StabilityForecast found = forecast(s, start, e);
  e.largest_frequency = found.spectrum.largest_frequency;
  e.smallest_frequency = e.all_rows.hard > 0 ? kNaN : found.spectrum.smallest_frequency;
  e.excited_frequency = found.spectrum.excited_frequency;
  e.largest_damping_rate = found.spectrum.largest_damping_rate;
  e.spectrum_left_out = found.spectrum.left_out;
  e.stiffness_ratio = e.largest_frequency / e.smallest_frequency;
  e.fastest_periods = e.largest_frequency * e.end_time / (2.0 * std::numbers::pi);
  look_at_methods(s, found.limits, e);
}

std::string index_of(const Explanation& e) {
  if (e.all_rows.hard > 0)
    return e.dependent > 0
               ? "3 (hard rows); the index-2 form of Gear, Gupta, Leimkuhler refuses dependent rows"
               : "3 (hard rows); 2 in the form of Gear, Gupta, Leimkuhler";
  const double phase = 2.0 * std::numbers::pi * e.fastest_periods;
  if (e.all_rows.finite == 0 || std::isnan(phase)) return "0 (ordinary differential equation)";
  return fmt::format(
      "0 (ordinary differential equation); the compliance form, index 1, {}: omega_max x end "
      "time = {:.3g} rad, worth it above {:.3g}",
      phase > kLargestOdePhase ? "pays for a judge with error control" : "does not pay", phase,
      kLargestOdePhase);
}

// ---- Routes

// Pairs of rows that meet at a node: what an analysis looks at.
double row_pairs(const System& s) {
  std::vector<double> rows(s.nodes, 0.0);
  for (const Incidence& i : incidences(s)) rows[i.node] += 1.0;
  double pairs = 0.0;
  for (const double n : rows) pairs += n * n;
  return pairs;
}

// Flops of a route, NaN where it refuses.
double analyse(const System& s, const std::string& name, bool geometric, std::string& refusal) {
  LinearSolver solver(name);
  const Status status = solver.analyze(s, geometric);
  refusal = status.reason;
  return status.ok() ? solver.flops() : kNaN;
}

std::string choice(const System& s, bool geometric) {
  LinearSolver solver("auto");
  const Status status = solver.analyze(s, geometric);
  return status.ok() ? solver.choice_reason() : status.reason;
}

void look_at_routes(const System& s, Explanation& e) {
  const double pairs = row_pairs(s);
  e.auto_reason = choice(s, false);
  if (pairs > kMostRoutePairs) {
    e.route_note = fmt::format("not analysed: {:.2g} pairs of rows meet at a node, more than {:.2g}", pairs,
                               kMostRoutePairs);
    e.auto_reason_geometric = e.route_note;
  } else {
    e.auto_reason_geometric = choice(s, true);
  }
  for (const std::string& name : route_names()) {
    RouteOutlook route{
        .name = name, .refusal = {}, .refusal_geometric = {}, .flops = kNaN, .flops_geometric = kNaN};
    if (e.route_note.empty()) {
      route.flops = analyse(s, name, false, route.refusal);
      route.flops_geometric = analyse(s, name, true, route.refusal_geometric);
    }
    e.routes.push_back(std::move(route));
  }
}

// ---- Judge

// The branches of make_reference, with its defaults.
std::string judge_of(const System& s, const State& start, const Explanation& e) {
  const ReferenceOptions defaults;
  const bool small = 2 * s.free_count <= defaults.most_ida_unknowns;
  const std::string size =
      fmt::format("2 x {} unknowns {} {}", s.free_count, small ? "<=" : ">", defaults.most_ida_unknowns);
  const std::string halving = "rk4, steps halved until two runs agree";
  const bool jointed = s.has_hard_rows || e.bodies > 0;
  if (jointed && !small) return halving + ": " + size;
  if (s.has_hard_rows && e.dependent > 0)
    return halving + ": IDA refuses dependent rows (" + e.dependent_rows.front() + ")";
  if (small) {
    const IdaForm form = choose_ida_form(s, start, e.end_time);
    return fmt::format("IDA at two tolerances, {} form: {}",
                       form == IdaForm::kGgl   ? "ggl (index 2)"
                       : form == IdaForm::kOde ? "ode"
                                               : "compliance (index 1)",
                       size);
  }
  const bool symplectic = !s.has_damping && !s.forces.has_drag && !s.forces.user && s.law_springs.empty() &&
                          !(s.fluid && s.fluid->dissipates());
  return fmt::format("{} at dt and dt/2: {}", symplectic ? "leapfrog" : "rk4", size);
}

}  // namespace

Explanation explain(const Model& model, double dt) {
  require_non_negative("explain", "dt", dt, "s");
  const System& s = model.system;
  State start = model.state;
  drive(s, start);
  Explanation e;
  e.scene = model.name, e.end_time = model.end_time, e.scene_length = model.scene_length, e.dt_asked = dt;
  count_nodes(s, e);
  count_rows(s, e);
  count_nonzeros(s, e);
  look_at_hard_rows(s, start, e);
  find_rates(s, start, e);
  look_at_spectrum(s, start, e);
  e.index = index_of(e);
  look_at_routes(s, e);
  e.judge = judge_of(s, start, e);
  e.recommended = recommend(e, s);
  return e;
}

}  // namespace feder::experiments
