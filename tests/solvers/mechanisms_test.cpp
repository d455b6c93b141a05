// Mechanisms in motion against closed forms: small oscillations, steady precession, Freudenstein's equation
// and the slider's place, and what must be conserved.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>

#include "engine/energy.h"
#include "models/catalog.h"
#include "models/double_pendulum.h"
#include "models/four_bar.h"
#include "models/heavy_top.h"
#include "models/slider_crank.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

using Observer = std::function<bool(const State&, const History&)>;

State run(const Model& model, double dt, double end, const Observer& observer = {},
          const char* name = "leapfrog") {
  Integrator integrator = make_integrator(name, model.system);
  State state = model.state;
  History history;
  const RunResult result =
      simulate(model.system, integrator, state, history, {.dt = dt, .end_time = end, .observer = observer});
  EXPECT_TRUE(result.status.ok()) << model.name << ": " << result.status.reason;
  return state;
}

Vector3d bar_axis(const Model& model, int body, const State& at) {
  return orientation(model.system.bodies[body], at.q).col(0);
}
/// Angle of a bar about the hinges from the direction `x` of their plane [rad].
double bar_angle(const Model& model, int body, const State& at, const Vector3d& x, const Vector3d& y) {
  const Vector3d axis = bar_axis(model, body, at);
  return std::atan2(axis.dot(y), axis.dot(x));
}

/// M x'' + K x = 0 of two hanging bars with centres at half their lengths.
Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d> small_swings(const DoublePendulum& o) {
  const double l1 = o.upper_length, l2 = o.lower_length, m1 = o.upper_mass, m2 = o.lower_mass;
  auto about_end = [&](double m, double l) {
    return m * (l * l + o.width * o.width) / 12.0 + m * l * l / 4.0;
  };
  Eigen::Matrix2d M, K;
  M << about_end(m1, l1) + m2 * l1 * l1, 0.5 * m2 * l1 * l2, 0.5 * m2 * l1 * l2, about_end(m2, l2);
  K << (0.5 * m1 + m2) * l1 * o.gravity, 0.0, 0.0, 0.5 * m2 * l2 * o.gravity;
  return Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix2d>(K, M);
}

TEST(DoublePendulum, SwingsSlightlyInItsTwoModes) {
  DoublePendulum o;
  o.lower_mass = 0.6, o.lower_length = 0.3;
  const auto modes = small_swings(o);
  for (int mode = 0; mode < 2; ++mode) {
    const Eigen::Vector2d shape = modes.eigenvectors().col(mode).normalized();
    o.upper_angle = 1e-3 * shape[0], o.lower_angle = 1e-3 * shape[1];
    const Model model = make_double_pendulum(o);
    const double omega = std::sqrt(modes.eigenvalues()[mode]), dt = 2e-3 / omega;
    std::vector<double> zeros;
    double before = shape[0];
    run(model, dt, 20.0 / omega, [&](const State& s, const History&) {
      const double angle = bar_axis(model, 0, s).x();
      if (before != 0.0 && (angle > 0.0) != (before > 0.0) && s.t > 2.0 * dt)
        zeros.push_back(s.t - dt * angle / (angle - before));
      before = angle;
      return true;
    });
    ASSERT_GE(zeros.size(), 5u);
    const double measured =
        std::numbers::pi * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front());
    EXPECT_NEAR(measured / omega, 1.0, 1e-6) << mode;
  }
}

TEST(HeavyTop, PrecessesSteadilyAtConstantTilt) {
  HeavyTop o;
  o.start = TopStart::kSteady;
  const Model model = make_heavy_top(o);
  double worst = 0.0;
  const State end = run(model, 1e-4, 1.0, [&](const State& s, const History&) {
    const double tilt = std::acos(orientation(model.system.bodies[0], s.q).col(2).y());
    worst = std::max(worst, std::abs(tilt - o.tilt));
    return true;
  });
  EXPECT_LT(worst, 1e-6);
  const Vector3d axis = orientation(model.system.bodies[0], end.q).col(2);
  EXPECT_NEAR(std::atan2(axis.x(), axis.z()), steady_precession(o), 1e-5);
  RecordProperty("worst_tilt", std::to_string(worst));
}

TEST(HeavyTop, NutatesBetweenItsTurningPoints) {
  // cusps: it falls from rest to where 1 - u^2 = (u0 - u) C^2 w3^2/(2 A m g d)
  HeavyTop o;
  const Model model = make_heavy_top(o);
  const double axial = 0.5 * o.mass * o.radius * o.radius,
               across = o.mass * (3.0 * o.radius * o.radius + o.height * o.height) / 12.0 +
                        o.mass * o.distance * o.distance;
  const double u0 = std::cos(o.tilt),
               p = std::pow(axial * o.spin, 2) / (4.0 * across * o.mass * o.gravity * o.distance);
  const double u1 = p - std::sqrt(p * p - 2.0 * p * u0 + 1.0);
  double least = 1.0, largest = -1.0;
  run(model, 5e-5, 0.5, [&](const State& s, const History&) {
    const double u = orientation(model.system.bodies[0], s.q).col(2).y();
    least = std::min(least, u), largest = std::max(largest, u);
    return true;
  });
  EXPECT_GT(u0 - u1, 0.01);
  EXPECT_NEAR(largest, u0, 1e-6);
  EXPECT_NEAR(least, u1, 1e-6);
}

