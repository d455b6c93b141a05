// Contacts over the factor of a step. W = J A^-1 J^T by one solve per row of J; the factor belongs to the
// system's own rows and is not touched by contacts coming and going. Work: M(v' - v) = ... + J^T y, times v'.
#include "solvers/contact/contact_step.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace feder {
namespace {

// Penetration that is left alone: rounding of places the size of a shape.
constexpr double kSlop = 1e-12;

}  // namespace

void ContactStep::set_targets(double dt, const State& state) {
  VectorXd u;
  rows_.velocities(state.v, u);
  target_.resize(rows_.count());
  for (int i = 0; i < rows_.count(); ++i) {
    const Contact& contact = rows_.contacts[i];
    const double gap = contact.at.gap, approach = u[3 * i];
    counts_.deepest = std::max(counts_.deepest, -gap);
    target_[i] = gap > 0.0 ? -gap / dt : 0.0;
    if (contact.surface.restitution > 0.0 && approach < -threshold && gap + dt * approach < 0.0)
      target_[i] = -contact.surface.restitution * approach;
  }
}

// Impulses of the last step for those contacts that are still there.
void ContactStep::start_from(const History& history) {
  std::map<std::tuple<int, int, std::uint32_t>, Vector3d> last;
  for (int i = 0; i + 6 <= history.contacts.size(); i += 6)
    last[{static_cast<int>(history.contacts[i]), static_cast<int>(history.contacts[i + 1]),
          static_cast<std::uint32_t>(history.contacts[i + 2])}] = history.contacts.segment<3>(i + 3);
  impulse_.setZero(3 * rows_.count());
  for (int i = 0; i < rows_.count(); ++i)
    if (const auto found = last.find(rows_.contacts[i].key()); found != last.end())
      impulse_.segment<3>(3 * i) = rows_.contacts[i].frame * found->second;
}

void ContactStep::remember(History& history) const {
  std::vector<double> kept;
  for (int i = 0; i < rows_.count(); ++i) {
    const Contact& contact = rows_.contacts[i];
    if (!(impulse_[3 * i] > 0.0)) continue;
    const Vector3d impulse = contact.frame.transpose() * impulse_.segment<3>(3 * i);
    kept.insert(kept.end(), {static_cast<double>(contact.a), static_cast<double>(contact.b),
                             static_cast<double>(contact.at.feature), impulse.x(), impulse.y(), impulse.z()});
  }
  history.contacts = Eigen::Map<const VectorXd>(kept.data(), static_cast<Eigen::Index>(kept.size()));
}

double ContactStep::work(const VectorXd& v) const {
  if (rows_.count() == 0) return 0.0;
  VectorXd u;
  rows_.multiply(v, u);
  return impulse_.dot(u);
}

Status ContactStep::solve(double dt, const State& state, const History& history, Kkt& kkt,
                          LinearSolver& solver, VectorXd& v, VectorXd& y, SolveReport& report) {
  pushed_ = false;
  finder_.find(state, dt, rows_);
  if (Status status = solver.factor(kkt); !status.ok()) return status;
  report = solver.solve(kkt, v, y);
  const int k = rows_.count();
  impulse_.setZero(3 * k);
  if (!report.status.ok() || k == 0) return report.status;
  ++counts_.steps;
  counts_.contacts += k;

  // W column by column, b = J v* less the target
  set_targets(dt, state);
  responses_.resize(v.size(), 3 * k);
  problem_.W.resize(3 * k, 3 * k);
  VectorXd unit = VectorXd::Zero(3 * k);
  for (int i = 0; i < 3 * k; ++i) {
    force_.setZero(v.size());
    unit[i] = 1.0;
    rows_.add_impulses(unit, force_);
    unit[i] = 0.0;
    solver.respond(kkt, force_, column_);
    responses_.col(i) = column_;
    rows_.multiply(column_, velocity_);
    problem_.W.col(i) = velocity_;
  }
  problem_.W = (0.5 * (problem_.W + problem_.W.transpose())).eval();
  rows_.velocities(v, problem_.b);
  problem_.friction.resize(k);
  for (int i = 0; i < k; ++i) {
    problem_.b[3 * i] -= target_[i];
    problem_.friction[i] = rows_.contacts[i].surface.friction;
  }
  start_from(history);
  const ContactReport law = solve_contacts(problem_, options_, impulse_);
  counts_.newton_iterations += law.newton_iterations;
  counts_.sweeps += law.sweeps;
  if (!law.status.ok()) return law.status;
  const double size = problem_.b.lpNorm<Eigen::Infinity>();
  if (size > 0.0) counts_.violation = std::max(counts_.violation, law.violation / size);

  // the step itself, certified
  rows_.add_impulses(impulse_, kkt.p);
  report = solver.solve(kkt, v, y);
  return report.status.ok() ? push_out(dt, v) : report.status;
}

// Frictionless impulses on places alone: gap + dt u_n + dt (W pi)_n >= 0 where something penetrates.
Status ContactStep::push_out(double dt, const VectorXd& v) {
  rows_.velocities(v, velocity_);
  ContactProblem places{problem_.W, VectorXd::Zero(3 * rows_.count()), VectorXd::Zero(rows_.count())};
  for (int i = 0; i < rows_.count(); ++i) {
    const Contact& contact = rows_.contacts[i];
    const double size = contact.at.point.lpNorm<Eigen::Infinity>();
    pushed_ = pushed_ || contact.at.gap + dt * velocity_[3 * i] < -kSlop * (1.0 + size);
    places.b[3 * i] = contact.at.gap / dt + velocity_[3 * i];
  }
  if (!pushed_) return {};
  ++counts_.corrections;
  VectorXd pi = VectorXd::Zero(3 * rows_.count());
  const ContactReport law = solve_contacts(places, options_, pi);
  counts_.newton_iterations += law.newton_iterations;
  counts_.sweeps += law.sweeps;
  place_velocity_ = v + responses_ * pi;
  return law.status;
}

}  // namespace feder
