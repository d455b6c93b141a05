// Predicted step limits of a system linearised at a state: M x'' + C x' + (Km + Kg) x = 0 over the free
// coordinates, scaled by M^-1/2 from both sides and applied matrix-free,
//   Km = J^T D J,  Kg = -sum_k lambda_k Hess phi_k with lambda = -D phi,  C = drag + J^T D tau J.
// Eigenvalues: dense for small systems, Lanczos (Spectra) otherwise.
#include "solvers/stability.h"

#include <Spectra/SymEigsSolver.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/kkt.h"
#include "solvers/fluid_stability.h"
#include "solvers/stability_modes.h"

namespace feder {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// Roots and frequencies below this fraction of the largest are rounding noise of free motion.
constexpr double kRelativeZero = 1e-6;

struct Weights {
  double material = 0.0, geometric = 0.0, damping = 0.0;
};
constexpr Weights kStiffness{1.0, 1.0, 0.0};

struct Eigenpair {
  double value;
  VectorXd vector;
};

// What may stand in the way of a prediction: refused, or left out (hard rows do not act, bodies are at rest).
enum class Obstacles { kRefused, kLeftOut };

class Linearization {
 public:
  Linearization(const System& s, const State& state, Obstacles obstacles = Obstacles::kRefused,
                const LanczosOptions& lanczos = {});

  const Status& status() const { return status_; }
  const std::string& obstacle() const { return obstacle_; }
  int size() const { return static_cast<int>(coordinates_.size()); }
  bool small() const { return size() <= kLargestDenseSize; }
  bool stressed() const { return stressed_; }
  bool damped() const { return system_.has_damping || system_.forces.has_drag; }
  const System& system() const { return system_; }
  /// sqrt(x.Kx / x.Mx) of an acceleration (given as force) or velocity; 0 for x = 0 or x.Kx < 0.
  double frequency_of_force(const VectorXd& f) const {
    return frequency_of(f(coordinates_).cwiseProduct(scale_));
  }
  double frequency_of_velocity(const VectorXd& v) const {
    return frequency_of(v(coordinates_).cwiseQuotient(scale_));
  }
  /// (alpha, tau) if C = alpha M + tau K on every mode, else nothing.
  std::optional<std::pair<double, double>> modal_damping() const;

  /// M^-1/2 (w.material Km + w.geometric Kg + w.damping C) M^-1/2 x.
  VectorXd apply(const Weights& w, const VectorXd& x) const;
  Eigen::MatrixXd dense(const Weights& w) const;
  /// Largest eigenvalue of apply(w) + shift, and its vector; nothing if Lanczos does not converge.
  std::optional<Eigenpair> top(const Weights& w, double shift = 0.0) const;
  /// top(kStiffness), computed once.
  const std::optional<Eigenpair>& stiffest() const;

