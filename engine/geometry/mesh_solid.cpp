#include "engine/geometry/mesh_solid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

constexpr double kCorner = 1e-4;  // of the size: as close as that to an edge every face there is as near
constexpr double kBeyond = 0.02;  // of the size: how much further than the nearest another face may be
constexpr double kConvex = 1e-6;  // sine of the dihedral angle from which an edge can touch
constexpr double kRounding = 1e-12;

// Faces in the order of the corners of engine/geometry/mesh_generators.h: vertex i by the bits 0, 1, 2 of i.
const CollisionMesh& cube() {
  static const CollisionMesh mesh = [] {
    TriangleMesh out;
    for (int i = 0; i < 8; ++i) out.vertices.emplace_back(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
    out.triangles = {{0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}, {0, 1, 5}, {0, 5, 4},
                     {2, 6, 7}, {2, 7, 3}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
    return CollisionMesh("box", out);
  }();
  return mesh;
}

Aabb bounds_of_points(const std::array<Vector3d, 3>& x, double margin) {
  return {x[0].cwiseMin(x[1]).cwiseMin(x[2]).array() - margin,
          x[0].cwiseMax(x[1]).cwiseMax(x[2]).array() + margin};
}

double largest_coordinate(const CollisionMesh& mesh) {
  const Aabb& box = mesh.hierarchy().nodes().front().volume;
  return std::max(box.min.cwiseAbs().maxCoeff(), box.max.cwiseAbs().maxCoeff());
}

}  // namespace

MeshSolid::MeshSolid(const CollisionMesh& mesh, const Pose& pose)
    : mesh_(mesh), pose_(pose), stretch_(Vector3d::Ones()), box_(false), size_(largest_coordinate(mesh)) {}

MeshSolid::MeshSolid(const BoxShape& box, const Pose& pose)
    : mesh_(cube()), pose_(pose), stretch_(box.half), box_(true), size_(box.half.maxCoeff()) {}

SolidEdge MeshSolid::edge(int e) const {
  const MeshEdge& edge = mesh_.edges()[e];
  SolidEdge out{vertex(edge.a), turned(local(edge.b) - local(edge.a)), 0.0};
  out.length = out.along.norm();
  out.along /= out.length;
  return out;
}

bool MeshSolid::convex(int e) const {
  const MeshEdge& edge = mesh_.edges()[e];
  const Vector3d along = local(edge.b) - local(edge.a);
  return mesh_.face_normals()[edge.left].cross(mesh_.face_normals()[edge.right]).dot(along) >
         kConvex * along.norm();
}

std::array<Vector3d, 2> MeshSolid::beside(int e) const {
  const MeshEdge& edge = mesh_.edges()[e];
  const Vector3d along = (local(edge.b) - local(edge.a)).normalized();
  return {turned(mesh_.face_normals()[edge.left].cross(along)),
          turned(along.cross(mesh_.face_normals()[edge.right]))};
}

Aabb MeshSolid::bounds_in(const MeshSolid& other, double margin) const {
  const Aabb& box = mesh_.hierarchy().nodes().front().volume;
  const Vector3d middle = 0.5 * (box.min + box.max).cwiseProduct(stretch_);
  const Vector3d half = 0.5 * (box.max - box.min).cwiseProduct(stretch_);
  const Matrix3d turn = other.pose_.rotation.transpose() * pose_.rotation;
  const Vector3d centre = other.into(pose_.position + pose_.rotation * middle);
  const Vector3d reach = (turn.cwiseAbs() * half).array() + margin + kRounding * (size_ + other.size_);
  return {centre - reach, centre + reach};
}

Aabb MeshSolid::bounds_of(const MeshSolid& other, int t, double margin) const {
  const auto& [a, b, c] = other.mesh_.mesh().triangles[t];
  return bounds_of_points({into(other.vertex(a)), into(other.vertex(b)), into(other.vertex(c))},
                          margin + kRounding * (size_ + other.size_));
}

std::optional<SolidPoint> MeshSolid::nearest(const Vector3d& x, const Vector3d& facing, double margin) const {
  const Vector3d p = into(x), way = pose_.rotation.transpose() * facing;
  const Aabb& box = mesh_.hierarchy().nodes().front().volume;
  const Vector3d limited =
      p.cwiseMax(box.min.cwiseProduct(stretch_)).cwiseMin(box.max.cwiseProduct(stretch_));
  if ((p - limited).norm() > margin && p != limited) return std::nullopt;
  Vector3d on_surface;
  SolidPoint out = box_ ? nearest_of_box(p, on_surface) : nearest_of_mesh(p, on_surface);
  if (out.distance > margin) return std::nullopt;
  if (!way.isZero(0.0)) face_other(p, way, on_surface, out);
  if (out.distance > margin || (out.distance > 0.0 && out.outward.dot(way) > 0.0)) return std::nullopt;
  out.outward = turned(out.outward);
  return out;
}

// Near an edge the nearest face may be one that the other solid does not come from. Of the faces as near as
// it: the one most against `way`. Inside, where none is: of those not much further the nearest that is.
void MeshSolid::face_other(const Vector3d& p, const Vector3d& way, const Vector3d& on_surface,
                           SolidPoint& out) const {
  const auto visit_near = [&](const Vector3d& x, double reach, auto&& visit) {
    visit_triangles({x.array() - reach, x.array() + reach}, [&](int t) {
      const auto& [a, b, c] = mesh_.mesh().triangles[t];
      const double away = std::sqrt(closest_point({local(a), local(b), local(c)}, x).distance_squared);
      if (away <= reach) visit(mesh_.face_normals()[t], away, mesh_.face_normals()[t].dot(p - local(a)));
    });
  };
  double facing = out.outward.dot(way);
  if (std::abs(out.distance) <= kCorner * size_)
    visit_near(on_surface, kCorner * size_, [&](const Vector3d& normal, double, double distance) {
      if (!(normal.dot(way) < facing - kRounding)) return;
      facing = normal.dot(way);
      out = {normal, distance};
    });
  if (facing < 0.0 || out.distance > 0.0) return;
  double least = std::numeric_limits<double>::infinity();
  visit_near(p, kBeyond * size_ - out.distance, [&](const Vector3d& normal, double away, double distance) {
    if (!(normal.dot(way) < 0.0 && away < least)) return;
    least = away;
    out = {normal, distance};
  });
}

SolidPoint MeshSolid::nearest_of_mesh(const Vector3d& p, Vector3d& on_surface) const {
  const SurfacePoint there = *mesh_.closest_point(p, std::numeric_limits<double>::infinity());
  on_surface = there.point;
  const bool inside = there.signed_distance < 0.0;
  const Vector3d apart = inside ? Vector3d(there.point - p) : Vector3d(p - there.point);
  const bool direct = there.feature == Feature::kFace || apart.norm() <= kRounding * size_;
  return {direct ? there.normal : direction_or(apart, there.normal), there.signed_distance};
}

SolidPoint MeshSolid::nearest_of_box(const Vector3d& p, Vector3d& on_surface) const {
  on_surface = p.cwiseMax(-stretch_).cwiseMin(stretch_);
  const Vector3d apart = p - on_surface;
  int i;
  const double depth = (p.cwiseAbs() - stretch_).maxCoeff(&i);
  const Vector3d face = p[i] < 0.0 ? Vector3d(-Vector3d::Unit(i)) : Vector3d(Vector3d::Unit(i));
  if (depth > 0.0) return {direction_or(apart, face), apart.norm()};
  on_surface[i] = face[i] * stretch_[i];
  return {face, depth};
}

}  // namespace feder
