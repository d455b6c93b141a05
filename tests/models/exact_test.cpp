// Every exact solution of the catalogue and of these variants obeys its own equation of motion.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <vector>

#include "engine/body.h"
#include "engine/energy.h"
#include "engine/kkt.h"
#include "models/catalog.h"

namespace feder {
namespace {

std::vector<std::string> specs_with_exact() {
  std::vector<std::string> specs;
  for (const ModelInfo& info : catalog())
    if (make_model(info.name).exact) specs.push_back(info.name);
  for (const char* spec : {"oscillator:amplitude=-0.3,stiffness=7,mass=0.3",
                           "damped_oscillator:damping_time=0,drag=1,velocity=2",
                           "damped_oscillator:damping_time=0.2",  // critical: tau omega = 2
                           "damped_oscillator:damping_time=0.7",
                           "damped_oscillator:damping_time=0.1,drag=30,velocity=-1",
                           "pendulum:angle=0.1",
                           "pendulum:angle=3.14",
                           "chain:n=1,modes=1:0.01",
                           "chain:n=100,modes=-1:1e-3",
                           "chain:damping_time=1e-3,drag=0.1,modes=1:1e-2/-1:1e-2",
                           "incline:speed=-1.3,friction=0.4",
                           "incline:speed=-2,friction=0.8",
                           "incline:speed=1,friction=0.7,angle=0.5",
                           "incline:friction=0",
                           "rolling_ball:speed=-1,spin=30",
                           "rolling_ball:hollow=0.9,friction=0.1",
                           "rolling_ball:friction=0",
                           "ladder:angle=0.9,length=0.7,radius=0.1",
                           "ladder:floor_friction=0.5",
                           "drop:start=face",
                           "drop:start=face,restitution=0",
                           "drop:start=edge,tilt=-0.5,restitution=1",
                           "drop:restitution=1",
                           "bouncing_ball:speed=1,friction=0.05",
                           "bouncing_ball:speed=-1,spin=40,friction=0.6",
                           "bouncing_ball:restitution=0,speed=1,friction=0.1",
                           "bouncing_ball:restitution=1,speed=0.5"})
    specs.push_back(spec);
  return specs;
}

std::vector<std::string> specs_where(bool (*wanted)(const Model&)) {
  std::vector<std::string> specs;
  for (const std::string& spec : specs_with_exact())
    if (wanted(make_model(spec))) specs.push_back(spec);
  return specs;
}

class Exact : public testing::TestWithParam<std::string> {
 protected:
  Model model = make_model(GetParam());
  // n-th part of the end time: fine against the fastest motion of these scenes, coarse against rounding
  double part(double n) const { return model.end_time / n; }
};

class ExactMoving : public Exact {};
class ExactOnSprings : public Exact {};
class ExactUndamped : public Exact {};

TEST_P(Exact, StartsBitwiseAtTheInitialState) {
  const State s = model.exact(0.0);
  EXPECT_EQ(s.t, 0.0);
  EXPECT_TRUE(s.q == model.state.q) << (s.q - model.state.q).cwiseAbs().maxCoeff();
  EXPECT_TRUE(s.v == model.state.v) << (s.v - model.state.v).cwiseAbs().maxCoeff();
}

TEST_P(ExactMoving, VelocityIsTheRateOfPosition) {
  double worst = 0.0, largest = 0.0;
  for (double t : {0.1, 0.37, 0.8}) {
    const double at = t * model.end_time, e = part(4000.0);
    const VectorXd rate = (8.0 * (model.exact(at + e).q - model.exact(at - e).q) -
                           (model.exact(at + 2.0 * e).q - model.exact(at - 2.0 * e).q)) /
                          (12.0 * e);
    const State s = model.exact(at);
    VectorXd v;
    position_rate(model.system, s.q, s.v, v);
    largest = std::max(largest, v.cwiseAbs().maxCoeff());
    worst = std::max(worst, (rate - v).cwiseAbs().maxCoeff());
  }
  ASSERT_GT(largest, 0.0);
  EXPECT_LT(worst, 1e-6 * largest);  // 2.0e-7 (pendulum from 3.14), others 7e-9
}

TEST_P(ExactOnSprings, ObeysTheEquationOfMotion) {
  double worst = 0.0, largest = 0.0;
  for (double t : {0.1, 0.37, 0.8}) {
    // fourth order second difference
    const double at = t * model.end_time, e = part(2000.0);
    const State s = model.exact(at);
    const VectorXd a = (16.0 * (model.exact(at + e).q + model.exact(at - e).q) - model.exact(at + 2.0 * e).q -
                        model.exact(at - 2.0 * e).q - 30.0 * s.q) /
                       (12.0 * e * e);
    VectorXd f;
    ASSERT_TRUE(evaluate_forces(model.system, s, f).ok());
    f.array() *= (model.system.inverse_mass.array() > 0.0).cast<double>();
    largest = std::max(largest, f.cwiseAbs().maxCoeff());
    worst = std::max(worst, (model.system.inertia.cwiseProduct(a) - f).cwiseAbs().maxCoeff());
  }
  ASSERT_GT(largest, 0.0);
  EXPECT_LT(worst, 1e-6 * largest);  // 2.0e-7 (100 masses, highest mode), others 1.1e-8
}

TEST_P(ExactUndamped, KeepsEveryConservedQuantity) {
  double largest = 0.0;
  for (int i = 0; i <= 50; ++i)
    largest = std::max(largest, kinetic_energy(model.system, model.exact(i * model.end_time / 50.0)));
  ASSERT_GT(largest, 0.0);
  for (const Conserved& c : model.conserved) {
    const double start = c.value(model.system, model.state);
    double worst = 0.0;
    for (int i = 0; i <= 50; ++i) {
      const State s = model.exact(i * model.end_time / 50.0);
      worst = std::max(worst, std::abs(c.value(model.system, s) - start));
    }
    EXPECT_LT(worst, 1e-11 * largest) << c.name;  // 2.7e-13
  }
}

std::string test_name(const testing::TestParamInfo<std::string>& instance) {
  std::string name = instance.param;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name + "_" + std::to_string(instance.index);
}

INSTANTIATE_TEST_SUITE_P(Models, Exact, testing::ValuesIn(specs_with_exact()), test_name);
INSTANTIATE_TEST_SUITE_P(Models, ExactMoving, testing::ValuesIn(specs_where([](const Model& m) {
                           return kinetic_energy(m.system, m.exact(0.1 * m.end_time)) > 0.0;
                         })),
                         test_name);
// rods: see pendulum_test.cpp; contacts: see contact_scenes_test.cpp
INSTANTIATE_TEST_SUITE_P(Models, ExactOnSprings, testing::ValuesIn(specs_where([](const Model& m) {
                           return !m.system.has_hard_rows && m.system.colliders.empty();
                         })),
                         test_name);
INSTANTIATE_TEST_SUITE_P(Models, ExactUndamped,
                         testing::ValuesIn(specs_where([](const Model& m) { return !m.conserved.empty(); })),
                         test_name);

}  // namespace
}  // namespace feder