 private:
  double frequency_of(const VectorXd& x) const {
    return x.isZero(0.0) ? 0.0 : std::sqrt(std::max(0.0, x.dot(apply(kStiffness, x)) / x.squaredNorm()));
  }
  const System& system_;
  LanczosOptions lanczos_;
  Status status_;
  std::string obstacle_;
  Kkt kkt_;
  bool stressed_ = false;
  VectorXd stiffness_;            ///< d, 0 for hard rows
  std::vector<int> coordinates_;  ///< free ones
  VectorXd scale_;                ///< M^-1/2 over them
  mutable std::optional<std::optional<Eigenpair>> stiffest_;
};

// The first hard row, or the first body that turns or has a torque; empty if there is none.
std::string first_obstacle(const System& s, const State& state) {
  for (int k = 0; k < s.rows; ++k)
    if (std::isinf(s.stiffness[k])) return s.row_name(k) + " is hard: its frequency is infinite";
  for (std::size_t i = 0; i < s.bodies.size(); ++i)
    if (!state.v.segment<3>(3 * s.bodies[i].spin).isZero(0.0) || !s.bodies[i].torque.isZero(0.0))
      return "predicted limits are for bodies at rest without torque: body " + std::to_string(i);
  return {};
}

Linearization::Linearization(const System& s, const State& state, Obstacles obstacles,
                             const LanczosOptions& lanczos)
    : system_(s), lanczos_(lanczos) {
  obstacle_ = first_obstacle(s, state);
  if (!obstacle_.empty() && obstacles == Obstacles::kRefused) {
    status_ = Status::failure(StatusCode::kRefused, obstacle_);
    return;
  }
  kkt_.prepare(s);
  if (status_ = kkt_.evaluate(state.q); !status_.ok()) return;
  stiffness_ = s.stiffness.array().isInf().select(0.0, s.stiffness.array());
  kkt_.set_geometric_stiffness(GeometricStiffness::kFull, 1.0, state, -stiffness_.cwiseProduct(kkt_.phi));
  for (int i = 0; i < 3 * s.nodes; ++i)
    if (s.inverse_mass[i] > 0.0) coordinates_.push_back(i);
  scale_.resize(size());
  for (int i = 0; i < size(); ++i) scale_[i] = std::sqrt(s.inverse_mass[coordinates_[i]]);

  stressed_ = s.forces.user.stiffness || !s.law_springs.empty();
  for (int k = 0; k < s.rows; ++k) {
    const double length = k < s.distance.size() ? kkt_.length[k] : 1.0;
    if (s.active(k) && std::abs(kkt_.phi[k]) > 1e-13 * length) stressed_ = true;
  }
}

std::optional<std::pair<double, double>> Linearization::modal_damping() const {
  const System& s = system_;
  double alpha = 0.0, tau = 0.0;
  if (s.forces.has_drag) {
    alpha = s.forces.drag[coordinates_[0]] * s.inverse_mass[coordinates_[0]];
    for (int i : coordinates_)
      if (std::abs(s.forces.drag[i] * s.inverse_mass[i] - alpha) > 1e-14 * alpha) return std::nullopt;
  }
  if (s.has_damping) {
    if (stressed_) return std::nullopt;  // C follows Km alone
    for (int k = 0; k < s.rows; ++k)
      if (s.stiffness[k] > 0.0) tau = s.damping_time[k];
    for (int k = 0; k < s.rows; ++k)
      if (s.active(k) && (s.damping_time[k] != tau || s.damping[k] != tau * s.stiffness[k]))
        return std::nullopt;
  }
  return std::pair{alpha, tau};
}

VectorXd Linearization::apply(const Weights& w, const VectorXd& x) const {
  const System& s = system_;
  VectorXd full = VectorXd::Zero(3 * s.nodes), out = VectorXd::Zero(3 * s.nodes), y;
  for (int i = 0; i < size(); ++i) full[coordinates_[i]] = scale_[i] * x[i];
  // J^T (material D + damping b) J
  kkt_.multiply_jacobian(full, y);
  y.array() *= w.material * stiffness_.array() + w.damping * s.damping.array();
  kkt_.add_jacobian_transpose(y, out);
  if (w.geometric != 0.0) kkt_.add_geometric(w.geometric * full, out);
  if (w.damping != 0.0) out.array() += w.damping * s.forces.drag.array() * full.array();
  VectorXd result(size());
  for (int i = 0; i < size(); ++i) result[i] = scale_[i] * out[coordinates_[i]];
  return result;
}

Eigen::MatrixXd Linearization::dense(const Weights& w) const {
  Eigen::MatrixXd A(size(), size());
  for (int i = 0; i < size(); ++i) A.col(i) = apply(w, VectorXd::Unit(size(), i));
  return 0.5 * (A + A.transpose());
}

// What Spectra needs of a matrix.
struct Product {
  using Scalar = double;
  const Linearization& system;
  Weights weights;
  double shift;

  Eigen::Index rows() const { return system.size(); }
  Eigen::Index cols() const { return system.size(); }
  void perform_op(const double* in, double* out) const {
    const Eigen::Map<const VectorXd> x(in, system.size());
    Eigen::Map<VectorXd>(out, system.size()) = system.apply(weights, x) + shift * x;
  }
};

std::optional<Eigenpair> Linearization::top(const Weights& w, double shift) const {
  if (small()) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(dense(w));
    if (eigen.info() != Eigen::Success) return std::nullopt;
    return Eigenpair{eigen.eigenvalues()[size() - 1] + shift, eigen.eigenvectors().rightCols<1>()};
  }
  // nothing to find in a matrix of zeros, and Spectra throws there
  if (apply(w, VectorXd::LinSpaced(size(), 1.0, 2.0).array().sin().matrix()).isZero(0.0))
    return Eigenpair{shift, VectorXd::Unit(size(), 0)};
  Product product{*this, w, shift};
  Spectra::SymEigsSolver<Product> solver(product, 1, 60);
  solver.init();
  solver.compute(Spectra::SortRule::LargestAlge, lanczos_.most_restarts, lanczos_.tolerance);
  if (solver.info() != Spectra::CompInfo::Successful) return std::nullopt;
  return Eigenpair{solver.eigenvalues()[0], solver.eigenvectors().col(0)};
}

