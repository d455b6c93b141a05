// From springs to rods and joints on one code path, and masses far apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include "models/catalog.h"
#include "solvers/reference.h"
#include "solvers/simulate.h"

namespace feder {
namespace {

// ---- Stiffness

constexpr double kDt = 1e-2, kEnd = 0.25;  // [s]

struct Case {
  const char *scene, *integrator, *route;
};

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> list;
    for (const char* scene : {"rigid_chain:n=10", "hanging_chain:n=10", "pendulum:angle=1.5"}) {
      for (const char* route : {"kkt", "dual", "auto"})
        list.push_back({scene, "implicit_euler_notes", route});
      for (const char* integrator : {"implicit_euler_geometric", "implicit_euler_newton"})
        for (const char* route : {"kkt", "auto"}) list.push_back({scene, integrator, route});
    }
    return list;
  }();
  return all;
}

std::string name(const Case& c) {
  return std::string(c.scene) + " " + c.integrator + " " + c.route;
}

Model model_at(const char* scene, double stiffness) {
  char text[48];
  std::snprintf(text, sizeof text, ",stiffness=%.17g", stiffness);
  return make_model(scene + std::string(text));
}

struct Outcome {
  Model model;
  State end;
};

Outcome run(const Case& c, double stiffness, std::vector<EnergyLedger>* ledgers = nullptr) {
  Outcome out{model_at(c.scene, stiffness), {}};
  IntegratorOptions options;
  options.route = c.route;
  Integrator integrator = make_integrator(c.integrator, out.model.system, options);
  out.end = out.model.state;
  History history;
  const RunResult result = simulate(out.model.system, integrator, out.end, history,
                                    {.dt = kDt, .end_time = kEnd, .ledgers = ledgers});
  EXPECT_TRUE(result.status.ok()) << name(c) << " d = " << stiffness << ": " << result.status.reason;
  return out;
}

TEST(StiffnessLimit, DistanceToRigidFallsLikeOneOverStiffnessOverFourDecades) {
  for (const Case& c : cases()) {
    const Outcome rigid = run(c, INFINITY);
    double xx = 0.0, xy = 0.0;
    for (int decade = -2; decade <= 2; ++decade) {  // d = 1e7 ... 1e11
      const Outcome soft = run(c, std::pow(10.0, 9.0 + decade));
      xx += decade * decade;
      xy += decade * std::log10(position_error(rigid.model.system, soft.end, rigid.end));
    }
    EXPECT_NEAR(xy / xx, -1.0, 0.05) << name(c);  // measured: within 1.8e-3
  }
}

TEST(StiffnessLimit, RigidRowsAreTheExtrapolatedLimit) {
  for (const Case& c : cases()) {
    const double d = 1e9;
    const Outcome rigid = run(c, INFINITY), soft = run(c, d), stiff = run(c, 10.0 * d);
    State limit = stiff.end;
    limit.q += (stiff.end.q - soft.end.q) / 9.0;
    for (const Body& b : rigid.model.system.bodies) limit.q.segment<4>(b.quaternion).normalize();
    EXPECT_LT(position_error(rigid.model.system, limit, rigid.end), 1e-8 * rigid.model.scene_length)
        << name(c);  // measured: 4.4e-11 at most
  }
}

TEST(StiffnessLimit, LedgerClosesAtBothEnds) {
  for (const Case& c : cases())
    for (const double stiffness : {100.0, double(INFINITY)}) {
      std::vector<EnergyLedger> ledgers;
      (void)run(c, stiffness, &ledgers);
      ASSERT_EQ(ledgers.size(), 25u);
      for (const EnergyLedger& ledger : ledgers)
        EXPECT_LT(std::abs(ledger.imbalance()), 1e-12 * ledger.magnitude())
            << name(c) << " d = " << stiffness;  // measured: 4.5e-14 at most
    }
}

