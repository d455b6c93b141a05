// The impulse path of one contact (Routh 1891, Darboux, Keller): u = u_0 + W p with
//   dp = (1, -mu s/|s|) dp_n while it slides, s = u_t;  dp = (1, -W_tt^-1 W_tn) dp_n while it sticks.
// A slip that stops sticks if norm(W_tt^-1 W_tn) <= mu. Otherwise it sets off along the only direction d with
//   W_tn - mu W_tt d = x d, x > 0,  that is norm((mu W_tt + x)^-1 W_tn) = 1  (one root: the norm falls with
//   x),
// and keeps it: Bhatt and Koechling 1995, Batlle 1996. Either way the last phase is straight. The end: bodies
// separate and work in restitution = -e^2 work in compression (Stronge 1990), or p_n = (1 + e) p_n at the end
// of compression (Poisson). If bodies separate and approach again, both count all compression so far.
#include "solvers/contact/impact_path.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/contact/slip_series.h"

namespace feder {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRounding = 1e-15;
constexpr double kClosed = 1e-14;  // below this fraction of tr W a direction does not move

// Where f, of opposite signs at the ends, changes sign; the result lies on the side of `high`. Secants whose
// kept end counts half (Illinois), and halving where they leave the bracket.
template <class Function>
double crossing(const Function& f, double low, double high) {
  double at_low = f(low), at_high = f(high);
  const double smallest = kRounding * kRounding * high;
  const bool positive = at_high > 0.0;
  for (int kept = 0; high - low > std::max(smallest, 0.1 * kRounding * high);) {
    double x = (low * at_high - high * at_low) / (at_high - at_low);
    if (!(low < x && x < high)) x = 0.5 * (low + high);
    if (!(low < x && x < high)) break;
    const double value = f(x);
    if ((value > 0.0) == positive) {
      high = x, at_high = value;
      if (kept == 1) at_low *= 0.5;
      kept = 1;
    } else {
      low = x, at_low = value;
      if (kept == -1) at_high *= 0.5;
      kept = -1;
    }
  }
  return high;
}

double cross(const Vector2d& a, const Vector2d& b) {
  return a[0] * b[1] - a[1] * b[0];
}

class ImpactPath {
 public:
  ImpactPath(const Matrix3d& W, const Vector3d& u, double friction, double restitution, ImpactRule rule)
      : flow_(W, friction),
        friction_(friction),
        restitution_(restitution),
        rule_(rule),
        u_(u),
        smallest_speed_(kRounding * u.norm()) {}

  ImpactResult follow() {
    if (!slide()) leave_rest();
    return result_;
  }

 private:
  bool slide();
  bool slide_turning();
  bool slide_straight(const Vector3d& direction, double longest);
  void leave_rest();
  Vector3d direction_from_rest();
  double until_turn(const SlipSeries& series, double step) const;
  void advance(const SlipSeries& series, double step);
  void advance(const Vector3d& direction, double length);
  void account(double work, double length);
  /// What restitution still owes, in work or in impulse; <= 0 at the end.
  double owed() const {
    return rule_ == ImpactRule::kStronge
               ? -restitution_ * restitution_ * result_.compression_work - result_.restitution_work
               : (1.0 + restitution_) * compression_length_ - length_;
  }
  bool ended() const { return u_[0] >= 0.0 && owed() <= 0.0; }