const std::optional<Eigenpair>& Linearization::stiffest() const {
  if (!stiffest_) stiffest_ = top(kStiffness);
  return *stiffest_;
}

std::string number(double x) {
  char text[32];
  (void)std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string user_force_note(const System& s) {
  return s.forces.user && !s.forces.user.stiffness ? "; the user force gives no stiffness and is left out"
                                                   : "";
}

constexpr const char* kNoConvergence = "Lanczos did not converge on the largest eigenvalue";

struct Method {
  double (*mode)(double omega_squared, double c);
  double (*root)(std::complex<double> s);
};

// The limit over all modes, C = alpha M + tau K.
StabilityLimit modal_limit(const Linearization& system, double alpha, double tau, const Method& method) {
  const std::optional<Eigenpair>& top = system.stiffest();
  if (!top) return {kNaN, kNoConvergence};
  const double largest = std::max(0.0, top->value), damping = alpha + tau * largest;
  StabilityLimit limit{method.mode(largest, damping), "omega_max = " + number(std::sqrt(largest)) +
                                                          " rad/s, damping rate " + number(damping) + " 1/s"};
  // the limit first rises and then falls with omega (checked over all alpha tau): only drag can make the
  // slowest mode decide
  if (alpha == 0.0 || limit.dt <= method.mode(0.0, alpha)) return limit;
  const std::optional<Eigenpair> bottom = system.top({-1.0, -1.0, 0.0}, largest);
  if (!bottom)
    return {kNaN, "Lanczos did not converge on the smallest eigenvalue, which decides under heavy drag"};
  const double smallest = std::max(0.0, largest - bottom->value);
  const double dt = method.mode(smallest, alpha + tau * smallest);
  if (dt >= limit.dt) return limit;
  return {dt, "drag " + number(alpha) + " 1/s on the slowest mode, omega = " + number(std::sqrt(smallest)) +
                  " rad/s"};
}

// The limit over the eigenvalues of [0 E; -K -C].
StabilityLimit companion_limit(const Linearization& system, const Method& method) {
  const int n = system.size();
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(2 * n, 2 * n);
  companion.topRightCorner(n, n).setIdentity();
  companion.bottomLeftCorner(n, n) = -system.dense(kStiffness);
  companion.bottomRightCorner(n, n) = -system.dense({0.0, 0.0, 1.0});
  const Eigen::EigenSolver<Eigen::MatrixXd> eigen(companion, false);
  if (eigen.info() != Eigen::Success)
    return {kNaN, "the eigenvalues of the companion matrix did not converge"};
  const double scale = eigen.eigenvalues().cwiseAbs().maxCoeff();
  StabilityLimit limit{kInfinity, "no stiffness and no damping"};
  for (std::complex<double> s : eigen.eigenvalues()) {
    if (std::abs(s) <= kRelativeZero * scale) continue;    // free motion
    if (s.real() > kRelativeZero * std::abs(s)) continue;  // grows in the exact solution too
    if (s.real() > -1e-10 * std::abs(s)) s.real(0.0);      // undamped to rounding
    const double dt = method.root(s);
    if (dt < limit.dt)
      limit = {
          dt, "root " + number(s.real()) + " + " + number(std::abs(s.imag())) + " i of the companion matrix"};
  }
  return limit;
}

constexpr Method kExplicitEuler{explicit_euler_limit, explicit_euler_limit}, kRk4{rk4_limit, rk4_limit};

StabilityLimit damped_limit(const Linearization& system, const Method& method) {
  if (const auto modal = system.modal_damping())
    return modal_limit(system, modal->first, modal->second, method);
  if (system.small()) return companion_limit(system, method);
  return {kNaN, "the damping does not diagonalise with the stiffness and the system has " +
                    std::to_string(system.size()) + " free coordinates, more than " +
                    std::to_string(kLargestDenseSize)};
}

StabilityLimit undamped_limit(const Linearization& system) {
  const std::optional<Eigenpair>& top = system.stiffest();
  if (!top) return {kNaN, kNoConvergence};
  const double largest = std::max(0.0, top->value);
  return {leapfrog_limit(largest, 0.0), "omega_max = " + number(std::sqrt(largest)) + " rad/s"};
}

StabilityLimit notes_step_limit_of(const Linearization& system) {
  if (!system.stressed()) return {kInfinity, "no row is stressed: Kg = 0"};
  // the shift makes Lanczos converge relative to the whole spectrum, not to an excess that may be 0
  const std::optional<Eigenpair>& stiffest = system.stiffest();
  if (!stiffest) return {kNaN, kNoConvergence};
  const double shift = std::abs(stiffest->value);
  const double mu = notes_step_rate(
      [&](double at) -> std::optional<VectorXd> {
        auto top = system.top({-1.0, 1.0, -2.0 * at}, shift);
        if (!top) return std::nullopt;
        return std::move(top->vector);
      },
      [&](const VectorXd& x) {
        return RayleighForms{x.dot(system.apply({-1.0, 1.0, 0.0}, x)),
                             system.damped() ? x.dot(system.apply({0.0, 0.0, 1.0}, x)) : 0.0};
      },
      1e-12 * shift, 1e-10);
  if (std::isnan(mu)) return {kNaN, kNoConvergence};
  if (mu == 0.0) return {kInfinity, "nowhere does Kg exceed Km"};
  return {1.0 / mu, "geometric stiffness exceeds Km: 4 M + 2 dt C + dt^2 (Km - Kg) is singular"};
}

// Symplectic Euler: M (z-1)^2 + dt C (z-1) + dt^2 K z = 0 leaves the unit circle at z = -1 alone, where
// 4 M - 2 dt C - dt^2 K is singular.
StabilityLimit symplectic_limit(const Linearization& system) {
  if (!system.damped()) return undamped_limit(system);
  const std::optional<Eigenpair> most_damped = system.top({0.0, 0.0, 1.0});
  if (!most_damped) return {kNaN, kNoConvergence};
  const double mu = symplectic_euler_rate(
      [&](double at) -> std::optional<VectorXd> {
        auto top = system.top({1.0, 1.0, 2.0 * at});
        if (!top) return std::nullopt;
        return std::move(top->vector);
      },
      [&](const VectorXd& x) {
        return RayleighForms{x.dot(system.apply(kStiffness, x)), x.dot(system.apply({0.0, 0.0, 1.0}, x))};
      },
      most_damped->vector, 1e-10);
  if (std::isnan(mu)) return {kNaN, kNoConvergence};
  if (mu == 0.0) return {kInfinity, "no stiffness and no damping"};
  return {1.0 / mu, "4 M - 2 dt C - dt^2 K is singular"};
}

// By the name of the integrator.
StabilityLimit limit_of(const std::string& integrator, const Linearization& system) {
  if (integrator == "implicit_euler_geometric" || integrator == "implicit_euler_newton")
    return {kInfinity, "unconditional in theory: Kg >= 0 damps every mode"};
  if (!system.status().ok()) return {kNaN, system.status().reason};
  if (system.size() == 0) return {kInfinity, "nothing moves"};
  StabilityLimit limit{kNaN, "no prediction for this integrator"};
  if (integrator == "xpbd") limit.why = "none: how stiff rows are depends on the sweeps";
  if (integrator == "explicit_euler") limit = damped_limit(system, kExplicitEuler);
  if (integrator == "symplectic_euler") limit = symplectic_limit(system);
  if (integrator == "leapfrog") limit = undamped_limit(system);
  if (integrator == "rk4") limit = damped_limit(system, kRk4);
  if (integrator == "implicit_euler_notes") limit = notes_step_limit_of(system);
  limit.why += user_force_note(system.system());
  return limit;
}

double excited_frequency(const Linearization& system, const State& state) {
  constexpr double kBalanced = 1e-9;  // forces that cancel this far leave rounding only
  VectorXd force, external;
  if (!evaluate_forces(system.system(), state, force).ok()) return kNaN;
  evaluate_external_forces(system.system(), state, external);
  if (force.norm() <= kBalanced * (external.norm() + (force - external).norm())) force.setZero();
  return std::max(system.frequency_of_force(force), system.frequency_of_velocity(state.v));
}

Spectrum spectrum_of(const Linearization& system, const State& state) {
  if (!system.status().ok()) return {kNaN, kNaN, kNaN, kNaN, system.status().reason};
  Spectrum spectrum{0.0, kNaN, 0.0, 0.0, system.obstacle()};
  if (system.size() == 0) return spectrum;
  if (system.damped()) {
    const std::optional<Eigenpair> most_damped = system.top({0.0, 0.0, 1.0});
    spectrum.largest_damping_rate = most_damped ? std::max(0.0, most_damped->value) : kNaN;
  }
  if (system.obstacle().empty()) spectrum.excited_frequency = excited_frequency(system, state);
  const std::optional<Eigenpair>& stiffest = system.stiffest();
  spectrum.largest_frequency = stiffest ? std::sqrt(std::max(0.0, stiffest->value)) : kNaN;
  if (!system.small()) return spectrum;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(system.dense(kStiffness),
                                                             Eigen::EigenvaluesOnly);
  const VectorXd omega = eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  for (int i = system.size() - 1; i >= 0 && omega[i] > kRelativeZero * spectrum.largest_frequency; --i)
    spectrum.smallest_frequency = omega[i];
  return spectrum;
}

}  // namespace