/// Largest change of each conserved quantity over a run, relative to its scale.
std::vector<double> drifts(const Model& model, double dt, double end) {
  std::vector<double> at_start, worst(model.conserved.size(), 0.0);
  for (const Conserved& c : model.conserved) at_start.push_back(c.value(model.system, model.state));
  const double energy = kinetic_energy(model.system, model.state) + model.scene_length * 9.81;
  run(model, dt, end, [&](const State& s, const History&) {
    for (std::size_t i = 0; i < worst.size(); ++i) {
      const double scale = i == 0 ? energy : std::abs(at_start[i]);
      worst[i] =
          std::max(worst[i], std::abs(model.conserved[i].value(model.system, s) - at_start[i]) / scale);
    }
    return true;
  });
  return worst;
}

TEST(Mechanisms, ConserveWhatTheyPromiseAtSecondOrder) {
  for (const char* spec : {"heavy_top", "double_pendulum", "n_pendulum:n=4", "four_bar", "slider_crank",
                           "flexible_linkage:damping_time=0"}) {
    const Model model = make_model(spec);
    const double end = 0.3;
    const std::vector<double> coarse = drifts(model, 5e-4, end), fine = drifts(model, 2.5e-4, end);
    for (std::size_t i = 0; i < fine.size(); ++i) {
      EXPECT_LT(fine[i], 1e-3) << spec << " " << model.conserved[i].name;
      EXPECT_TRUE(fine[i] < 1e-12 || fine[i] < 0.3 * coarse[i])
          << spec << " " << model.conserved[i].name << ": " << coarse[i] << " " << fine[i];
    }
  }
}

/// K1 cos psi - K2 cos theta + K3 = cos(theta - psi) with K1 = g/a, K2 = g/c,
/// K3 = (a^2 - b^2 + c^2 + g^2)/(2 a c)   (Freudenstein 1954; angles from the ground line).
TEST(FourBar, RockerObeysFreudensteinsEquation) {
  const FourBar o;
  const Model model = make_four_bar(o);
  const Matrix3d plane = Eigen::AngleAxisd(o.tilt, Vector3d(1.0, 2.0, 2.0) / 3.0).toRotationMatrix();
  const double k1 = o.ground / o.crank, k2 = o.ground / o.rocker,
               k3 = (o.crank * o.crank - o.coupler * o.coupler + o.rocker * o.rocker + o.ground * o.ground) /
                    (2.0 * o.crank * o.rocker);
  for (const char* name : {"leapfrog", "implicit_euler_newton"}) {
    double worst = 0.0, least = 10.0, largest = -10.0, turned = 0.0, before = o.angle;
    run(
        model, 1e-3, 1.5,
        [&](const State& s, const History&) {
          const double theta = bar_angle(model, 0, s, plane.col(0), plane.col(1)),
                       psi = bar_angle(model, 2, s, plane.col(0), plane.col(1));
          worst = std::max(worst,
                           std::abs(k1 * std::cos(psi) - k2 * std::cos(theta) + k3 - std::cos(theta - psi)));
          least = std::min(least, psi), largest = std::max(largest, psi);
          turned += std::remainder(theta - before, 2.0 * std::numbers::pi);
          before = theta;
          return true;
        },
        name);
    EXPECT_GT(turned, 2.0 * std::numbers::pi) << name;  // the crank goes round, the rocker swings
    EXPECT_GT(largest - least, 0.5) << name;
    EXPECT_LT(largest - least, 3.0) << name;
    EXPECT_LT(worst, 1e-10) << name;
  }
}

TEST(SliderCrank, SliderIsWhereTheCrankPutsIt) {
  SliderCrank o;
  for (const CrankDrive drive : {CrankDrive::kCoasting, CrankDrive::kMotor}) {
    o.drive = drive;
    const Model model = make_slider_crank(o);
    double worst = 0.0, angle_error = 0.0;
    run(model, 1e-3, 1.0, [&](const State& s, const History&) {
      const double theta = bar_angle(model, 0, s, Vector3d::UnitX(), Vector3d::UnitY());
      const double across = o.crank * std::sin(theta),
                   x = o.crank * std::cos(theta) + std::sqrt(o.rod * o.rod - across * across);
      worst = std::max(worst, (position(model.system, {.body = 2}, s.q) - x * Vector3d::UnitX()).norm());
      angle_error = std::max(
          angle_error, std::abs(std::remainder(theta - o.angle - o.speed * s.t, 2.0 * std::numbers::pi)));
      return true;
    });
    EXPECT_LT(worst, 1e-11) << static_cast<int>(drive);
    if (drive == CrankDrive::kMotor) EXPECT_LT(angle_error, 1e-11);
    if (drive == CrankDrive::kCoasting) EXPECT_GT(angle_error, 0.1);
  }
}

TEST(FlexibleLinkage, BendsButStaysClosed) {
  const Model model = make_model("flexible_linkage");
  double gap = 0.0, bend = 0.0;
  run(model, 2e-4, 0.5, [&](const State& s, const History&) {
    VectorXd phi;
    evaluate_phi(model.system, s.q, phi);
    for (int k = 0; k < model.system.rows; ++k)
      if (std::isinf(model.system.stiffness[k])) gap = std::max(gap, std::abs(phi[k]));
    bend = std::max(bend, bar_axis(model, 2, s).cross(bar_axis(model, 7, s)).norm());
    return true;
  });
  EXPECT_LT(gap, 1e-11);
  EXPECT_GT(bend, 1e-3);
  EXPECT_LT(bend, 0.5);
}

}  // namespace
}  // namespace feder
