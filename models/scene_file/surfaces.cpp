#include "models/scene_file/surfaces.h"

#include <cmath>
#include <numbers>

namespace feder {
namespace {

constexpr int kAround = 24, kFromPoleToPole = 12;

Vector3d on_circle(int i, double radius, double z) {
  const double angle = 2.0 * std::numbers::pi * i / kAround;
  return {radius * std::cos(angle), radius * std::sin(angle), z};
}

// A bottom vertex, rings of kAround vertices from the bottom up, a top vertex.
SceneSurface closed_rings(double bottom, const std::vector<std::pair<double, double>>& rings, double top) {
  SceneSurface surface;
  surface.vertices.push_back({0.0, 0.0, bottom});
  for (const auto& [radius, z] : rings)
    for (int i = 0; i < kAround; ++i) surface.vertices.push_back(on_circle(i, radius, z));
  surface.vertices.push_back({0.0, 0.0, top});
  const int count = static_cast<int>(rings.size()), last = 1 + count * kAround;
  auto at = [](int ring, int i) { return 1 + ring * kAround + i % kAround; };
  for (int i = 0; i < kAround; ++i) {
    surface.triangles.push_back({0, at(0, i + 1), at(0, i)});
    for (int ring = 0; ring + 1 < count; ++ring) {
      surface.triangles.push_back({at(ring, i), at(ring, i + 1), at(ring + 1, i)});
      surface.triangles.push_back({at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)});
    }
    surface.triangles.push_back({last, at(count - 1, i), at(count - 1, i + 1)});
  }
  return surface;
}

}  // namespace

SceneSurface box_surface(const Vector3d& edges) {
  SceneSurface surface;
  for (int corner = 0; corner < 8; ++corner)
    surface.vertices.push_back(
        0.5 * edges.cwiseProduct(Vector3d(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1)));
  surface.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                       {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return surface;
}

SceneSurface sphere_surface(double radius) {
  std::vector<std::pair<double, double>> rings;
  for (int ring = 1; ring < kFromPoleToPole; ++ring) {
    const double angle = std::numbers::pi * ring / kFromPoleToPole;
    rings.emplace_back(radius * std::sin(angle), -radius * std::cos(angle));
  }
  return closed_rings(-radius, rings, radius);
}

SceneSurface cylinder_surface(double radius, double height) {
  return closed_rings(-0.5 * height, {{radius, -0.5 * height}, {radius, 0.5 * height}}, 0.5 * height);
}

}  // namespace feder