double largest_frequency(const System& s, const State& state) {
  const Linearization system(s, state);
  if (!system.status().ok()) return kNaN;
  if (system.size() == 0) return 0.0;
  const std::optional<Eigenpair>& top = system.stiffest();
  const double fluid = largest_fluid_rates(s, state).frequency;
  return top ? std::sqrt(std::max(0.0, top->value) + fluid * fluid) : kNaN;
}

double largest_rate(const System& s, const State& state) {
  const Linearization system(s, state);
  if (!system.status().ok()) return kNaN;
  if (system.size() == 0) return 0.0;
  const std::optional<Eigenpair>& stiffest = system.stiffest();
  if (!stiffest) return kNaN;
  double c = 0.0;
  if (system.damped()) {
    const std::optional<Eigenpair> most_damped = system.top({0.0, 0.0, 1.0});
    if (!most_damped) return kNaN;
    c = std::max(0.0, most_damped->value);
  }
  const FluidRates fluid = largest_fluid_rates(s, state);
  c += fluid.damping;
  const double squared = std::max(0.0, stiffest->value) + fluid.frequency * fluid.frequency;
  return 0.5 * (c + std::sqrt(c * c + 4.0 * squared));
}

StabilityLimit stability_limit(const std::string& integrator, const System& s, const State& state) {
  return with_fluid(integrator, limit_of(integrator, Linearization(s, state)), largest_fluid_rates(s, state));
}

