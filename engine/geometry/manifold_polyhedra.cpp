// Contacts of two meshes, or of a box and a mesh: every vertex of one at or inside the surface of the other,
// with the nearest point of that surface, and every crossing of two edges. Convex edges from p along e and
// from q along f touch along u = +-e x f/|e x f| if u points away from both faces at the first and against
// both at the second, u.(o - p) <= 0 and u.(o - q) >= 0 for their third vertices o; the gap is u.(q - p).
// Faces that lie on each other have u in the plane's normal, the limit of this, so a small angle is let pass.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "engine/geometry/collision_mesh.h"
#include "engine/geometry/manifold_pairs.h"
#include "engine/geometry/mesh_solid.h"

namespace feder {
namespace {

constexpr double kRounding = 1e-9;      // relative to the coordinates
constexpr double kCone = 0.05;          // sine of the angle by which u may leave the cones
constexpr double kSameDirection = 0.9;  // cosine, of normals of one contact area
constexpr double kParallel = 1e-6;      // sine of the angle below which edges do not cross
constexpr std::uint64_t kPairs = 1u << 30;

/// A vertex of one solid at the other.
struct VertexContact {
  int vertex;
  Vector3d normal;  // from a to b
  double gap;
};

class PolyhedraContacts {
 public:
  PolyhedraContacts(const MeshSolid& a, const MeshSolid& b, double margin)
      : a_(a), b_(b), margin_(margin), rounding_(kRounding * (a.size() + b.size())) {}

  void find(ContactSink& sink) {
    add_vertices(a_, b_, true, sink);
    add_vertices(b_, a_, false, sink);
    for (const auto& [edge_a, edge_b] : near_edges()) try_edges(edge_a, edge_b, sink);
  }

 private:
  void add_vertices(const MeshSolid& from, const MeshSolid& to, bool of_a, ContactSink& sink) {
    const Aabb reach = to.bounds_in(from, std::max(margin_, 0.0));
    std::vector<int> vertices;
    from.visit_triangles(reach, [&](int t) {
      const std::array<int, 3>& corners = from.mesh().mesh().triangles[t];
      vertices.insert(vertices.end(), corners.begin(), corners.end());
    });
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    for (int v : vertices) {
      const Vector3d x = from.vertex(v);
      const std::optional<SolidPoint> nearest =
          to.nearest(x, from.turned(from.mesh().vertex_normals()[v]), margin_);
      if (!nearest || nearest->distance > margin_) continue;
      const Vector3d normal = of_a ? Vector3d(-nearest->outward) : nearest->outward;
      const Vector3d on_a = of_a ? x : Vector3d(x - nearest->distance * normal);
      sink.add(on_a, normal, nearest->distance, (of_a ? 0u : 1u) << 30 | static_cast<std::uint32_t>(v));
      (of_a ? vertices_a_ : vertices_b_).push_back({v, normal, nearest->distance});
    }
  }

