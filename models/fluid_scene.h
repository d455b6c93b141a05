#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine/fluid/fluid.h"
#include "models/model.h"
#include "models/parameters.h"

namespace feder {

/// What every fluid model lets one choose.
struct FluidChoice {
  SmoothingKernel kernel = SmoothingKernel::kWendland2;
  double support = 3.0;          ///< of the kernel, in spacings
  double rest_density = 1000.0;  ///< [kg/m^3], in the plane [kg/m^2]
  double sound_speed = 30.0;     ///< [m/s], infinite: incompressible
  double exponent = 7.0;         ///< of the equation of state
  double viscosity = 0.0;        ///< [Pa s]
  double drag = 0.0;             ///< on every particle and body [kg/s]
  double gravity = 9.81;         ///< along -y [m/s^2]
};

/// Appends their fields.
template <class Options>
void add_fluid_fields(Fields<Options>& list) {
  using C = FluidChoice;
  auto member = [](auto C::*m) { return static_cast<std::decay_t<decltype(C{}.*m)> Options::*>(m); };
  list.push_back(
      field("kernel", member(&C::kernel), "smoothing kernel",
            {"spiky", "poly6", "poly6_printed", "viscosity", "cubic_spline", "wendland2", "wendland4"}));
  list.push_back(field("support", member(&C::support), "", "radius of the kernel in spacings", {1.2, 10.0}));
  list.push_back(field("rest_density", member(&C::rest_density), "kg/m^3", "of the fluid", kPositive));
  list.push_back(field("sound_speed", member(&C::sound_speed), "m/s", "at rest density; inf: incompressible",
                       kPositiveOrRigid));
  list.push_back(field("exponent", member(&C::exponent), "", "of the equation of state, 1 linear, 7 Tait",
                       {1.0, 100.0}));
  list.push_back(field("viscosity", member(&C::viscosity), "Pa s", "of the fluid", kNonNegative));
  list.push_back(
      field("drag", member(&C::drag), "kg/s", "linear drag of each particle and body", kNonNegative));
  list.push_back(field("gravity", member(&C::gravity), "m/s^2", "along -y", kPositive));
}

/// Puts particles, walls and solids of one fluid together. Solids are the lattice of the fluid continued into
/// them, as deep as the kernel sees: next to a plane wall half a spacing away a lattice of fluid feels no
/// wall.
class FluidScene {
 public:
  FluidScene(const FluidChoice& choice, int dimension, double spacing);

  SystemBuilder builder;
  double mass() const { return mass_; }  ///< of a particle: a lattice has the rest density [kg]
  int particles() const { return static_cast<int>(nodes_.size()); }

  void add_particle(const Vector3d& position, const Vector3d& velocity = Vector3d::Zero());
  /// Heights [m] above y = 0 of `layers` layers whose weight the pressure of their density carries.
  std::vector<double> settled_heights(int layers, double gravity) const;
  /// Samples of a solid within the box from low to high, at the lattice places low + (i + 1/2) spacing.
  /// `solid` tells whether a place is inside, everywhere. `holder`: Anchor{} or a body, whose axes low, high
  /// and solid are then in.
  void add_solid(const Vector3d& low, const Vector3d& high, const std::function<bool(const Vector3d&)>& solid,
                 const Anchor& holder = {});
  /// Floor at y = 0 and walls at x = 0 and x = length, z = 0 and z = depth in space, up to `height`;
  /// multiples of the spacing.
  void add_tank(double length, double height, double depth);

  Model finish(const std::string& name);

 private:
  FluidMaterial material_;
  double spacing_, mass_ = 1.0;
  std::vector<int> nodes_;
  std::vector<BoundarySample> boundary_;
};

/// "energy" unless the fluid is damped or incompressible.
std::vector<Conserved> conserved_by_fluid(const FluidChoice& choice);

}  // namespace feder
