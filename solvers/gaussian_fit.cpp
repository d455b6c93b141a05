// Levenberg-Marquardt for r_i = f(x_i) - f_i, J = dr/dp: the step is the one of a damped spring network whose
// rows are the residuals and whose mass is D^2,
//   [ D^2  -J^T ] [ dp ]   [ 0 ]      dual:   dp = -D^-2 J^T (J D^-2 J^T + mu)^-1 r
//   [ -J   -mu  ] [ y  ] = [ r ]      primal: dp = -(J^T J + mu D^2)^-1 J^T r
// D holds the largest norm each column of J has had (More, Lecture Notes in Mathematics 630, 1978, section
// 6). mu = theta |D^-1 J^T r| / |values|, theta from the gain ratio: quadratic where r = 0 in the end (Fan
// and Yuan, Computing 74, 2005).
#include "solvers/gaussian_fit.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <vector>

#include "engine/check.h"
#include "solvers/step_row_solver.h"

namespace feder {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kLeastTheta = 1e-8, kMostTheta = 1e16;
constexpr double kLeastGain = 1e-4;  // of a step that is taken
// Below this share of |r|^2 a predicted gain is rounding, and the gradient decides about a step.
constexpr double kBlind = 1e-13;

void check_input(const Eigen::MatrixXd& points, const VectorXd& values, const GaussianSum& sum,
                 const GaussianFitOptions& options) {
  const char* place = "fit of Gaussians";
  if (values.size() == 0) fail_input(place, "points", 0.0, "", "at least 1");
  if (points.cols() != values.size())
    fail_input(place, "points", static_cast<double>(points.cols()), "",
               "as many as values, " + std::to_string(values.size()));
  if (points.rows() != sum.dimension)
    fail_input(place, "dimension of the points", static_cast<double>(points.rows()), "",
               "that of the sum, " + std::to_string(sum.dimension));
  for (const double x : points.reshaped()) require_finite(place, "point", x, "");
  for (const double x : values) require_finite(place, "value", x, "");
  if (sum.count() == 0) fail_input(place, "Gaussians", 0.0, "", "at least 1");
  if (!in_range(sum)) throw InputError(std::string(place) + ": the start is out of range");
  require_positive(place, "first damping", options.first_damping, "");
  require_positive(place, "tolerance", options.tolerance, "");
  if (options.most_steps < 1) fail_input(place, "most steps", options.most_steps, "", "at least 1");
}

// r, and J transposed: one column per point.
struct Residual {
  VectorXd r;
  Eigen::MatrixXd Jt;
  VectorXd gradient;     // J^T r
  double cosine = 0.0;   // largest |J_j . r| / (|J_j| |r|)
  double squares = 0.0;  // |r|^2
  double terms = 0.0;    // |values| + |what the Gaussians add to each point, without signs|

  void evaluate_residual(const Eigen::MatrixXd& points, const VectorXd& values, const GaussianSum& sum) {
    r.resize(values.size());
    Jt.resize(sum.parameters.size(), values.size());
    for (Eigen::Index i = 0; i < values.size(); ++i)
      r[i] = evaluate(sum, points.col(i), Jt.col(i).data()) - values[i];
    gradient = Jt * r;
    squares = r.squaredNorm();
    VectorXd magnitude = VectorXd::Zero(values.size());
    for (int k = 0; k < sum.count(); ++k)
      magnitude += std::abs(sum.weight(k)) * Jt.row(k * sum.stride()).transpose();
    terms = values.norm() + magnitude.norm();
    cosine = 0.0;
    for (Eigen::Index j = 0; j < gradient.size(); ++j)
      if (gradient[j] != 0.0)
        cosine = std::max(cosine, std::abs(gradient[j]) / (Jt.row(j).stableNorm() * std::sqrt(squares)));
  }
  bool finite() const { return std::isfinite(squares) && Jt.allFinite() && std::isfinite(cosine); }
};

// The damped step by either Schur complement.
class DampedStep {
 public:
  DampedStep(bool primal) : primal_(primal) {}

  Status solve(const Residual& at, const VectorXd& square_scales, double mu, VectorXd& step) {
    return primal_ ? solve_primal(at, square_scales, mu, step) : solve_dual(at, square_scales, mu, step);
  }

 private:
  Status solve_primal(const Residual& at, const VectorXd& square_scales, double mu, VectorXd& step) {
    // (E + D^-1 J^T J D^-1 / mu) mu: scaled by D, so that units do not count
    const VectorXd inverse = square_scales.cwiseSqrt().cwiseInverse();
    const Eigen::MatrixXd scaled = inverse.asDiagonal() * at.Jt;
    normal_.setZero(step.size(), step.size());
    normal_.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
    normal_.diagonal().array() += mu;
    llt_.compute(normal_);
    if (llt_.info() != Eigen::Success)
      return Status::failure(StatusCode::kSingular, "parameters depend on each other");
    step = -inverse.cwiseProduct(llt_.solve(inverse.cwiseProduct(at.gradient)));
    return {};
  }