  // Pairs of convex edges of triangles whose boxes meet, sorted.
  std::vector<std::pair<int, int>> near_edges() const {
    std::vector<std::pair<int, int>> out;
    a_.visit_triangles(b_.bounds_in(a_, std::max(margin_, 0.0)), [&](int s) {
      std::array<int, 3> edges;
      std::ptrdiff_t count = 0;
      for (int i = 0; i < 3; ++i)
        if (a_.convex(a_.mesh().edge_of(s, i))) edges[count++] = a_.mesh().edge_of(s, i);
      b_.visit_triangles(b_.bounds_of(a_, s, std::max(margin_, 0.0)), [&](int t) {
        for (int j = 0; j < 3; ++j)
          if (const int q = b_.mesh().edge_of(t, j); b_.convex(q))
            for (std::ptrdiff_t i = 0; i < count; ++i) out.emplace_back(edges[i], q);
      });
    });
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  void try_edges(int edge_a, int edge_b, ContactSink& sink) const {
    const SolidEdge p = a_.edge(edge_a), q = b_.edge(edge_b);
    const Vector3d product = p.along.cross(q.along), w = q.from - p.from;
    const double sine_squared = product.squaredNorm(), d = p.along.dot(q.along);
    if (!(sine_squared > kParallel * kParallel)) return;
    const double s = (p.along.dot(w) - d * q.along.dot(w)) / sine_squared, t = d * s - q.along.dot(w);
    if (!(s > 0.0 && s < p.length && t > 0.0 && t < q.length)) return;
    Vector3d u = product / std::sqrt(sine_squared);
    if (u.dot(a_.edge_normal(edge_a) - b_.edge_normal(edge_b)) < 0.0) u = -u;
    for (const Vector3d& beside : a_.beside(edge_a))
      if (u.dot(beside) > kCone) return;
    for (const Vector3d& beside : b_.beside(edge_b))
      if (u.dot(beside) < -kCone) return;
    const double gap = u.dot(w);
    if (gap > margin_) return;
    const Vector3d on_a = p.from + s * p.along, on_b = q.from + t * q.along;
    if (gap < 0.0) {
      // overlapping edges are near each other inside both solids
      if (outside(b_, on_a, -gap) || outside(a_, on_b, -gap)) return;
      if (explained(edge_a, edge_b, u, on_a)) return;
    }
    const std::uint64_t pair =
        static_cast<std::uint64_t>(edge_a) * b_.mesh().edges().size() + static_cast<std::uint64_t>(edge_b);
    sink.add(on_a, u, gap, 2u << 30 | static_cast<std::uint32_t>(pair % kPairs));
  }

  bool outside(const MeshSolid& solid, const Vector3d& x, double depth) const {
    const std::optional<SolidPoint> there = solid.nearest(x, Vector3d::Zero(), depth + rounding_);
    return !there || there->distance > rounding_;
  }

  // An end of one of the edges touches in another direction, and parted along it the edges are clear too.
  bool explained(int edge_a, int edge_b, const Vector3d& u, const Vector3d& on_a) const {
    const auto explains = [&](const std::vector<VertexContact>& contacts, int v) {
      const auto found =
          std::lower_bound(contacts.begin(), contacts.end(), v,
                           [](const VertexContact& c, int vertex) { return c.vertex < vertex; });
      if (found == contacts.end() || found->vertex != v || found->gap > rounding_) return false;
      if (found->normal.dot(u) > kSameDirection) return false;
      const std::optional<SolidPoint> there =
          b_.nearest(on_a + found->gap * found->normal, Vector3d::Zero(), rounding_ - found->gap);
      return !there || there->distance > -rounding_;
    };
    const MeshEdge &p = a_.mesh().edges()[edge_a], &q = b_.mesh().edges()[edge_b];
    return explains(vertices_a_, p.a) || explains(vertices_a_, p.b) || explains(vertices_b_, q.a) ||
           explains(vertices_b_, q.b);
  }

  const MeshSolid &a_, &b_;
  const double margin_, rounding_;
  std::vector<VertexContact> vertices_a_, vertices_b_;  // by vertex
};

void add_polyhedra(const MeshSolid& a, const MeshSolid& b, ContactSink& sink) {
  const auto first = static_cast<std::ptrdiff_t>(sink.out.size());
  PolyhedraContacts(a, b, sink.margin).find(sink);
  // numbers of pairs of edges of large meshes may repeat
  std::sort(sink.out.begin() + first, sink.out.end(),
            [](const ContactPoint& x, const ContactPoint& y) { return x.feature < y.feature; });
  for (std::size_t k = static_cast<std::size_t>(first) + 1; k < sink.out.size(); ++k)
    sink.out[k].feature = std::max(sink.out[k].feature, sink.out[k - 1].feature + 1);
}

}  // namespace

void add_contacts(const BoxShape& box, const Pose& pose_box, const MeshShape& shape, const Pose& pose,
                  ContactSink& sink) {
  add_polyhedra(MeshSolid(box, pose_box), MeshSolid(*shape.mesh, pose), sink);
}

void add_contacts(const MeshShape& a, const Pose& pose_a, const MeshShape& b, const Pose& pose_b,
                  ContactSink& sink) {
  add_polyhedra(MeshSolid(*a.mesh, pose_a), MeshSolid(*b.mesh, pose_b), sink);
}

}  // namespace feder
