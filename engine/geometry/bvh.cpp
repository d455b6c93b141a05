// Volumes from the leaves to the root: children come after their parent, so that a loop from the last node to
// the first meets both before it. Boxes along the world axes merge without loss; spheres and oriented boxes
// are fitted to the triangles below each node, which lie in one piece of the leaf order: O(n log n).
#include "engine/geometry/bvh.h"

#include <string>

#include "engine/check.h"
#include "engine/geometry/bvh_build.h"
#include "engine/geometry/bvh_volumes.h"

namespace feder {
namespace {

constexpr int kLeaf = 2;  // triangles in a leaf, at most

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

void fit_nodes(std::vector<BvhNode<Aabb>>& nodes, const std::vector<Corners>& corners) {
  for (std::size_t k = nodes.size(); k-- > 0;) {
    BvhNode<Aabb>& node = nodes[k];
    if (node.count > 0)
      fit_volume(&corners[node.first], node.count, node.volume);
    else
      node.volume = merged(nodes[node.first].volume, nodes[node.first + 1].volume);
  }
}

template <class Volume>
void fit_nodes(std::vector<BvhNode<Volume>>& nodes, const std::vector<Corners>& corners) {
  std::vector<std::int32_t> begin(nodes.size()), end(nodes.size());  // the positions below a node
  for (std::size_t k = nodes.size(); k-- > 0;) {
    BvhNode<Volume>& node = nodes[k];
    begin[k] = node.count > 0 ? node.first : begin[node.first];
    end[k] = node.count > 0 ? node.first + node.count : end[node.first + 1];
    fit_volume(&corners[begin[k]], end[k] - begin[k], node.volume);
  }
}

}  // namespace

template <class Volume>
Bvh<Volume>::Bvh(const TriangleMesh& mesh) {
  check_vertices(mesh.vertices);
  check_indices(mesh);
  vertices_ = mesh.vertices.size();
  std::vector<BuildItem> items = build_items(mesh);
  const std::vector<BvhLinks> branches = build_branches(items, kLeaf);
  nodes_.resize(branches.size());
  for (std::size_t k = 0; k < nodes_.size(); ++k)
    nodes_[k].first = branches[k].first, nodes_[k].count = branches[k].count;
  order_.reserve(items.size());
  indices_.reserve(items.size());
  for (const BuildItem& item : items) {
    order_.push_back(item.id);
    indices_.push_back(mesh.triangles[item.id]);
  }
  corners_.reserve(items.size());
  for (const auto& [i, j, k] : indices_)
    corners_.push_back({mesh.vertices[i], mesh.vertices[j], mesh.vertices[k]});
  fit();
}

template <class Volume>
void Bvh<Volume>::refit(const std::vector<Vector3d>& vertices) {
  FEDER_CHECK(vertices.size() == vertices_,
              "a hierarchy is refitted with as many vertices as it was built with");
  check_vertices(vertices);
  for (std::size_t k = 0; k < corners_.size(); ++k)
    for (int c = 0; c < 3; ++c) corners_[k][c] = vertices[indices_[k][c]];
  fit();
}

template <class Volume>
void Bvh<Volume>::fit() {
  fit_nodes(nodes_, corners_);
}

template class Bvh<Sphere>;
template class Bvh<Aabb>;
template class Bvh<Obb>;

}  // namespace feder
