// Contacts of a mesh with a half space, a sphere and a capsule, in the axes of the mesh. Sphere: the points
// of the surface that are nearest to the centre among their neighbours. For c outside, a point x of face,
// edge or vertex counts if no triangle at it comes nearer; inside, only the nearest of all counts. Capsule:
// its ends as spheres, and between them its axis against vertices and edges of the mesh: with u the unit
// vector from the vertex or edge to the axis (turned round inside), u.(o - x) <= 0 for every neighbour o.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/geometry/collision_mesh.h"
#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

constexpr double kRounding = 1e-12;  // relative to the coordinates
// Sine of the angle by which u may leave the cone: of rounding at a vertex; lying across an edge, u is at its
// rim.
constexpr double kVertexCone = 1e-9, kEdgeCone = 0.05;
constexpr double kConvex = 1e-6;  // sine of the dihedral angle from which an edge can touch
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A number for a face, edge or vertex; below 2^30 for the largest mesh that fits the indices of edges used.
std::uint32_t surface_feature(Feature kind, int index) {
  return static_cast<std::uint32_t>(kind) << 28 | static_cast<std::uint32_t>(index);
}

Aabb around(const Vector3d& a, const Vector3d& b, double radius) {
  return {a.cwiseMin(b).array() - radius, a.cwiseMax(b).array() + radius};
}

double coordinates(const CollisionMesh& mesh) {
  const Aabb& box = mesh.hierarchy().nodes().front().volume;
  return std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
}

/// A point of the surface near a ball: the way out of the solid there, the distance of the centre, < 0
/// inside.
struct Touch {
  Vector3d point, outward;
  double distance;
  std::uint32_t feature;
};

Vector3d outward_at(const Vector3d& point, const Vector3d& normal, Feature kind, const Vector3d& centre,
                    bool inside, double rounding) {
  const Vector3d apart = inside ? Vector3d(point - centre) : Vector3d(centre - point);
  return kind == Feature::kFace || apart.norm() <= rounding ? normal : direction_or(apart, normal);
}

// The feature of the mesh that a triangle names.
int mesh_index(const CollisionMesh& mesh, int triangle, Feature kind, int local) {
  if (kind == Feature::kFace) return triangle;
  if (kind == Feature::kEdge) return mesh.edge_of(triangle, local);
  return mesh.mesh().triangles[triangle][local];
}

const Vector3d& normal_at(const CollisionMesh& mesh, Feature kind, int index) {
  return kind == Feature::kFace   ? mesh.face_normals()[index]
         : kind == Feature::kEdge ? mesh.edge_normals()[index]
                                  : mesh.vertex_normals()[index];
}

Triangle corners_of(const CollisionMesh& mesh, int triangle) {
  const auto& [a, b, c] = mesh.mesh().triangles[triangle];
  return {mesh.mesh().vertices[a], mesh.mesh().vertices[b], mesh.mesh().vertices[c]};
}

/// What triangles say about a ball: where they are nearest to it, and how near they come at each of their
/// edges and vertices.
struct Reports {
  std::vector<std::pair<int, TrianglePoint>> triangles;
  std::vector<std::pair<std::uint32_t, double>> distances;  // sorted

  Reports(const CollisionMesh& mesh, const Vector3d& centre, double reach) {
    mesh.visit_triangles(around(centre, centre, reach), [&](int t) {
      triangles.emplace_back(t, closest_point(corners_of(mesh, t), centre));
      const double distance = std::sqrt(triangles.back().second.distance_squared);
      for (Feature kind : {Feature::kFace, Feature::kEdge, Feature::kVertex})
        for (int k = 0; k < (kind == Feature::kFace ? 1 : 3); ++k)
          distances.emplace_back(surface_feature(kind, mesh_index(mesh, t, kind, k)), distance);
    });
    std::sort(distances.begin(), distances.end());
  }
  /// How near the triangles at a feature come.
  double least(std::uint32_t feature) const {
    return std::lower_bound(distances.begin(), distances.end(), std::pair(feature, 0.0))->second;
  }
};

// Points of the surface locally nearest to a centre outside, at most `reach` away.
void add_nearest_points(const CollisionMesh& mesh, const Vector3d& centre, double reach,
                        std::vector<Touch>& out) {
  const Reports reports(mesh, centre, reach);
  const double rounding = kRounding * (coordinates(mesh) + reach);
  for (const auto& [triangle, nearest] : reports.triangles) {
    const int index = mesh_index(mesh, triangle, nearest.feature, nearest.index);
    const double distance = std::sqrt(nearest.distance_squared);
    const Vector3d &x = nearest.point, &normal = normal_at(mesh, nearest.feature, index);
    const std::uint32_t feature = surface_feature(nearest.feature, index);
    if (distance > reach || normal.dot(centre - x) < -rounding) continue;
    if (reports.least(feature) < distance - rounding) continue;
    // the same point, seen from its other triangles
    if (std::any_of(out.begin(), out.end(),
                    [&](const Touch& touch) { return (touch.point - x).norm() <= 1e3 * rounding; }))
      continue;
    out.push_back({x, outward_at(x, normal, nearest.feature, centre, false, rounding), distance, feature});
  }
}