StabilityLimit stability_limit_explicit_euler(const System& s, const State& state) {
  return stability_limit("explicit_euler", s, state);
}

StabilityLimit stability_limit_rk4(const System& s, const State& state) {
  return stability_limit("rk4", s, state);
}

StabilityLimit stability_limit_leapfrog(const System& s, const State& state) {
  return stability_limit("leapfrog", s, state);
}

StabilityLimit stability_limit_notes_step(const System& s, const State& state) {
  return stability_limit("implicit_euler_notes", s, state);
}

StabilityForecast forecast_stability(const System& s, const State& state,
                                     const std::vector<std::string>& integrators,
                                     const LanczosOptions& lanczos) {
  const Linearization system(s, state, Obstacles::kLeftOut, lanczos);
  StabilityForecast forecast{spectrum_of(system, state), {}};
  const FluidRates fluid = largest_fluid_rates(s, state);
  for (const std::string& name : integrators)
    forecast.limits.push_back(with_fluid(
        name, system.obstacle().empty() ? limit_of(name, system) : limit_of(name, Linearization(s, state)),
        fluid));
  Spectrum& spectrum = forecast.spectrum;
  if (!s.fluid) return forecast;
  spectrum.largest_frequency = std::hypot(spectrum.largest_frequency, fluid.frequency);
  spectrum.largest_damping_rate += fluid.damping;
  spectrum.smallest_frequency = kNaN;
  return forecast;
}

}  // namespace feder
