// Contacts over the factor of a step. W = J A^-1 J^T by one solve per row of J; the factor belongs to the
// system's own rows and is not touched by contacts coming and going. Work: M(v' - v) = ... + J^T y, times v'.
#include "solvers/contact/contact_step.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "solvers/contact/delassus.h"
#include "solvers/stopwatch.h"

namespace feder {
namespace {

// Penetration that is left alone: rounding of places the size of a shape.
constexpr double kSlop = 1e-12;
// Of particles on obstacles: passes over one step; a pass that gains less than this asks for a new factor.
constexpr int kMostPasses = 100;
constexpr double kContraction = 0.5;

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
void ContactStep::start_from(double dt, const History& history) {
  const double scale = history.last_dt > 0.0 ? dt / history.last_dt : 1.0;
  std::map<std::tuple<int, int, std::uint32_t>, Vector3d> last;
  for (int i = 0; i + 6 <= history.contacts.size(); i += 6)
    last[{static_cast<int>(history.contacts[i]), static_cast<int>(history.contacts[i + 1]),
          static_cast<std::uint32_t>(history.contacts[i + 2])}] = history.contacts.segment<3>(i + 3);
  impulse_.setZero(3 * rows_.count());
  for (int i = 0; i < rows_.count(); ++i)
    if (const auto found = last.find(rows_.contacts[i].key()); found != last.end())
      impulse_.segment<3>(3 * i) = scale * (rows_.contacts[i].frame * found->second);
  free_impulse_.resize(3 * static_cast<Eigen::Index>(free_.size()));
  for (std::size_t i = 0; i < free_.size(); ++i)
    free_impulse_.segment<3>(3 * static_cast<int>(i)) = impulse_.segment<3>(3 * free_[i]);
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

// The contact law of those that act through W, on top of v = A^-1 [p; r]; their impulses join p.
Status ContactStep::solve_free(Kkt& kkt, LinearSolver& solver, bool factored, VectorXd& v, VectorXd& y,
                               SolveReport& report) {
  const int k = free_rows_.count();
  if (k == 0) return {};
  if (factored)
    delassus_matrix(
        free_rows_, [&](const VectorXd& force, VectorXd& answer) { solver.respond(kkt, force, answer); },
        v.size(), responses_, problem_.W);
  free_rows_.velocities(v, problem_.b);
  problem_.friction.resize(k);
  for (int i = 0; i < k; ++i) {
    problem_.b[3 * i] -= target_[free_[i]];
    problem_.friction[i] = free_rows_.contacts[i].surface.friction;
  }
  const ContactReport law = solve_contacts(problem_, options_, free_impulse_);
  counts_.newton_iterations += law.newton_iterations;
  counts_.sweeps += law.sweeps;
  if (!law.status.ok()) return law.status;
  const double size = problem_.b.lpNorm<Eigen::Infinity>();
  if (size > 0.0) counts_.violation = std::max(counts_.violation, law.violation / size);
  free_rows_.add_impulses(free_impulse_, kkt.p);
  report = solver.solve(kkt, v, y);  // certified
  return report.status;
}

Status ContactStep::solve(double dt, const State& state, const History& history, Kkt& kkt,
                          LinearSolver& solver, VectorXd& v, VectorXd& y, SolveReport& report) {
  pushed_ = false;
  p_ = kkt.p;
  {
    const Stopwatch watch(counts_.seconds_find);
    finder_.find(state, dt, rows_);
    held_.take(*system_, rows_, free_);
    free_rows_ = rows_.subset(free_);
    set_targets(dt, state);
    start_from(dt, history);
  }
  const int k = rows_.count();
  counts_.steps += k > 0;
  counts_.contacts += k;
  if (!held_.empty() || held_.used()) {
    const Stopwatch watch(counts_.seconds_solve);
    held_.start(dt, kkt, rows_, target_, impulse_, state.v);
    held_.put_into(kkt, rows_);
    held_.add_right_hand_side(rows_, kkt.p);
  }
  {
    const Stopwatch watch(counts_.seconds_own);
    if (Status status = solver.factor(kkt); !status.ok()) return status;
    report = solver.solve(kkt, v, y);
  }
  if (!report.status.ok() || k == 0) return report.status;

  const Stopwatch watch(counts_.seconds_solve);
  bool factored = true;
  double before = HUGE_VAL;
  for (int pass = 0;; ++pass) {
    if (Status status = solve_free(kkt, solver, factored, v, y, report); !status.ok()) return status;
    if (held_.empty()) break;
    const int left = held_.update(rows_, v);
    const double scale = std::max(v.lpNorm<Eigen::Infinity>(), state.v.lpNorm<Eigen::Infinity>());
    if (held_.violation() <= options_.held_tolerance * scale) {
      counts_.violation = std::max(counts_.violation, scale > 0.0 ? held_.violation() / scale : 0.0);
      break;
    }
    if (pass == kMostPasses)
      return Status::failure(StatusCode::kNotConverged,
                             "particles on obstacles leave the contact law open by " +
                                 std::to_string(held_.violation()) + " m/s after " + std::to_string(pass) +
                                 " passes");
    // the same factor serves until a contact changes its branch or slips turn too far
    factored = left > 0 || held_.violation() > kContraction * before;
    before = held_.violation();
    if (factored) held_.put_into(kkt, rows_);
    kkt.p = p_;
    held_.add_right_hand_side(rows_, kkt.p);
    if (factored) {
      ++counts_.factorizations;
      if (Status status = solver.factor(kkt); !status.ok()) return status;
    }
    ++counts_.passes;
    report = solver.solve(kkt, v, y);
    if (!report.status.ok()) return report.status;
  }
  held_.impulses(impulse_);
  for (std::size_t i = 0; i < free_.size(); ++i)
    impulse_.segment<3>(3 * free_[i]) = free_impulse_.segment<3>(3 * static_cast<int>(i));
  return push_out(dt, v);
}

// What penetrates: particles held by obstacles are set onto them; the others take frictionless impulses on
// places alone, gap + dt u_n + dt (W pi)_n >= 0.
Status ContactStep::push_out(double dt, const VectorXd& v) {
  rows_.velocities(v, velocity_);
  const auto open = [&](int i) { return rows_.contacts[i].at.gap / dt + velocity_[3 * i]; };
  const auto penetrates = [&](int i) {
    return dt * open(i) < -kSlop * (1.0 + rows_.contacts[i].at.point.lpNorm<Eigen::Infinity>());
  };
  bool free = false;
  for (int i : free_) free = free || penetrates(i);
  for (int i : held_.taken()) pushed_ = pushed_ || penetrates(i);
  pushed_ = pushed_ || free;
  if (!pushed_) return {};
  ++counts_.corrections;
  place_velocity_ = v;
  for (int i : held_.taken()) {
    if (!penetrates(i)) continue;
    const ContactRows::Block& block = rows_.blocks[rows_.contacts[i].first_block];
    place_velocity_.segment<3>(3 * block.node) -= open(i) * block.J.row(0).transpose();
  }
  if (!free) return {};
  ContactProblem places{problem_.W, VectorXd::Zero(problem_.b.size()), VectorXd::Zero(problem_.count())};
  for (int i = 0; i < places.count(); ++i) places.b[3 * i] = open(free_[i]);
  VectorXd pi = VectorXd::Zero(places.b.size());
  const ContactReport law = solve_contacts(places, options_, pi);
  counts_.newton_iterations += law.newton_iterations;
  counts_.sweeps += law.sweeps;
  place_velocity_ += responses_ * pi;
  return law.status;
}

}  // namespace feder
