#pragma once

#include <limits>
#include <vector>

#include "engine/anchor_rows.h"
#include "engine/fluid/fluid_pairs.h"
#include "engine/fluid/smoothing_kernel.h"
#include "engine/state.h"

namespace feder {

struct System;

/// What a fluid is like. D is `dimension`; in the plane masses are per metre of depth.
struct FluidMaterial {
  int dimension = 3;  ///< 1: x, 2: x and y; particles must be masked along the others
  SmoothingKernel kernel = SmoothingKernel::kWendland2;
  double support = 0.0;       ///< h, where W ends [m]
  double rest_density = 1e3;  ///< rho_0 [kg/m^D]
  double sound_speed = 10.0;  ///< c at rest density [m/s]; infinite: incompressible
  double exponent = 7.0;      ///< of the equation of state: 1 linear, 7 Tait
  double viscosity = 0.0;     ///< dynamic, mu [Pa s]
  double wall_drag = 0.0;     ///< part of mu between fluid and boundary samples: 0 slips, 1 sticks
  bool clamp_tension = true;  ///< no pressure below 0: free surfaces do not pull
};

/// A point of what bounds a fluid: of a body, a node, or with Anchor{.point = x} of the world.
struct BoundarySample {
  Anchor at;
  /// [m^D]; 0: 1 / sum_k W over the samples of the same holder (Akinci et al.), for one layer on a surface.
  double volume = 0.0;
  /// What all of its solid gives to the density at the sample [kg/m^D]: the sample then has a pressure of its
  /// own, as fluid has. 0: none, the fluid next to it carries twice the pressure.
  double density = 0.0;
};

/// Particles that are smoothed mass (notes G1). Their internal energy sum m_i u(rho_i) gives the forces, so
/// energy, momentum and angular momentum are those of a mechanical system; boundary samples, held by bodies,
/// nodes or the world, enter the density with the mass rho_0 V and take the reaction (Akinci et al., ACM TOG
/// 31, 2012). An incompressible fluid has no pressure force: its densities are rows (density_rows.h) that
/// symplectic Euler holds.
///
/// Evaluations use a workspace of the calling thread; results depend on their arguments alone.
class Fluid {
 public:
  /// particles: nodes. InputError names the bad number.
  Fluid(const FluidMaterial& material, std::vector<int> particles, std::vector<BoundarySample> boundary = {});

  /// Called by SystemBuilder::build: checks nodes and masks, finds places and volumes of the boundary
  /// samples.
  void resolve(const System& system, const VectorXd& q);

  const FluidMaterial& material() const { return material_; }
  const std::vector<int>& particles() const { return particles_; }
  const std::vector<Place>& samples() const { return samples_; }  ///< resolved; node -1: the world
  const std::vector<double>& masses() const { return masses_; }   ///< of particles, then of samples [kg]
  bool incompressible() const { return material_.sound_speed == std::numeric_limits<double>::infinity(); }

  /// Energy is not kept: viscosity takes some, and rows of density do.
  bool dissipates() const { return material_.viscosity > 0.0 || incompressible(); }
  /// Particles, and samples with a density of their own.
  bool has_pressure(int point) const {
    const int sample = point - static_cast<int>(particles_.size());
    return sample < 0 || own_densities_[sample] > 0.0;
  }
  /// p(rho) [Pa m^(3-D)], 0 if incompressible.
  double pressure(double density) const;
  /// u(rho) with du/drho = p/rho^2 and u(rho_0) = 0 [J/kg].
  double energy_per_mass(double density) const;

  /// f += pressure and viscous forces, 3 per node; where a position is not finite the first bad node gets NaN
  /// along every axis, and with a boundary sample all particles.
  void add_forces(const VectorXd& q, const VectorXd& v, VectorXd& f) const;
  /// sum m_i u(rho_i) [J]; NaN where a position is not finite.
  double energy(const VectorXd& q) const;
  /// rho per particle, in the order of particles() [kg/m^D].
  void densities(const VectorXd& q, VectorXd& rho) const;
  /// All pairs at q; false where a position is not finite, `bad` is then the point.
  bool find_pairs(const VectorXd& q, FluidPairs& pairs, int* bad = nullptr) const;

 private:
  void check_particles(const System& system) const;
  void find_volumes(const VectorXd& q);

  FluidMaterial material_;
  std::vector<int> particles_;
  std::vector<BoundarySample> boundary_;
  std::vector<Place> samples_;
  std::vector<double> masses_, own_densities_;  // own: of samples
};

/// World place of a boundary sample.
Vector3d sample_position(const Place& sample, const VectorXd& q);

}  // namespace feder
