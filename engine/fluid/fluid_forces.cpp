#include "engine/fluid/fluid_forces.h"

#include <cmath>

#include "engine/fluid/fluid.h"

namespace feder {
namespace {

constexpr double kSoftening = 1e-4;  // of the support squared, beside r^2 in the viscous force

}  // namespace

template <int D, bool kViscous>
void FluidForces::add_pairs(const FluidPairs& pairs, double softening) {
  const double* x[3] = {pairs.x[0].data(), pairs.x[1].data(), pairs.x[2].data()};
  for (int i = 0; i < pairs.size(); ++i) {
    double own[D] = {};
    for (int k = pairs.first[i]; k < pairs.first[i + 1]; ++k) {
      const int j = pairs.neighbour[k];
      double d[D], weight = -(push_[i] * pairs.mass[j] + push_[j] * pairs.mass[i]);
      for (int c = 0; c < D; ++c) d[c] = x[c][i] - x[c][j];
      if constexpr (kViscous) {
        double closing = 0.0, squared = softening;
        for (int c = 0; c < D; ++c) {
          closing += d[c] * (u_[D * i + c] - u_[D * j + c]);
          squared += d[c] * d[c];
        }
        weight += thickness_[i] * thickness_[j] * closing / squared;
      }
      weight *= pairs.slope[k];
      for (int c = 0; c < D; ++c) {
        own[c] += weight * d[c];
        f[D * j + c] -= weight * d[c];
      }
    }
    for (int c = 0; c < D; ++c) f[D * i + c] += own[c];
  }
}

void FluidForces::evaluate(const Fluid& fluid, const FluidPairs& pairs, const std::vector<double>& velocity) {
  const FluidMaterial& m = fluid.material();
  const int D = m.dimension, places = pairs.size();
  const bool viscous = m.viscosity > 0.0;
  f.assign(D * places, 0.0);
  push_.assign(places, 0.0);
  for (int i = 0; i < places; ++i)
    if (fluid.has_pressure(pairs.point(i)))
      push_[i] = pairs.mass[i] * fluid.pressure(pairs.density[i]) / (pairs.density[i] * pairs.density[i]);
  if (viscous) {
    const double root = std::sqrt(2.0 * (D + 2) * m.viscosity);
    u_.resize(D * places);
    thickness_.resize(places);
    for (int i = 0; i < places; ++i) {
      for (int c = 0; c < D; ++c) u_[D * i + c] = velocity[D * pairs.point(i) + c];
      thickness_[i] = pairs.is_fluid(i) ? root * pairs.mass[i] / pairs.density[i]
                                        : m.wall_drag * root * pairs.mass[i] / m.rest_density;
    }
  }
  const double softening = kSoftening * m.support * m.support;
  auto add = [&]<int Dimension>() {
    viscous ? add_pairs<Dimension, true>(pairs, softening) : add_pairs<Dimension, false>(pairs, softening);
  };
  if (D == 1)
    add.operator()<1>();
  else if (D == 2)
    add.operator()<2>();
  else
    add.operator()<3>();
}

}  // namespace feder
