// One projection against the same in full, and the order of the rows.
#include "solvers/row_sweep.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "models/catalog.h"

namespace feder {
namespace {

// A rod between a point of a body and the world, the body turning by 0.1 to 2 rad in the step.
TEST(RowSweep, ProjectsBodiesWithTheJacobianOfTheConvergedStep) {
  for (const double speed : {1.0, 4.9, 5.1, 20.0}) {
    SystemBuilder builder;
    SystemBuilder::BodyStart start;
    start.angular_velocity = speed * Vector3d(0.6, 0.0, 0.8);
    const Anchor body = builder.add_body(solid_box("box", 2.0, {0.3, 0.2, 0.1}), start);
    AnchorDistanceRow rod;
    rod.a = {.body = body.body, .point = {0.15, 0.1, 0.0}};
    rod.b = builder.add_world_point({1, 0, 0});
    rod.stiffness = kRigid;
    rod.rest = 0.5;
    builder.add(rod);
    const auto [system, state] = builder.build();
    const double dt = 0.1;
    Kkt kkt;
    kkt.prepare(system);
    kkt.set_step(dt * dt, dt);
    VectorXd q, v = state.v, y = VectorXd::Zero(system.rows), impulse = VectorXd::Zero(v.size());
    advance(system, dt, v, state.q, q);
    ASSERT_TRUE(kkt.evaluate(q).ok());
    kkt.take_spins_over_a_step(dt, v);
    // dy = -phi / dt / (J W J^T), dv = W J^T dy
    const Stencil& stencil = system.stencils[0];
    VectorXd expected = VectorXd::Zero(v.size());
    for (int i = 0; i < 3; ++i)
      expected.segment<3>(3 * system.stencil_nodes[stencil.first_node + i]) = kkt.jacobian.segment<3>(3 * i);
    const double mobility = expected.dot(system.inverse_mass.cwiseProduct(expected)),
                 dy = -kkt.phi[stencil.first_row] / dt / mobility;
    RowSweep sweep;
    sweep.prepare(system);
    const VectorXd remembered = VectorXd::Zero(system.rows);
    sweep.begin(dt, kkt, remembered, state.q);
    double change = 0.0;
    ASSERT_TRUE(sweep.sweep(RowWeights::kMass, q, v, y, &impulse, change).ok());
    EXPECT_NEAR(y[stencil.first_row], dy, 1e-14 * std::abs(dy));
    EXPECT_NEAR(change, std::abs(dy) * std::sqrt(mobility), 1e-14 * change);
    const VectorXd dv = system.inverse_mass.cwiseProduct(expected) * dy;
    EXPECT_LT((v - state.v - dv).norm(), 1e-14 * dv.norm()) << speed;  // 4e-16
    VectorXd led;
    advance(system, dt, v, state.q, led);
    EXPECT_LT((q - led).lpNorm<Eigen::Infinity>(), 1e-15) << speed;
  }
}

TEST(RowSweep, FailsWhereAPlaceIsNotANumber) {
  const Model model = make_model("S3c(3)");
  Kkt kkt;
  kkt.prepare(model.system);
  kkt.set_step(1e-4, 1e-2);
  RowSweep sweep;
  sweep.prepare(model.system);
  VectorXd q = model.state.q, v = model.state.v, y = VectorXd::Zero(model.system.rows);
  const VectorXd remembered = y;
  sweep.begin(1e-2, kkt, remembered, model.state.q);
  double change = 0.0;
  ASSERT_TRUE(sweep.sweep(RowWeights::kMass, q, v, y, nullptr, change).ok());
  q[3 * model.system.bodies[1].centre] = std::nan("");
  EXPECT_EQ(sweep.sweep(RowWeights::kMass, q, v, y, nullptr, change).code, StatusCode::kNonFinite);
}

TEST(RowSweep, VisitsEveryActiveRowOnceAndMovingNodesOncePerColour) {
  for (const char* spec : {"S2(12)", "S3c(9)", "flexible_linkage"}) {
    const Model model = make_model(spec);
    RowSweep sweep;
    sweep.prepare(model.system);
    std::vector<int> order = sweep.order();
    EXPECT_EQ(static_cast<int>(order.size()), model.system.active_rows) << spec;
    std::sort(order.begin(), order.end());
    EXPECT_EQ(std::adjacent_find(order.begin(), order.end()), order.end()) << spec;
  }
  // a chain takes two colours, a net as many as a node has rows at least
  RowSweep chain, net;
  chain.prepare(make_model("S1(50)").system);
  net.prepare(make_model("S2(12)").system);
  EXPECT_EQ(chain.colours(), 2);
  EXPECT_GE(net.colours(), 12);
  EXPECT_LE(net.colours(), 20);
}

}  // namespace
}  // namespace feder