std::vector<Touch> touches(const CollisionMesh& mesh, const Vector3d& centre, double reach) {
  std::vector<Touch> out;
  const Aabb& bounds = mesh.hierarchy().nodes().front().volume;
  if ((centre - centre.cwiseMax(bounds.min).cwiseMin(bounds.max)).norm() > std::max(reach, 0.0)) return out;
  const std::optional<SurfacePoint> nearest = mesh.closest_point(centre, kInfinity);
  if (!nearest || nearest->signed_distance > reach) return out;
  if (nearest->signed_distance < 0.0) {
    const Vector3d outward = outward_at(nearest->point, nearest->normal, nearest->feature, centre, true,
                                        kRounding * coordinates(mesh));
    out.push_back({nearest->point, outward, nearest->signed_distance,
                   surface_feature(nearest->feature, nearest->index)});
  } else {
    add_nearest_points(mesh, centre, reach, out);
  }
  return out;
}

/// Between the ends of a capsule: its axis and a vertex or edge of the mesh.
class AxisContacts {
 public:
  AxisContacts(const CollisionMesh& mesh, const Vector3d& centre, const Vector3d& axis, double half,
               double reach)
      : mesh_(mesh), centre_(centre), axis_(axis), half_(half), reach_(reach) {}

  std::vector<Touch> find() {
    const Vector3d along = half_ * axis_;
    std::vector<int> edges;
    mesh_.visit_triangles(around(centre_ - along, centre_ + along, std::max(reach_, 0.0)), [&](int t) {
      const std::array<int, 3>& corner = mesh_.mesh().triangles[t];
      for (int k = 0; k < 3; ++k) {
        neighbours_.emplace_back(corner[k], corner[(k + 1) % 3]);
        edges.push_back(mesh_.edge_of(t, k));
      }
    });
    std::sort(neighbours_.begin(), neighbours_.end());
    std::sort(edges.begin(), edges.end());
    edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
    for (std::size_t first = 0, last; first < neighbours_.size(); first = last) {
      for (last = first; last < neighbours_.size() && neighbours_[last].first == neighbours_[first].first;)
        ++last;
      try_vertex(first, last);
    }
    for (int e : edges) try_edge(e);
    return std::move(out_);
  }

 private:
  // The neighbours of one vertex: each is the next corner in one of the triangles at it.
  void try_vertex(std::size_t first, std::size_t last) {
    const int v = neighbours_[first].first;
    const Vector3d& x = mesh_.mesh().vertices[v];
    const double s = axis_.dot(x - centre_);
    if (!(std::abs(s) < half_)) return;
    std::vector<Vector3d> neighbours;
    for (std::size_t k = first; k < last; ++k)
      neighbours.push_back(mesh_.mesh().vertices[neighbours_[k].second]);
    const Vector3d apart = centre_ + s * axis_ - x, &normal = mesh_.vertex_normals()[v];
    const bool meet = apart.norm() <= kRounding * coordinates(mesh_);
    const Vector3d across = meet ? Vector3d(normal - axis_.dot(normal) * axis_) : apart;
    try_point(x, centre_ + s * axis_, direction_or(across, normal), normal, neighbours, kVertexCone,
              surface_feature(Feature::kVertex, v));
  }

  void try_edge(int e) {
    const MeshEdge& edge = mesh_.edges()[e];
    const Vector3d &from = mesh_.mesh().vertices[edge.a], &to = mesh_.mesh().vertices[edge.b];
    const Vector3d &left = mesh_.face_normals()[edge.left], &right = mesh_.face_normals()[edge.right];
    if (left.cross(right).dot(to - from) < kConvex * (to - from).norm()) return;
    const double length = (to - from).norm();
    const Vector3d along = (to - from) / length, w = from - centre_;
    const double d = along.dot(axis_), sine_squared = along.cross(axis_).squaredNorm();
    if (!(sine_squared > kRounding)) return;  // parallel: the ends are nearest
    const double t = (d * axis_.dot(w) - along.dot(w)) / sine_squared, s = axis_.dot(w) + d * t;
    if (!(t > 0.0 && t < length && std::abs(s) < half_)) return;
    std::vector<Vector3d> neighbours;
    for (int triangle : {edge.left, edge.right})
      for (int v : mesh_.mesh().triangles[triangle])
        if (v != edge.a && v != edge.b) neighbours.push_back(mesh_.mesh().vertices[v]);
    try_point(from + t * along, centre_ + s * axis_, along.cross(axis_).normalized(), mesh_.edge_normals()[e],
              neighbours, kEdgeCone, surface_feature(Feature::kEdge, e));
  }

