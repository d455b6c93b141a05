// A fingerprint of everything that decides a trajectory: 64-bit FNV-1a over the bytes of all numbers.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>
#include <vector>

#include "engine/geometry/shape_bounds.h"
#include "engine/kkt.h"

namespace feder {

class Fnv1a {
 public:
  void add_bytes(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) hash_ = (hash_ ^ bytes[i]) * 0x100000001b3u;
  }
  /// Integers and floating-point numbers only: structs have padding.
  template <class T>
  requires std::is_arithmetic_v<T> || std::is_enum_v<T>
  void add(T x) { add_bytes(&x, sizeof x); }
  template <class T>
  void add(std::span<const T> list) {
    add(static_cast<std::uint64_t>(list.size()));
    for (const T& x : list) add(x);
  }
  template <class T>
  void add(const std::vector<T>& list) {
    add(std::span<const T>(list));
  }
  void add(const VectorXd& x) { add(std::span<const double>(x.data(), static_cast<std::size_t>(x.size()))); }
  void add(std::string_view text) { add(std::span<const char>(text.data(), text.size())); }

  std::uint64_t value() const { return hash_; }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325u;
};

/// Masses, masks, rows, materials, forces and the state. A user force or a prescribed motion has no number to
/// hash: such scenes must not be cached. Stencil rows of any type are hashed by nodes, material and their phi
/// at the state and at two displaced ones.
inline void hash_scene(Fnv1a& hash, const System& s, const State& state) {
  hash.add(s.nodes);
  hash.add(static_cast<std::uint64_t>(s.bodies.size()));
  hash.add(s.inertia);
  hash.add(s.inverse_mass);
  hash.add(s.free);
  const DistanceRows& rows = s.distance;
  for (const std::vector<int>* list : {&rows.a, &rows.b, &rows.public_row, &s.stencil_nodes}) hash.add(*list);
  hash.add(rows.rest);
  hash.add(s.stiffness);
  hash.add(s.damping_time);
  hash.add(s.damping);
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    hash.add(std::string_view(std::decay_t<decltype(list)>::value_type::kName));
    hash.add(static_cast<std::uint64_t>(list.size()));
  });
  for (const Collider& c : s.colliders) {
    hash.add(c.place.node);
    hash.add(static_cast<std::uint64_t>(c.shape.index()));
    hash.add(std::span<const double>(c.place.point.data(), 3));
    hash.add(std::span<const double>(c.rotation.data(), 9));
    hash.add(c.surface.friction);
    hash.add(c.surface.restitution);
    hash.add(c.group);
    hash.add(bounding_radius(c.shape));
  }
  VectorXd q = state.q, phi;
  for (int probe = 0; probe < 3; ++probe) {
    evaluate_phi(s, q, phi);
    hash.add(phi);
    for (int i = 0; i < q.size(); ++i) q[i] += 0.1 * ((i * 7 + probe * 3) % 11) - 0.5;
  }
  hash.add(s.forces.constant);
  hash.add(s.forces.drag);
  hash.add(state.t);
  hash.add(state.q);
  hash.add(state.v);
}

}  // namespace feder
