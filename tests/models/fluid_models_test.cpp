// Scenes of fluids: what their lattices and walls promise at the start.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/fluid/fluid.h"
#include "models/bath.h"
#include "models/catalog.h"
#include "models/dam_break.h"
#include "models/floating_body.h"
#include "models/hydrostatic_column.h"
#include "tests/support/refused.h"

namespace feder {
namespace {

using test::refused;

// Largest |rho / rho_0 - 1| of the particles deeper than the support of the kernel below the surface.
double density_error(const Model& model, double surface) {
  const Fluid& fluid = *model.system.fluid;
  VectorXd rho;
  fluid.densities(model.state.q, rho);
  double error = 0.0;
  int counted = 0;
  for (std::size_t i = 0; i < fluid.particles().size(); ++i)
    if (model.state.q[3 * fluid.particles()[i] + 1] < surface - fluid.material().support) {
      error = std::max(error, std::abs(rho[i] / fluid.material().rest_density - 1.0));
      ++counted;
    }
  EXPECT_GT(counted, 20);
  return error;
}

TEST(FluidScene, WallsContinueTheLatticeSoThatItFeelsNone) {
  // corners included
  EXPECT_LT(density_error(make_model("hydrostatic_column:sound_speed=inf"), 1.0), 1e-12);
  EXPECT_LT(
      density_error(make_model("hydrostatic_column:sound_speed=inf,kernel=cubic_spline,support=2.3"), 1.0),
      1e-12);
  EXPECT_LT(density_error(make_model("bath:sound_speed=inf,layers=8"), 8 * 0.08), 1e-12);
}

TEST(FluidScene, ABoxFillsTheHoleItLeavesInTheLattice) {
  EXPECT_LT(density_error(make_model("floating_body:sound_speed=inf"), 1.0), 1e-12);
}

TEST(FluidScene, LayersStartWithThePressureOfTheWeightAbove) {
  const Model model = make_hydrostatic_column();
  const Fluid& fluid = *model.system.fluid;
  VectorXd rho;
  fluid.densities(model.state.q, rho);
  for (int layer = 2; layer < 16; ++layer) {
    const int i = 8 * layer + 4;
    const double depth = 1.0 - model.state.q[3 * fluid.particles()[i] + 1];
    EXPECT_NEAR(fluid.pressure(rho[i]) / (1000.0 * 9.81 * depth), 1.0, 0.03) << layer;  // 0.979 to 0.991
  }
}

TEST(FluidScene, DraftIsArchimedesWhereTheBoxStarts) {
  FloatingBody options;
  options.sound_speed = std::numeric_limits<double>::infinity();
  const Model model = make_floating_body(options);
  EXPECT_NEAR(draft(options, model.system, model.state), 6 * options.spacing, 1e-12);
}

TEST(FluidScene, TheHoleOfARingStaysOpen) {
  const Model model = make_model("bath:shape=torus,radius=0.4,spacing=0.04,columns=22,layers=4");
  const Fluid& fluid = *model.system.fluid;
  const Body& body = model.system.bodies[0];
  const Vector3d centre = model.state.q.segment<3>(3 * body.centre);
  int held = 0;
  double inner = 1.0, outer = 0.0;
  for (const Place& sample : fluid.samples()) {
    if (sample.node != body.centre) continue;
    const Vector3d x = sample_position(sample, model.state.q) - centre;
    inner = std::min(inner, std::hypot(x[0], x[1]));
    outer = std::max(outer, std::hypot(x[0], x[1]));
    ++held;
  }
  EXPECT_GT(held, 200);
  EXPECT_GT(inner, 0.3 * 0.4 - 0.04);  // axis z, tube 0.35 of the radius
  EXPECT_LT(outer, 0.4);
}

TEST(FluidScene, FrontNeedsNeighbours) {
  Model model = make_dam_break();
  const double reach = 1.5 * 0.5 / 20;
  EXPECT_NEAR(front(model.system, model.state, reach), 1.0, 0.03);
  const int drop = model.system.fluid->particles()[0];
  model.state.q.segment<3>(3 * drop) = Vector3d(2.0, 0.5, 0.0);
  EXPECT_NEAR(front(model.system, model.state, reach), 1.0, 0.03);
}

TEST(FluidScene, WrongSettingsAreNamed) {
  EXPECT_TRUE(refused("kernel = viscosity", [] { (void)make_model("bath:kernel=viscosity"); }));
  EXPECT_TRUE(refused("support", [] { (void)make_model("dam_break:support=0.5"); }));
  EXPECT_TRUE(
      refused("length = 0.5 m, expected more than width", [] { (void)make_model("dam_break:length=0.5"); }));
  EXPECT_TRUE(refused("columns = 10, expected at least wide + 4",
                      [] { (void)make_model("floating_body:columns=10,wide=8"); }));
  EXPECT_TRUE(refused("layers = 5", [] { (void)make_model("floating_body:layers=5"); }));
  EXPECT_TRUE(refused("radius = 2 m", [] { (void)make_model("bath:radius=2"); }));
  EXPECT_TRUE(refused("gravity", [] { (void)make_model("hydrostatic_column:gravity=0"); }));
  EXPECT_TRUE(
      refused("particles", [] { (void)make_model("dam_break:layers=100000,width=100,length=1000"); }));
}

}  // namespace
}  // namespace feder