TEST(StiffnessLimit, NewtonTakesAsManyIterationsAtEveryStiffnessAsWithRods) {
  for (const char* scene : {"rigid_chain:n=10", "rigid_chain:n=100", "hanging_chain:n=10",
                            "hanging_chain:n=100", "pendulum:angle=1.5"})
    for (const double stiffness : {1e8, 1e10, 1e12, 1e14}) {
      auto iterations = [&](double d) {
        const Model model = model_at(scene, d);
        Integrator integrator = make_integrator("implicit_euler_newton", model.system);
        State state = model.state;
        History history;
        EXPECT_TRUE(
            simulate(model.system, integrator, state, history, {.dt = kDt, .end_time = kEnd}).status.ok());
        return static_cast<double>(counts(integrator).newton_iterations);
      };
      // measured: 1.52 times (rigid_chain:n=100, 1e8); twenty times and more with cuts alone
      EXPECT_LE(iterations(stiffness), 1.75 * iterations(INFINITY)) << scene << " " << stiffness;
    }
}

TEST(StiffnessLimit, NotesStepCostsOneSolveAtEveryStiffness) {
  for (const char* scene : {"rigid_chain:n=10", "hanging_chain:n=10"})
    for (const double stiffness : {1e2, 1e8, 1e14, double(INFINITY)}) {
      const Model model = model_at(scene, stiffness);
      IntegratorOptions options;
      options.route = "dual";
      Integrator integrator = make_integrator("implicit_euler_notes", model.system, options);
      State state = model.state;
      History history;
      ASSERT_TRUE(
          simulate(model.system, integrator, state, history, {.dt = kDt, .end_time = kEnd}).status.ok());
      const PhaseTimes& times = linear_solver(integrator)->times();
      EXPECT_EQ(times.solves, 25) << scene << " " << stiffness;
      EXPECT_EQ(times.refinements, 0) << scene << " " << stiffness;
    }
}

// ---- Masses far apart

constexpr int kLinks = 8;
constexpr double kLink = 0.1, kMass = 0.1;  // [m], [kg]

/// Light links with heavy ones at the odd or even places, or a heavy load at the end.
struct Masses {
  const char* name;
  double ratio;
  bool heavy(int i) const {
    const std::string which = name;
    return which == "load" ? i + 1 == kLinks : (i % 2 == 1) == (which == "light first");
  }
  double at(int i) const { return heavy(i) ? kMass * ratio : kMass; }
};

const Masses kMasses[] = {{"light first", 1e6},  {"heavy first", 1e6},  {"load", 1e6},
                          {"light first", 1e12}, {"heavy first", 1e12}, {"load", 1e12}};

