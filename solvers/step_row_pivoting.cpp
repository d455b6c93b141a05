// Which unilateral rows push. w = S y + r + J v_start >= 0, y >= 0, w y = 0: guess which rows push, solve for
// their y with the others 0, swap every row of the wrong sign. Where the number of these does not fall:
// with gamma > 0 this is a Newton step for the least of the convex
//   F(v) = |v - v_start|^2_(1/W) / 2 + sum max(0, -(J v + r))^2 / (2 gamma),
// which is cut to the least F on its way; without gamma only the last of them is swapped (Murty's rule, which
// cannot cycle).
#include <algorithm>
#include <cmath>
#include <sstream>

#include "solvers/step_row_solver.h"

namespace feder {

// Where F is least between u = v_start + W J^T z and v = v_start + W J^T y: with a = J (v - u), c = J u + r,
//   dF/dt = sum a (z + t (y - z)) - a max(0, -(c + t a)) / gamma,   which grows with t.
// Moves u and z there; rows that are violated at u push next.
void StepRowSolver::search(const StepRows& rows, const VectorXd& v, const VectorXd& y, VectorXd& u,
                           VectorXd& z) {
  constexpr int kHalvings = 60;
  const int m = rows.count();
  VectorXd a(m), c(m);
  for (int k = 0; k < m; ++k) {
    c[k] = rows.multiply_row(k, u.data()) + r_[k];
    a[k] = rows.multiply_row(k, v.data()) + r_[k] - c[k];
  }
  const auto slope = [&](double t) {
    double sum = 0.0;
    for (int k = 0; k < m; ++k) {
      if (!(diagonal_[k] > 0.0)) continue;
      sum += a[k] * (z[k] + t * (y[k] - z[k]) + std::min(0.0, c[k] + t * a[k]) / rows.gamma[k]);
    }
    return sum;
  };
  double low = slope(1.0) > 0.0 ? 0.0 : 1.0, high = 1.0;
  for (int i = 0; i < kHalvings && low < high; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) > 0.0 ? high : low) = middle;
  }
  u += high * (v - u);
  z += high * (y - z);
  const std::vector<char> last = active_;
  for (int k = 0; k < m; ++k) active_[k] = diagonal_[k] > 0.0 && c[k] + high * a[k] < 0.0;
  if (active_ == last) active_[wrong_.back()] = !active_[wrong_.back()];  // rounding decides
}

// Which rows push, from the guess in active_.
Status StepRowSolver::pivot(const StepRows& rows, const VectorXd& inverse_mass, const VectorXd& start,
                            VectorXd& v, VectorXd& y) {
  constexpr int kPatience = 3, kMostSearches = 300;
  const int m = rows.count();
  bool soft = true;
  for (int k = 0; k < m; ++k) soft = soft && (rows.gamma[k] > 0.0 || !(diagonal_[k] > 0.0));
  VectorXd u = start, z = VectorXd::Zero(m);  // the least F so far
  int fewest = m + 1, patience = kPatience, searches = 0;
  const int most = 100 + 10 * m;
  for (int iteration = 0; iteration < most; ++iteration) {
    if (Status status = solve_active(rows, inverse_mass, start, v, y); !status.ok()) return status;
    if (!rows.unilateral) return {};
    find_wrong(rows, v, y);
    const int wrong = static_cast<int>(wrong_.size());
    if (wrong == 0) return {};
    if (searches == 0 && wrong < fewest) {
      fewest = wrong;
      patience = kPatience;
    } else if (patience > 0) {
      --patience;
    } else if (soft && searches < kMostSearches) {
      ++searches;
      search(rows, v, y, u, z);
      continue;
    } else {
      wrong_ = {wrong_.back()};
    }
    for (int k : wrong_) active_[k] = !active_[k];
  }
  return Status::failure(StatusCode::kNotConverged, "block pivoting of unilateral rows does not end");
}

// J v + gamma (y - held) + r = 0 with held ahead of the last y as Guler takes it (SIAM J. Optim. 2, 1992):
// what is left of J v + r is gamma (y - held).
Status StepRowSolver::close(const StepRows& rows, const VectorXd& inverse_mass, double tolerance, VectorXd& v,
                            VectorXd& y) {
  constexpr int kMost = 300;
  const VectorXd start = v;
  Status status = begin(rows, inverse_mass, v, y);
  VectorXd held = VectorXd::Zero(rows.count()), last = held;
  double momentum = 1.0;
  rounds_ = 0;
  for (int k = 0; k < rows.count() && status.ok(); ++k)
    if (!(diagonal_[k] > 0.0) && (rows.unilateral ? right_[k] : std::abs(right_[k])) > tolerance)
      status = Status::failure(StatusCode::kNotConverged,
                               "row " + std::to_string(k) + " of the step is violated and moves nothing");
  while (status.ok() && rows.count() > 0) {
    ++rounds_;
    status = pivot(rows, inverse_mass, start, v, y);
    const double left = rows.gamma.cwiseProduct(y - held).lpNorm<Eigen::Infinity>();
    if (!status.ok() || left <= tolerance) break;
    if (rounds_ == kMost) {
      std::ostringstream reason;
      reason << "rows of the step do not close: " << left << " is left, more than " << tolerance
             << "; they may contradict each other";
      status = Status::failure(StatusCode::kNotConverged, reason.str());
    }
    const double next = 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * momentum * momentum));
    held = y;
    if (rounds_ > 1) held += (momentum - 1.0) / next * (y - last);
    momentum = next;
    last = y;
    set_right(rows, start, rows.r - rows.gamma.cwiseProduct(held));
  }
  if (!status.ok()) v = start, y.setZero();
  return status;
}

}  // namespace feder