  Status solve_dual(const Residual& at, const VectorXd& square_scales, double mu, VectorXd& step) {
    rows_.clear();
    for (int i = 0; i < at.Jt.cols(); ++i) {
      for (int j = 0; j < at.Jt.rows(); ++j) rows_.add(j, at.Jt(j, i));
      rows_.close_row();
    }
    rows_.gamma = VectorXd::Constant(at.r.size(), mu);
    rows_.r = at.r;
    step.setZero();
    return solver_.solve(rows_, square_scales.cwiseInverse(), step, y_);
  }

  bool primal_;
  Eigen::MatrixXd normal_;
  Eigen::LLT<Eigen::MatrixXd> llt_;
  StepRows rows_;
  StepRowSolver solver_;
  VectorXd y_;
};

Status not_converged(const std::string& what, double cosine) {
  std::ostringstream text;
  text << what << ", cosine of the gradient " << cosine;
  return Status::failure(StatusCode::kNotConverged, text.str());
}

// Gain ratio: true over predicted fall of |r|^2; negative where the trial is no step to take.
double gain_ratio(const Residual& now, const Residual& trial, const VectorXd& step) {
  if (!trial.finite()) return -1.0;
  const VectorXd change = now.Jt.transpose() * step;
  // |r|^2 - |r + J dp|^2, written without cancellation
  const double predicted = -change.dot(2.0 * now.r + change);
  if (!(predicted > 0.0)) return -1.0;
  if (predicted < kBlind * now.squares)
    return trial.cosine < now.cosine && trial.squares < (1.0 + kBlind) * now.squares ? 1.0 : -1.0;
  return (now.r - trial.r).dot(now.r + trial.r) / predicted;
}

}  // namespace

GaussianFit fit_gaussians(const Eigen::MatrixXd& points, const VectorXd& values, GaussianSum& sum,
                          const GaussianFitOptions& options) {
  check_input(points, values, sum, options);
  GaussianFit fit;
  fit.primal = options.route == FitRoute::kPrimal ||
               (options.route == FitRoute::kAuto && 5 * values.size() > sum.parameters.size());
  Residual now, trial;
  now.evaluate_residual(points, values, sum);
  std::vector<double> norms = {std::sqrt(now.squares)};
  const auto end = [&](Status status) {
    fit.status = std::move(status);
    fit.rms = std::sqrt(now.squares / static_cast<double>(values.size()));
    fit.gradient = now.cosine;
    fit.residual_norms = Eigen::Map<VectorXd>(norms.data(), static_cast<Eigen::Index>(norms.size()));
    return fit;
  };
  if (!now.finite())
    return end(Status::failure(StatusCode::kNonFinite, "the sum of squares at the start is not finite"));

  const double size = values.norm();
  DampedStep damped(fit.primal);
  VectorXd square_scales = VectorXd::Zero(sum.parameters.size()), step = square_scales;
  GaussianSum next = sum;
  double theta = options.first_damping, growth = 2.0;
  Status last;
  while (now.cosine > options.tolerance && std::sqrt(now.squares) > 4.0 * kEpsilon * now.terms) {
    if (fit.tried == options.most_steps)
      return end(not_converged(std::to_string(fit.tried) + " steps tried", now.cosine));
    ++fit.tried;
    // D: a column that has always been 0 moves nothing and is not moved
    square_scales = square_scales.cwiseMax(now.Jt.rowwise().squaredNorm());
    const VectorXd scales = square_scales.unaryExpr([](double x) { return x > 0.0 ? x : 1.0; });
    const double norm = std::sqrt(now.squares);
    last = damped.solve(now, scales, theta * norm / std::max(size, norm), step);
    double gain = -1.0;
    if (last.ok() && step.allFinite()) {
      next.parameters = sum.parameters + step;
      if (in_range(next)) {
        trial.evaluate_residual(points, values, next);
        gain = gain_ratio(now, trial, step);
      }
    }
    // theta: down after a good step, up ever faster after bad ones (Nielsen, IMM-REP-1999-05, section 3)
    if (gain > kLeastGain) {
      std::swap(now, trial);
      sum.parameters = next.parameters;
      norms.push_back(std::sqrt(now.squares));
      ++fit.steps;
      theta = std::max(theta * std::max(1.0 / 3.0, 1.0 - std::pow(2.0 * std::min(gain, 1.0) - 1.0, 3.0)),
                       kLeastTheta);
      growth = 2.0;
    } else {
      theta *= growth;
      growth *= 2.0;
    }
    if (theta > kMostTheta)
      return end(last.ok() ? not_converged("no step lowers the sum of squares", now.cosine) : last);
  }
  return end({});
}

}  // namespace feder
