// Scenes with contacts against mechanics and Coulomb's law, by ways that do not use their formulas.
#include <gtest/gtest.h>

#include <Eigen/QR>
#include <cmath>
#include <numbers>

#include "engine/contacts.h"
#include "engine/kkt.h"
#include "models/bouncing_ball.h"
#include "models/catalog.h"
#include "models/drop.h"
#include "models/incline.h"
#include "models/ladder.h"
#include "models/rolling_ball.h"

namespace feder {
namespace {

// ---- Exact motions between impacts

// M a - f of the exact motion at t, from second differences; spins in principal axes.
VectorXd missing_force(const Model& model, double t) {
  const System& s = model.system;
  const double e = model.end_time / 4000.0;
  const auto v = [&](double at) { return model.exact(at).v; };
  const VectorXd a = (8.0 * (v(t + e) - v(t - e)) - (v(t + 2.0 * e) - v(t - 2.0 * e))) / (12.0 * e);
  VectorXd f;
  const State at = model.exact(t);
  EXPECT_TRUE(evaluate_forces(s, at, f).ok());
  add_gyroscopic_torques(s, at.v, f);
  return s.inertia.cwiseProduct(a) - f;
}

// How far, relative to the weight, M a - f is from what contacts can give: pushes only, friction -mu y_n
// along the slip where there is slip and within the cone where there is none.
double coulomb_defect(const Model& model, double t) {
  const System& s = model.system;
  const State at = model.exact(t);
  const VectorXd missing = missing_force(model, t);
  const double weight = s.forces.constant.norm();
  ContactRows rows;
  ContactFinder(s).find(at, 1e-9, rows);
  std::erase_if(rows.contacts, [](const Contact& c) { return std::abs(c.at.gap) > 1e-12; });
  const int k = rows.count();
  if (k == 0) return missing.norm() / weight;
  VectorXd u;
  rows.driven.setZero(3 * k);
  rows.velocities(at.v, u);
  double defect = 0.0;
  Eigen::MatrixXd columns(missing.size(), 3 * k);
  for (int i = 0; i < 3 * k; ++i) {
    VectorXd column = VectorXd::Zero(missing.size()), y = VectorXd::Zero(3 * k);
    y[i] = 1.0;
    const Eigen::Vector2d slip = u.segment<2>(3 * (i / 3) + 1);
    const double mu = rows.contacts[i / 3].surface.friction, speed = slip.norm();
    if (speed > 1e-9 || mu == 0.0) {  // the tangents follow the normal
      if (i % 3 != 0) y[i] = 0.0;
      if (i % 3 == 0 && speed > 1e-9) y.segment<2>(i + 1) = -mu * slip / speed;
    }
    rows.add_impulses(y, column);
    columns.col(i) = column;
    if (i % 3 == 0) defect = std::max(defect, std::abs(u[i]));
  }
  // least norm; then again with the friction shared out as the pushes are
  VectorXd share = VectorXd::Ones(3 * k), y;
  for (int pass = 0; pass < 2; ++pass) {
    y = share.cwiseProduct((columns * share.asDiagonal()).completeOrthogonalDecomposition().solve(missing));
    for (int i = 0; i < k; ++i) share.segment<2>(3 * i + 1).setConstant(std::sqrt(std::max(0.0, y[3 * i])));
  }
  for (int i = 0; i < k; ++i) {
    const double mu = rows.contacts[i].surface.friction;
    defect =
        std::max({defect, -y[3 * i] / weight, (y.segment<2>(3 * i + 1).norm() - mu * y[3 * i]) / weight});
  }
  return std::max(defect, (columns * y - missing).norm() / weight);
}

class ContactMotion : public testing::TestWithParam<const char*> {};

TEST_P(ContactMotion, ObeysNewtonAndCoulomb) {
  const Model model = make_model(GetParam());
  for (double part : {0.05, 0.13, 0.37, 0.63, 0.8})
    EXPECT_LT(coulomb_defect(model, part * model.end_time), 1e-11) << part;  // 4e-13
}

INSTANTIATE_TEST_SUITE_P(Models, ContactMotion,
                         testing::Values("incline", "incline:friction=0.7", "incline:speed=-1.3,friction=0.4",
                                         "incline:speed=-2,friction=0.8",
                                         "incline:speed=1,friction=0.7,angle=0.5", "rolling_ball",
                                         "rolling_ball:speed=-1,spin=30",
                                         "rolling_ball:hollow=0.9,friction=0.1", "ladder",
                                         "ladder:angle=0.9,length=0.7,radius=0.1", "stack", "drop",
                                         "drop:start=edge,restitution=1", "drop:start=face,restitution=0",
                                         "bouncing_ball:speed=-1,spin=40,friction=0.6",
                                         "bouncing_ball:restitution=0,speed=1,friction=0.1"));

TEST(ContactMotion, TheTestRefusesTheWrongFriction) {
  Model model = make_model("incline:friction=0.3");
  model.exact = make_model("incline:friction=0.31").exact;
  EXPECT_GT(coulomb_defect(model, 0.3), 1e-3);  // 8e-3
}

TEST(ContactScenes, StartWithoutPenetration) {
  int scenes = 0;
  for (const ModelInfo& info : catalog()) {
    const Model model = make_model(info.name);
    if (model.system.colliders.empty()) continue;
    ++scenes;
    EXPECT_GE(ContactFinder(model.system).smallest_gap(model.state, 1.0), -1e-15) << info.name;
  }
  EXPECT_GE(scenes, 9);
}

// ---- Closed forms in the words of textbooks

TEST(Incline, RestsUpToTheAngleOfFriction) {
  for (double angle : {0.1, 0.5, 1.0}) {
    Incline o{.angle = angle, .friction = std::tan(angle) * (1.0 + 1e-12)};
    EXPECT_EQ(incline_slide(o, 5.0).way, 0.0);
    o.friction = std::tan(angle) * (1.0 - 1e-6);
    EXPECT_GT(incline_slide(o, 5.0).way, 0.0);
  }
}

TEST(Incline, ComesBackToItsStartSlowerThanItLeft) {
  // up at deceleration g (sin + mu cos), down at g (sin - mu cos): v_back^2 / v^2 is their ratio
  const Incline o{.angle = 0.8, .friction = 0.4, .speed = -3.0};
  double low = 0.5, high = 5.0;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (incline_slide(o, middle).way < 0.0 ? low : high) = middle;
  }
  const double up = std::sin(0.8) + 0.4 * std::cos(0.8), down = std::sin(0.8) - 0.4 * std::cos(0.8);
  EXPECT_NEAR(incline_slide(o, low).speed, 3.0 * std::sqrt(down / up), 1e-12);
}

TEST(RollingBall, EndsAtFiveSeventhsOfItsSpeed) {
  const auto end = [](const char* spec) {
    const Model model = make_model(spec);
    return model.exact(model.end_time).v[3 * model.system.bodies[0].centre];
  };
  EXPECT_NEAR(end("rolling_ball:speed=2"), 10.0 / 7.0, 1e-14);
  EXPECT_NEAR(end("rolling_ball:speed=2,hollow=0.999"), 6.0 / 5.0, 1e-3);  // a shell keeps 3/5
  EXPECT_NEAR(end("rolling_ball:speed=0,spin=21"), 2.0 / 7.0 * 2.1, 1e-14);
}

TEST(RollingBall, AHoleMakesItsInertiaThatOfTheDifference) {
  const double R = 0.3, hole = 0.6 * R, whole = R * R * R, missing = hole * hole * hole;
  const double I = solid_sphere("", whole, R).inertia(0, 0) - solid_sphere("", missing, hole).inertia(0, 0);
  EXPECT_NEAR(ball_inertia_ratio(0.6), I / ((whole - missing) * R * R), 1e-15);
}

TEST(Ladder, ThinOneNeedsHalfTheCotangent) {
  const Ladder o{.radius = 1e-9, .angle = 1.1};
  EXPECT_NEAR(ladder_threshold(o), 0.5 / std::tan(1.1), 1e-8);
}

TEST(Ladder, EquallyRoughOnBothSidesItStandsUpToTwiceTheAngleOfFriction) {
  // thin, mu = tan(beta) on floor and wall: it stands for angle >= pi/2 - 2 beta
  for (double beta : {0.1, 0.3, 0.6}) {
    const Ladder o{
        .radius = 1e-9, .angle = 0.5 * std::numbers::pi - 2.0 * beta, .wall_friction = std::tan(beta)};
    EXPECT_NEAR(ladder_threshold(o), std::tan(beta), 1e-8);
  }
}

TEST(Ladder, LeavesTheWallWhereTheWallNoLongerPushes) {
  for (double angle : {0.4, 1.0, 1.4}) {
    const Ladder o{.angle = angle};
    Model model = make_ladder(o);
    const double t = ladder_leaving_time(o);
    const State at = model.exact(t);
    const int centre = 3 * model.system.bodies[0].centre;
    const double half = std::sin(angle) * o.length / 2.0;
    EXPECT_NEAR(at.q[centre + 1] - o.radius, 2.0 / 3.0 * half, 1e-12);
    const double weight = o.mass * o.gravity, before = missing_force(model, 0.9 * t)[centre],
                 after = missing_force(model, 1.05 * t)[centre];
    EXPECT_GT(before, 1e-3 * weight);
    EXPECT_NEAR(missing_force(model, t)[centre], 0.0, 1e-8 * weight);
    EXPECT_LT(after, -1e-3 * weight);
  }
}

TEST(Drop, LosesTheEnergyOfNotesD3) {
  for (const auto start : {DropStart::kFace, DropStart::kEdge, DropStart::kCorner})
    for (double e : {0.2, 0.8, 1.0}) {
      const Drop o{.start = start, .tilt = 0.3, .restitution = e, .mass = 2.0};
      const DropImpact hit = drop_impact(o);
      const double v = std::sqrt(2.0 * o.gravity * o.height), I = o.mass * o.edge * o.edge / 6.0;
      const double change =
          0.5 * o.mass * (hit.velocity * hit.velocity - v * v) + 0.5 * I * hit.spin * hit.spin;
      const double k = (1.0 + e) * v / hit.impulse;  // the denominator of D3
      EXPECT_NEAR(change, -(1.0 - e * e) * v * v / (2.0 * k), 1e-12);
    }
}

TEST(Drop, TouchesAgainWhenTheFlightEnds) {
  for (const char* spec :
       {"drop", "drop:start=edge", "drop:start=edge,tilt=0.6", "drop:tilt=-0.5,restitution=1",
        "drop:start=face", "drop:start=edge,restitution=0.1"}) {
    const Model model = make_model(spec);
    const double first = std::sqrt(2.0 * 0.5 / 9.81), flight = (model.end_time - first) / 0.9;
    ContactFinder finder(model.system);
    const auto gap = [&](double t) { return finder.smallest_gap(model.exact(t), 10.0); };
    EXPECT_NEAR(gap(first), 0.0, 1e-13) << spec;
    EXPECT_NEAR(gap(first + flight), 0.0, 1e-12) << spec;
    for (int i = 1; i < 200; ++i) EXPECT_GT(gap(first + i / 200.0 * flight), 0.0) << spec << " " << i;
  }
}

TEST(BouncingBall, TouchesThePlaneAtItsBounces) {
  const BouncingBall o{.restitution = 0.8, .speed = 1.0, .friction = 0.1};
  const Model model = make_bouncing_ball(o);
  const int y = 3 * model.system.bodies[0].centre + 1;
  for (int n = 1; n < 12; ++n) {
    const double t = bounce_time(o, n), next = bounce_time(o, n + 1);
    EXPECT_NEAR(model.exact(t).q[y], o.radius, 1e-13);
    // apex: the height falls with e^2
    EXPECT_NEAR(model.exact(0.5 * (t + next)).q[y] - o.radius, o.height * std::pow(0.64, n), 1e-13);
  }
  EXPECT_NEAR(model.exact(bounce_time(o, INFINITY)).q[y], o.radius, 1e-15);
}

}  // namespace
}  // namespace feder