  // `across`: unit, along the line between the two points, either way.
  void try_point(const Vector3d& x, const Vector3d& on_axis, const Vector3d& across, const Vector3d& normal,
                 const std::vector<Vector3d>& neighbours, double cone, std::uint32_t feature) {
    const Vector3d outward = across.dot(normal) < 0.0 ? Vector3d(-across) : across;
    const double distance = outward.dot(on_axis - x);
    if (distance > reach_) return;
    for (const Vector3d& o : neighbours)
      if (outward.dot(o - x) > cone * (o - x).norm()) return;
    if (distance < -kRounding * coordinates(mesh_) && !enters(on_axis, -0.1 * distance)) return;
    out_.push_back({x, outward, distance, feature});
  }

  // Whether the axis is in the solid around a point of it: not out again on its other side, nor along a face.
  bool enters(const Vector3d& on_axis, double around_it) const {
    const double s = axis_.dot(on_axis - centre_);
    const auto inside = [&](double there) {
      const Vector3d p = centre_ + std::clamp(there, -half_, half_) * axis_;
      const auto nearest = mesh_.closest_point(p, kInfinity);
      return nearest && nearest->signed_distance < -1e-3 * around_it;
    };
    return inside(s - around_it) || inside(s + around_it);
  }

  const CollisionMesh& mesh_;
  const Vector3d centre_, axis_;
  const double half_, reach_;
  std::vector<std::pair<int, int>> neighbours_;  // of vertices, sorted
  std::vector<Touch> out_;
};

// From the other solid, a, of which the ball or axis at `distance` is part, to the mesh, b.
void add_touches(const std::vector<Touch>& found, const Pose& pose, double radius, std::uint32_t part,
                 ContactSink& sink) {
  for (const Touch& touch : found) {
    const Vector3d normal = -(pose.rotation * touch.outward);
    const double gap = touch.distance - radius;
    const Vector3d on_mesh = pose.position + pose.rotation * touch.point;
    sink.add(on_mesh - gap * normal, normal, gap, part << 30 | touch.feature);
  }
}

}  // namespace

void add_contacts(const HalfSpaceShape&, const Pose& plane, const MeshShape& shape, const Pose& pose,
                  ContactSink& sink) {
  const CollisionMesh& mesh = *shape.mesh;
  const Vector3d up = plane.rotation.col(2), up_in_mesh = pose.rotation.transpose() * up;
  const double height = up.dot(pose.position - plane.position);
  // vertices of the triangles in boxes that reach down to the margin
  std::vector<int> low, stack{0};
  while (!stack.empty()) {
    const BvhNode<Aabb>& node = mesh.hierarchy().nodes()[stack.back()];
    stack.pop_back();
    const Vector3d middle = 0.5 * (node.volume.min + node.volume.max);
    const double reach = up_in_mesh.cwiseAbs().dot(node.volume.max - middle);
    const double rounding = kRounding * (std::abs(height) + coordinates(mesh));
    if (height + up_in_mesh.dot(middle) - reach > sink.margin + rounding) continue;
    if (node.count == 0) stack.insert(stack.end(), {node.first, node.first + 1});
    for (int k = node.first; k < node.first + node.count; ++k)
      low.insert(low.end(), mesh.hierarchy().indices(k).begin(), mesh.hierarchy().indices(k).end());
  }
  std::sort(low.begin(), low.end());
  low.erase(std::unique(low.begin(), low.end()), low.end());
  for (int v : low) {
    const Vector3d x = pose.position + pose.rotation * mesh.mesh().vertices[v];
    const double gap = up.dot(x - plane.position);
    sink.add(x - gap * up, up, gap, static_cast<std::uint32_t>(v));
  }
}

void add_contacts(const SphereShape& sphere, const Pose& sphere_pose, const MeshShape& shape,
                  const Pose& pose, ContactSink& sink) {
  const Vector3d centre = pose.rotation.transpose() * (sphere_pose.position - pose.position);
  add_touches(touches(*shape.mesh, centre, sphere.radius + sink.margin), pose, sphere.radius, 0, sink);
}

void add_contacts(const CapsuleShape& capsule, const Pose& capsule_pose, const MeshShape& shape,
                  const Pose& pose, ContactSink& sink) {
  const Vector3d centre = pose.rotation.transpose() * (capsule_pose.position - pose.position);
  const Vector3d axis = pose.rotation.transpose() * capsule_pose.rotation.col(2);
  const double reach = capsule.radius + sink.margin, half = capsule.half_length;
  add_touches(touches(*shape.mesh, centre - half * axis, reach), pose, capsule.radius, 0, sink);
  if (half == 0.0) return;
  add_touches(touches(*shape.mesh, centre + half * axis, reach), pose, capsule.radius, 1, sink);
  AxisContacts between(*shape.mesh, centre, axis, half, reach);
  add_touches(between.find(), pose, capsule.radius, 2, sink);
}

}  // namespace feder
