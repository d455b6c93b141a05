// Lattice sums: a particle of mass m on a lattice of spacing s has the density m sum_k W(|k| s), which m
// makes the rest density; a sample starts with the part of this sum that lies in its solid.
#include "models/fluid_scene.h"

#include <algorithm>
#include <cmath>

namespace feder {
namespace {

// Calls visit(i, j, k, r) for the lattice places closer to the origin than `support`, r [m] away.
template <class Visit>
void for_each_place(int dimension, double support, double spacing, Visit&& visit) {
  const int reach = static_cast<int>(std::ceil(support / spacing));
  const int y = dimension > 1 ? reach : 0, z = dimension > 2 ? reach : 0;
  for (int i = -reach; i <= reach; ++i)
    for (int j = -y; j <= y; ++j)
      for (int k = -z; k <= z; ++k) {
        const double r = spacing * std::sqrt(1.0 * i * i + 1.0 * j * j + 1.0 * k * k);
        if (r < (1.0 - 1e-9) * support) visit(i, j, k, r);
      }
}

}  // namespace

FluidScene::FluidScene(const FluidChoice& o, int dimension, double spacing)
    : material_{.dimension = dimension,
                .kernel = o.kernel,
                .support = o.support * spacing,
                .rest_density = o.rest_density,
                .sound_speed = o.sound_speed,
                .exponent = o.exponent,
                .viscosity = o.viscosity},
      spacing_(spacing) {
  double sum = 0.0;
  if (smooths_density(o.kernel))  // Fluid refuses the others
    for_each_place(dimension, material_.support, spacing, [&](int, int, int, double r) {
      sum += kernel_value(o.kernel, dimension, material_.support, r);
    });
  if (sum > 0.0) mass_ = o.rest_density / sum;
  builder.set_gravity({0.0, -o.gravity, 0.0});
  builder.set_drag(o.drag);
}

void FluidScene::add_particle(const Vector3d& position, const Vector3d& velocity) {
  const FreeMask free = static_cast<FreeMask>((1 << material_.dimension) - 1);
  nodes_.push_back(builder.add_particle(mass_, position, velocity, free).node);
}

std::vector<double> FluidScene::settled_heights(int layers, double gravity) const {
  const double c = material_.sound_speed, g = material_.exponent;
  std::vector<double> thickness(layers), heights(layers);
  for (int j = 0; j < layers; ++j) {  // p = rho_0 c^2/g ((rho/rho_0)^g - 1)
    const double depth = (layers - j - 0.5) * spacing_;
    const double ratio = std::isinf(c) ? 1.0 : std::exp(std::log1p(g * gravity * depth / (c * c)) / g);
    thickness[j] = spacing_ / ratio;
  }
  double floor = 0.0;
  for (int j = 0; j < layers; ++j) {
    heights[j] = floor + 0.5 * thickness[j];
    floor += thickness[j];
  }
  return heights;
}

void FluidScene::add_solid(const Vector3d& low, const Vector3d& high,
                           const std::function<bool(const Vector3d&)>& solid, const Anchor& holder) {
  const int D = material_.dimension, reach = static_cast<int>(std::ceil(material_.support / spacing_));
  int count[3] = {1, 1, 1}, margin[3] = {}, size[3] = {1, 1, 1};
  for (int c = 0; c < D; ++c) {
    count[c] = static_cast<int>(std::lround((high[c] - low[c]) / spacing_));
    margin[c] = reach;
    size[c] = count[c] + 2 * reach;
  }
  auto place = [&](int i, int j, int k) {
    const int at[3] = {i, j, k};
    Vector3d x = low;
    for (int c = 0; c < D; ++c) x[c] += (at[c] - margin[c] + 0.5) * spacing_;
    return x;
  };
  // which places are solid, those around the box included
  auto index = [&](int i, int j, int k) { return (static_cast<std::size_t>(i) * size[1] + j) * size[2] + k; };
  std::vector<char> inside(index(size[0] - 1, size[1] - 1, size[2] - 1) + 1);
  for (int i = 0; i < size[0]; ++i)
    for (int j = 0; j < size[1]; ++j)
      for (int k = 0; k < size[2]; ++k) inside[index(i, j, k)] = solid(place(i, j, k));
  for (int i = margin[0]; i < margin[0] + count[0]; ++i)
    for (int j = margin[1]; j < margin[1] + count[1]; ++j)
      for (int k = margin[2]; k < margin[2] + count[2]; ++k) {
        if (!inside[index(i, j, k)]) continue;
        double density = 0.0;
        bool near_fluid = false;
        for_each_place(D, material_.support, spacing_, [&](int a, int b, int c, double r) {
          if (inside[index(i + a, j + b, k + c)])
            density += mass_ * kernel_value(material_.kernel, D, material_.support, r);
          else
            near_fluid = true;
        });
        Anchor at = holder;
        at.point = place(i, j, k);
        if (near_fluid) boundary_.push_back({at, mass_ / material_.rest_density, density});
      }
}

void FluidScene::add_tank(double length, double height, double depth) {
  const bool plane = material_.dimension == 2;
  const double wall = std::ceil(material_.support / spacing_) * spacing_;
  const Vector3d low(-wall, -wall, plane ? 0.0 : -wall),
      high(length + wall, height, plane ? 0.0 : depth + wall);
  add_solid(low, high, [=](const Vector3d& x) {
    return x[0] < 0.0 || x[0] > length || x[1] < 0.0 || (!plane && (x[2] < 0.0 || x[2] > depth));
  });
}

Model FluidScene::finish(const std::string& name) {
  builder.set_fluid(std::make_shared<Fluid>(material_, nodes_, boundary_));
  auto [system, state] = builder.build();
  return {name, std::move(system), std::move(state)};
}

std::vector<Conserved> conserved_by_fluid(const FluidChoice& o) {
  if (o.drag > 0.0 || o.viscosity > 0.0 || std::isinf(o.sound_speed)) return {};
  return {conserved_energy()};
}

}  // namespace feder
