// Volumes from the leaves to the root: children come after their parent, so that a loop from the last node to
// the first meets both before it. Boxes along the world axes merge without loss; spheres and oriented boxes
// are fitted to the triangles below each node, which lie in one piece of the leaf order: O(n log n).
#include "engine/geometry/bvh.h"

#include <string>

#include "engine/check.h"
#include "engine/geometry/aabb.h"
#include "engine/geometry/bvh_build.h"
#include "engine/geometry/bvh_volumes.h"

namespace feder {
namespace {

void check_vertices(const std::vector<Vector3d>& vertices) {
  for (std::size_t i = 0; i < vertices.size(); ++i)
    if (!vertices[i].allFinite())
      for (double x : vertices[i])
        require_finite("hierarchy, vertex " + std::to_string(i), "position", x, "m");
}

void check_indices(const TriangleMesh& mesh) {
  for (std::size_t k = 0; k < mesh.triangles.size(); ++k)
    for (int vertex : mesh.triangles[k])
      if (vertex < 0 || static_cast<std::size_t>(vertex) >= mesh.vertices.size())
        fail_input("hierarchy, triangle " + std::to_string(k), "vertex index", vertex, "",
                   "0 <= index < " + std::to_string(mesh.vertices.size()));
}

void fit_nodes(const TriangleMesh& mesh, std::vector<BvhNode<Aabb>>& nodes) {
  for (std::size_t k = nodes.size(); k-- > 0;) {
    BvhNode<Aabb>& node = nodes[k];
    if (node.count > 0)
      fit_volume(mesh, node.first, node.count, node.volume);
    else
      node.volume = merged(nodes[node.first].volume, nodes[node.first + 1].volume);
  }
}

template <class Volume>
void fit_nodes(const TriangleMesh& mesh, std::vector<BvhNode<Volume>>& nodes) {
  std::vector<std::int32_t> begin(nodes.size()), end(nodes.size());  // the positions below a node
  for (std::size_t k = nodes.size(); k-- > 0;) {
    BvhNode<Volume>& node = nodes[k];
    begin[k] = node.count > 0 ? node.first : begin[node.first];
    end[k] = node.count > 0 ? node.first + node.count : end[node.first + 1];
    fit_volume(mesh, begin[k], end[k] - begin[k], node.volume);
  }
}

}  // namespace

template <class Volume>
Bvh<Volume>::Bvh(const TriangleMesh& mesh) {
  check_vertices(mesh.vertices);
  check_indices(mesh);
  std::vector<BuildItem> items = build_items(mesh);
  const std::vector<BvhLinks> branches = build_branches(items, kBvhLeaf);
  sorted_.vertices = mesh.vertices;
  sorted_.triangles.reserve(items.size());
  order_.reserve(items.size());
  for (const BuildItem& item : items) {
    order_.push_back(item.id());
    sorted_.triangles.push_back(mesh.triangles[item.id()]);
  }
  nodes_.resize(branches.size());
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    nodes_[k].first = branches[k].first, nodes_[k].count = branches[k].count;
  fit_nodes(sorted_, nodes_);
}

template <class Volume>
void Bvh<Volume>::refit(const std::vector<Vector3d>& vertices) {
  FEDER_CHECK(vertices.size() == sorted_.vertices.size(),
              "a hierarchy is refitted with as many vertices as it was built with");
  check_vertices(vertices);
  sorted_.vertices = vertices;
  fit_nodes(sorted_, nodes_);
}

template class Bvh<Sphere>;
template class Bvh<Aabb>;
template class Bvh<Obb>;

}  // namespace feder
