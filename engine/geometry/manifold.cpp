#include "engine/geometry/manifold.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

#include "engine/check.h"
#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

template <class A, class B>
concept HasRoutine = requires(const A& a, const B& b, const Pose& pose, ContactSink& sink) {
  add_contacts(a, pose, b, pose, sink);
};

const char* name(const SphereShape&) {
  return "sphere";
}
const char* name(const BoxShape&) {
  return "box";
}
const char* name(const CapsuleShape&) {
  return "capsule";
}
const char* name(const HalfSpaceShape&) {
  return "half space";
}
const char* name(const TorusShape&) {
  return "torus";
}
const char* name(const MeshShape&) {
  return "mesh";
}

bool sound(const SphereShape& s) {
  return s.radius >= 0.0 && std::isfinite(s.radius);
}
bool sound(const BoxShape& s) {
  return (s.half.array() > 0.0).all() && s.half.allFinite();
}
bool sound(const CapsuleShape& s) {
  return s.radius >= 0.0 && s.half_length >= 0.0 && std::isfinite(s.radius + s.half_length);
}
bool sound(const HalfSpaceShape&) {
  return true;
}
bool sound(const TorusShape& s) {
  return s.minor > 0.0 && s.major > s.minor && std::isfinite(s.major);
}
bool sound(const MeshShape& s) {
  return s.mesh != nullptr;
}

std::array<double, 3> sizes(const SphereShape& s) {
  return {s.radius, 0.0, 0.0};
}
std::array<double, 3> sizes(const BoxShape& s) {
  return {s.half.x(), s.half.y(), s.half.z()};
}
std::array<double, 3> sizes(const CapsuleShape& s) {
  return {s.radius, s.half_length, 0.0};
}
std::array<double, 3> sizes(const MeshShape&) {
  return {};
}

// Which of two shapes of one type the routine gets first: for exact symmetry the same one, whatever the order
// of the arguments. By position along a direction askew to everything a scene is aligned with, so that small
// motion does not change it.
template <class T>
bool in_order(const T& a, const Pose& pose_a, const T& b, const Pose& pose_b) {
  const double along = Vector3d(0.5317, 0.6803, 0.5046).dot(pose_b.position - pose_a.position);
  if (along != 0.0) return along > 0.0;
  if (sizes(a) != sizes(b)) return sizes(a) < sizes(b);
  for (int i = 0; i < 9; ++i)
    if (pose_a.rotation(i) != pose_b.rotation(i)) return pose_a.rotation(i) < pose_b.rotation(i);
  for (int i = 0; i < 3; ++i)
    if (pose_a.position[i] != pose_b.position[i]) return pose_a.position[i] < pose_b.position[i];
  return true;
}

template <class A, class B>
void add_swapped(const A& a, const Pose& pose_a, const B& b, const Pose& pose_b, ContactSink& sink) {
  const std::size_t first = sink.out.size();
  add_contacts(b, pose_b, a, pose_a, sink);
  for (std::size_t k = first; k < sink.out.size(); ++k) {
    ContactPoint& contact = sink.out[k];
    contact.normal = -contact.normal;
    if constexpr (std::is_same_v<A, B>) contact.feature = contact.feature << 16 | contact.feature >> 16;
  }
}

template <class A, class B>
void add_either_way(const A& a, const Pose& pose_a, const B& b, const Pose& pose_b, ContactSink& sink) {
  if constexpr (std::is_same_v<A, B> && HasRoutine<A, B>) {
    if (in_order(a, pose_a, b, pose_b))
      add_contacts(a, pose_a, b, pose_b, sink);
    else
      add_swapped(a, pose_a, b, pose_b, sink);
  } else if constexpr (HasRoutine<A, B>) {
    add_contacts(a, pose_a, b, pose_b, sink);
  } else if constexpr (HasRoutine<B, A>) {
    add_swapped(a, pose_a, b, pose_b, sink);
  } else {
    FEDER_CHECK(false, refuse_pair(a, b).c_str());
  }
}

bool finite(const Pose& pose) {
  return pose.position.allFinite() && pose.rotation.allFinite();
}

}  // namespace

void find_contacts(const Shape& a, const Pose& pose_a, const Shape& b, const Pose& pose_b, double margin,
                   std::vector<ContactPoint>& out) {
  FEDER_CHECK(finite(pose_a) && finite(pose_b) && !std::isnan(margin),
              "poses must be finite and the margin a number");
  const auto first = static_cast<std::ptrdiff_t>(out.size());
  ContactSink sink{margin, out};
  std::visit(
      [&](const auto& shape_a, const auto& shape_b) {
        FEDER_CHECK(sound(shape_a) && sound(shape_b), "a shape has sizes out of range");
        add_either_way(shape_a, pose_a, shape_b, pose_b, sink);
      },
      a, b);
  std::sort(out.begin() + first, out.end(),
            [](const ContactPoint& x, const ContactPoint& y) { return x.feature < y.feature; });
}

std::string refuse_pair(const Shape& a, const Shape& b) {
  return std::visit(
      []<class A, class B>(const A& shape_a, const B& shape_b) -> std::string {
        if constexpr (HasRoutine<A, B> || HasRoutine<B, A>) return {};
        const std::string pair = std::string(name(shape_a)) + " and " + name(shape_b);
        if constexpr (std::is_same_v<A, HalfSpaceShape> && std::is_same_v<B, HalfSpaceShape>)
          return pair + ": no contact points, their overlap has no end";
        return pair + ": no contact routine for a torus with this shape, use the mesh of the torus";
      },
      a, b);
}

}  // namespace feder