  SlipFlow flow_;
  double friction_, restitution_;
  ImpactRule rule_;
  Vector3d u_;
  double smallest_speed_;
  // p_n, now and at the end of compression. While the slip is turning, these and the normal works are in
  // units of cos(angle of friction), which may be 0.
  double length_ = 0.0, compression_length_ = 0.0;
  ImpactResult result_;
};

// The first phase, until the slip stops (false) or the impact ends (true).
bool ImpactPath::slide() {
  result_.slip = Slip::kThroughout;
  bool done = false;
  while (!done && u_.tail<2>().norm() > smallest_speed_) {
    const Vector2d direction = u_.tail<2>().normalized(), rate = flow_.rate(direction, 1.0);
    const double growth = direction.dot(rate);
    // A slip that does not turn, in the plane or near its last direction, has a closed form.
    if (std::abs(cross(direction, rate)) <= kRounding * flow_.largest_rate) {
      Vector3d push;
      push << flow_.normal, -flow_.tangential * direction;
      const bool stops = growth < -kClosed * flow_.W.trace() * flow_.tangential;
      done = slide_straight(push, stops ? u_.tail<2>().norm() / -growth : kInfinity);
      break;
    }
    if (result_.steps == kLargestImpactSteps) {
      result_.status = StatusCode::kLimitReached;
      done = true;
    } else {
      done = slide_turning();
    }
  }
  // From here on normal impulses have units of their own.
  result_.compression_work *= flow_.normal;
  result_.restitution_work *= flow_.normal;
  length_ *= flow_.normal;
  compression_length_ *= flow_.normal;
  return done;
}

// One step of the series, cut at the first event. True at the end of the impact.
bool ImpactPath::slide_turning() {
  ++result_.steps;
  const SlipSeries series(flow_, u_);
  double step = until_turn(series, series.step());
  const auto normal_velocity = [&](double tau) { return series.normal_velocity(tau); };

  // u_n is monotone on the step: cut where it changes sign.
  const bool crosses = u_[0] * normal_velocity(step) < 0.0;
  const bool compression_ends = crosses && u_[0] < 0.0;
  if (crosses) step = crossing(normal_velocity, 0.0, step);
  // Separating: cut where the restitution is complete.
  if (!compression_ends && normal_velocity(0.5 * step) > 0.0) {
    const double start = owed();
    const auto rest = [&](double tau) {
      return start - (rule_ == ImpactRule::kStronge ? series.normal_work(tau) : series.length(tau));
    };
    if (rest(step) <= 0.0) {
      advance(series, rest(0.0) > 0.0 ? crossing(rest, 0.0, step) : 0.0);
      return true;
    }
  }
  advance(series, step);
  if (crosses) u_[0] = 0.0;
  if (compression_ends) compression_length_ = length_;
  return compression_ends && ended();
}

// The step up to where d u_n / d tau changes sign. As a function of the direction it has one extremum of each
// kind, where the slip is parallel to W_tn.
double ImpactPath::until_turn(const SlipSeries& series, double step) const {
  const auto approach = [&](double tau) { return flow_.approach(series.slip(tau), series.speed(tau)); };
  const auto aside = [&](double tau) { return cross(series.slip(tau), flow_.coupling); };
  const double start = approach(0.0);
  double turn = step;
  if (start * approach(step) >= 0.0 && aside(0.0) * aside(step) < 0.0) turn = crossing(aside, 0.0, step);
  if (start * approach(turn) >= 0.0) return step;
  turn = crossing(approach, 0.0, turn);
  return turn > 1e-3 * step ? turn : step;  // the step before may have ended here
}

// p = p + direction * length with du = W dp, in closed form: u_n = 0 and the end are roots of a linear and of
// a quadratic function. True at the end of the impact, false at `longest`.
bool ImpactPath::slide_straight(const Vector3d& direction, double longest) {
  double slope = (flow_.W * direction)[0];
  if (std::abs(slope) <= kClosed * flow_.W.trace() * direction.norm()) slope = 0.0;
  while (longest > 0.0) {
    const bool approaching = u_[0] < 0.0 || (u_[0] == 0.0 && slope < 0.0);
    const double to_zero = u_[0] * slope < 0.0 ? -u_[0] / slope : kInfinity;
    double length = std::min(longest, to_zero), to_end = kInfinity;
    if (!approaching) {
      const double rest = owed();
      if (rest <= 0.0) return true;
      // u_n x + slope x^2 / 2 = rest
      const double root = u_[0] * u_[0] + 2.0 * slope * rest;
      to_end = rest;
      if (rule_ == ImpactRule::kStronge)
        to_end = root >= 0.0 ? 2.0 * rest / (u_[0] + std::sqrt(root)) : kInfinity;
    }
    if (to_end <= length && to_end < kInfinity) {
      advance(direction, to_end);
      return true;
    }
    if (length == kInfinity) {
      result_.status = StatusCode::kSingular;
      return true;
    }
    advance(direction, length);
    longest -= length;
    if (length == to_zero) {
      u_[0] = 0.0;
      if (approaching) compression_length_ = length_;
    }
  }
  return false;
}

// The last phase: the slip has stopped.
void ImpactPath::leave_rest() {
  u_.tail<2>().setZero();
  result_.slip = Slip::kStopped;
  if (ended()) return;
  const Vector3d direction = direction_from_rest();
  if ((flow_.W * direction)[0] <= kClosed * flow_.W.trace()) {
    result_.status = StatusCode::kSingular;
    return;
  }
  slide_straight(direction, kInfinity);
}

// dp per dp_n: held by friction, or along the direction in which slip grows.
Vector3d ImpactPath::direction_from_rest() {
  Eigen::SelfAdjointEigenSolver<Matrix2d> axes;
  axes.computeDirect(flow_.inertia);
  const Vector2d& inertia = axes.eigenvalues();
  const Vector2d coupling = axes.eigenvectors().transpose() * flow_.coupling;
  // Norm of (friction W_tt + x)^-1 W_tn; closed directions have no part in it.
  Vector2d held = Vector2d::Zero();
  const auto hold = [&](double friction, double x) {
    for (int i = 0; i < 2; ++i)
      if (inertia[i] > kClosed * flow_.W.trace()) held[i] = coupling[i] / (friction * inertia[i] + x);
    return held.norm();
  };
  double ratio = hold(1.0, 0.0), scale = 1.0;
  if (ratio > friction_) {
    // Newton's method on 1/norm - 1, concave: rises to the root from the left.
    result_.slip = Slip::kResumed;
    ratio = hold(friction_, 0.0);
    for (double x = 0.0, before = -1.0; x > before && ratio > 1.0; ratio = hold(friction_, x)) {
      double slope = 0.0;
      for (int i = 0; i < 2; ++i)
        if (held[i] != 0.0) slope += held[i] * held[i] / (friction_ * inertia[i] + x);
      before = x;
      x += (ratio - 1.0) * ratio * ratio / slope;
    }
    scale = friction_ / ratio;
  }
  Vector3d direction;
  direction << 1.0, -scale * (axes.eigenvectors() * held);
  return direction;
}

void ImpactPath::advance(const SlipSeries& series, double step) {
  account(series.normal_work(step), series.length(step));
  result_.friction_work -= flow_.tangential * series.friction(step);
  result_.impulse[0] += flow_.normal * series.length(step);
  result_.impulse.tail<2>() -= flow_.tangential * series.path(step);
  const double normal_velocity = series.normal_velocity(step);
  result_.jammed |= normal_velocity < u_[0];
  u_ << normal_velocity, series.slip(step);
}

void ImpactPath::advance(const Vector3d& direction, double length) {
  const Vector3d change = flow_.W * direction * length, middle = u_ + 0.5 * change;
  account(middle[0] * length, length);
  result_.friction_work += middle.tail<2>().dot(direction.tail<2>()) * length;
  result_.impulse += direction * length;
  result_.jammed |= change[0] < 0.0;
  u_ += change;
}

void ImpactPath::account(double work, double length) {
  (work < 0.0 ? result_.compression_work : result_.restitution_work) += work;
  length_ += length;
}

}  // namespace

ImpactResult follow_impact_path(const Matrix3d& W, const Vector3d& u, double friction, double restitution,
                                ImpactRule rule) {
  return ImpactPath(W, u, friction, restitution, rule).follow();
}

}  // namespace feder
