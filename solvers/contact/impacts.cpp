// Several impacts at once. With y the impulse that stops the approaching contacts, u_c = u + W y, and p = (1
// + e) y:
//   dE = p.u + 1/2 p.W p,  y.u = y.u_c - y.W y
//      = (1 + e) (y.u_c - y.W y + (1 + e)/2 y.W y) = (1 + e) (y.u_c - (1 - e)/2 y.W y) <= 0
// for y.u_c = y_t.u_ct <= 0: friction opposes the slip it leaves.
#include "solvers/contact/impacts.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace feder {
namespace {

// Contacts that approach slower than this share of the first impact's speed are at rest.
constexpr double kAtRest = 1e-9;
// Violation of the law accepted in later rounds, as a share of that speed.
constexpr double kFloor = 1e-12;
// Rounds of rebounds; then one without rebound ends what still approaches.
constexpr int kMostRounds = 50;

// Rows of W and u that belong to some contacts only.
ContactProblem restricted(const Eigen::MatrixXd& W, const VectorXd& u, const ContactRows& rows,
                          const std::vector<int>& some) {
  const int k = static_cast<int>(some.size());
  ContactProblem p{Eigen::MatrixXd(3 * k, 3 * k), VectorXd(3 * k), VectorXd(k)};
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j < k; ++j) p.W.block<3, 3>(3 * i, 3 * j) = W.block<3, 3>(3 * some[i], 3 * some[j]);
    p.b.segment<3>(3 * i) = u.segment<3>(3 * some[i]);
    p.friction[i] = rows.contacts[some[i]].surface.friction;
  }
  return p;
}

// Impulse of contacts that approach together.
VectorXd together(const ContactProblem& p, const ContactRows& rows, const std::vector<int>& some,
                  bool rebound, double floor, Status& status) {
  VectorXd y = VectorXd::Zero(p.b.size());
  status = solve_contacts(p, {.floor = floor}, y).status;
  if (!rebound) return y;
  VectorXd back = y;
  for (std::size_t i = 0; i < some.size(); ++i)
    back.segment<3>(3 * static_cast<int>(i)) *= rows.contacts[some[i]].surface.restitution;
  const auto gain = [&](double share) {
    const VectorXd q = y + share * back;
    return q.dot(p.b) + 0.5 * q.dot(p.W * q);
  };
  double share = 1.0;
  while (share > 0.0 && gain(share) > 0.0) share = share > 1e-3 ? 0.5 * share : 0.0;
  return y + share * back;
}

}  // namespace

ImpactOutcome resolve_impacts(const ContactRows& rows, const Response& respond, ImpactRule rule,
                              VectorXd& v) {
  ImpactOutcome out;
  const int k = rows.count();
  out.impulse.setZero(3 * k);
  if (k == 0) return out;
  Eigen::MatrixXd responses, W;
  delassus_matrix(rows, respond, v.size(), responses, W);
  VectorXd start;
  rows.velocities(v, start);
  VectorXd u = start;
  bool elastic = false;
  for (const Contact& c : rows.contacts) elastic = elastic || c.surface.restitution > 0.0;
  double speed = 0.0;
  for (int i = 0; i < k; ++i) speed = std::max(speed, -u[3 * i]);

  for (;; ++out.rounds) {
    std::vector<int> approaching;
    for (int i = 0; i < k; ++i)
      if (u[3 * i] < -kAtRest * speed) approaching.push_back(i);
    if (approaching.empty() || out.rounds > kMostRounds) break;
    const bool rebound = out.rounds < kMostRounds && (elastic || k == 1);
    if (!rebound) {  // all of them, and nothing approaches any more
      approaching.resize(static_cast<std::size_t>(k));
      for (int i = 0; i < k; ++i) approaching[static_cast<std::size_t>(i)] = i;
    }
    const ContactProblem p = restricted(W, u, rows, approaching);
    VectorXd y;
    if (approaching.size() == 1 && rebound) {
      const Surface& surface = rows.contacts[approaching[0]].surface;
      const ImpactResult one =
          resolve_impact(p.W, p.b, surface.friction, surface.restitution,
                         rule == ImpactRule::kNewton && surface.friction > 0.0 ? ImpactRule::kNaive : rule);
      y = one.impulse;
      out.jammed = out.jammed || one.jammed;
      if (one.status != StatusCode::kOk)
        out.status = Status::failure(one.status, "the impact of a contact has no impulse by its rule");
    } else {
      y = together(p, rows, approaching, rebound, kFloor * speed, out.status);
    }
    if (!out.status.ok()) return out;
    for (std::size_t i = 0; i < approaching.size(); ++i) {
      const Vector3d yi = y.segment<3>(3 * static_cast<int>(i));
      out.impulse.segment<3>(3 * approaching[i]) += yi;
      u += W.middleCols<3>(3 * approaching[i]) * yi;
    }
  }
  out.energy_change = 0.5 * out.impulse.dot(start + u);
  v += responses * out.impulse;
  return out;
}

ImpactResponse::ImpactResponse(const System& system) : system_(&system) {
  if (!system.has_hard_rows) return;
  kkt_.prepare(system);
  kkt_.set_step(0.0, 0.0);  // only hard rows act
}

Status ImpactResponse::at(const VectorXd& q) {
  if (!system_->has_hard_rows) return {};
  if (!analyzed_)
    if (Status status = solver_.analyze(*system_, false); !status.ok()) return status;
  analyzed_ = true;
  if (Status status = kkt_.evaluate(q, false); !status.ok()) return status;
  return solver_.factor(kkt_);
}

void ImpactResponse::operator()(const VectorXd& force, VectorXd& v) {
  if (system_->has_hard_rows)
    solver_.respond(kkt_, force, v);
  else
    v = system_->inverse_mass.cwiseProduct(force);
}

}  // namespace feder