/// Falls from rest along +x, or turns as one about its fixed end.
SystemBuilder::Built bodies_on_joints(const Masses& masses, double speed) {
  SystemBuilder builder;
  Anchor last = builder.add_world_point(Vector3d::Zero());
  for (int i = 0; i < kLinks; ++i) {
    const double x = (i + 0.5) * kLink;
    const int body = builder
                         .add_body(solid_box("link", masses.at(i), {kLink, 0.2 * kLink, 0.2 * kLink}),
                                   {.position = {x, 0.0, 0.0},
                                    .velocity = {0.0, speed * x, 0.0},
                                    .angular_velocity = {0.0, 0.0, speed}})
                         .body;
    builder.add(BallRow{{last, {.body = body, .point = {-0.5 * kLink, 0.0, 0.0}}, INFINITY}});
    last = {.body = body, .point = {0.5 * kLink, 0.0, 0.0}};
  }
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

SystemBuilder::Built particles_on_rods(const Masses& masses, double speed) {
  SystemBuilder builder;
  Anchor last = builder.add_world_point(Vector3d::Zero());
  for (int i = 0; i < kLinks; ++i) {
    const double x = (i + 1) * kLink;
    const Anchor next = builder.add_particle(masses.at(i), {x, 0.0, 0.0}, {0.0, speed * x, 0.0});
    builder.add_distance(last, next, {INFINITY});
    last = next;
  }
  builder.set_gravity({0.0, -9.81, 0.0});
  return builder.build();
}

/// Every solve that is not certified to 1e-11 ends the run.
Integrator with_route(const char* integrator, const char* route, const System& system) {
  IntegratorOptions options;
  options.route = route;
  options.solve.accept_below = 1e-11;
  return make_integrator(integrator, system, options);
}

/// The reason holds a number with an exponent, like 1.3e-9.
bool carries_a_figure(const std::string& reason) {
  for (std::size_t i = 1; i + 2 < reason.size(); ++i)
    if (reason[i] == 'e' && std::isdigit(reason[i - 1]) && (reason[i + 1] == '-' || reason[i + 1] == '+'))
      return true;
  return false;
}

template <class Visit>
void for_each_mass_ratio(double speed, Visit&& visit) {
  for (const Masses& masses : kMasses)
    for (const bool joints : {true, false})
      for (const char* integrator : {"implicit_euler_notes", "implicit_euler_newton", "leapfrog"}) {
        const auto [system, state] =
            joints ? bodies_on_joints(masses, speed) : particles_on_rods(masses, speed);
        char text[96];
        std::snprintf(text, sizeof text, "%s %.0e %s %s", masses.name, masses.ratio,
                      joints ? "joints" : "rods", integrator);
        visit(masses, integrator, system, state, std::string(text));
      }
}

TEST(MassRatio, EveryStepIsCertifiedAndRoutesAgreeOrTheReasonCarriesAFigure) {
  for_each_mass_ratio(
      0.0, [](const Masses&, const char* name, const System& s, const State& start, const std::string& what) {
        Integrator kkt = with_route(name, "kkt", s);
        ASSERT_TRUE(std::visit([](auto& i) { return i.prepare(); }, kkt).ok());
        for (const char* route : {"dual", "auto"}) {
          Integrator other = with_route(name, route, s);
          const Status admitted = std::visit([](auto& i) { return i.prepare(); }, other);
          if (!admitted.ok()) {  // Newton needs Kg
            EXPECT_EQ(admitted.code, StatusCode::kRefused) << what << " " << route;
            continue;
          }
          State state = start;
          History history;
          for (int n = 0; n < 50; ++n) {
            State again = state;
            History past = history;
            const Status a = std::visit([&](auto& i) { return i.step(1e-3, state, history, nullptr); }, kkt);
            const Status b = std::visit([&](auto& i) { return i.step(1e-3, again, past, nullptr); }, other);
            EXPECT_EQ(a.ok(), b.ok()) << what << " " << route << ": " << a.reason << " / " << b.reason;
            for (const Status* status : {&a, &b})
              EXPECT_TRUE(status->ok() || carries_a_figure(status->reason)) << what << ": " << status->reason;
            if (!a.ok() || !b.ok()) break;
            ASSERT_LT((again.q - state.q).lpNorm<Eigen::Infinity>(), 1e-8 * kLinks * kLink)
                << what << " " << route << ", step " << n;  // measured: 4.7e-11 m at most
          }
          if (LinearSolver* solver = linear_solver(other))
            EXPECT_LE(solver->times().worst_backward_error, 1e-11) << what;  // measured: 2.1e-13 at most
        }
      });
}

/// Half the limit of the light masses between heavy ones: omega = 2 sqrt(T / (m l)), T the tension of the
/// turning chain. Above it the notes' step multiplies rounding although every solve is certified.
double resolved_step(const Masses& masses, double speed) {
  double tension = 0.0;
  for (int i = 0; i < kLinks; ++i) tension += masses.at(i) * (speed * speed * (i + 1) * kLink + 9.81);
  return 0.5 * std::sqrt(kMass * kLink / tension);
}

TEST(MassRatio, WholeRunsAgreeBetweenRoutesWhereTheStepResolvesTheLightMasses) {
  constexpr double kSpeed = 2.0;  // [rad/s]
  for_each_mass_ratio(kSpeed, [](const Masses& masses, const char* name, const System& s, const State& start,
                                 const std::string& what) {
    std::optional<State> first;
    const double dt = resolved_step(masses, kSpeed);
    for (const char* route : {"kkt", "dual", "auto"}) {
      Integrator integrator = with_route(name, route, s);
      State state = start;
      History history;
      const RunResult result = simulate(s, integrator, state, history, {.dt = dt, .end_time = 500.0 * dt});
      if (result.status.code == StatusCode::kRefused) continue;
      if (!result.status.ok()) {
        EXPECT_TRUE(carries_a_figure(result.status.reason)) << what << ": " << result.status.reason;
        ADD_FAILURE() << what << " " << route << " " << result.status.reason;
        continue;
      }
      if (!first) first = state;
      // relative to the way moved
      const double way = (state.q - start.q).lpNorm<Eigen::Infinity>();
      EXPECT_LT((state.q - first->q).lpNorm<Eigen::Infinity>(), 1e-8 * way)
          << what << " " << route;  // measured: 1.9e-11 at most
    }
  });
}

}  // namespace
}  // namespace feder
