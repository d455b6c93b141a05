// Contacts of spheres and capsules: closest points of points, segments and a box, less the radii.
// Segments c_a + s e_a and c_b + t e_b, w = c_b - c_a, d = e_a.e_b (Ericson, Real-Time Collision Detection,
// 2005, 5.1.9):  s = (e_a.w - d e_b.w)/(1 - d^2),  t = d s - e_b.w  where both lie inside, else the nearest
// of the four ends to the other segment. Parallel capsules touch along a line: held at the ends of its
// overlap.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/geometry/manifold_pairs.h"

namespace feder {
namespace {

constexpr double kParallel = 0.1;      // sine of the angle below which capsules touch along a line
constexpr double kAtEnd = 1e-4;        // of the shorter segment: a point that close to an end is the end
constexpr double kCloser = 1e-10;      // what a crossing of nearly parallel axes gains over the ends of the
                                       // overlap counts from here on, relative to the lengths
constexpr double kNoCrossing = 1e-12;  // sine of the angle below which axes have no crossing

struct Segment {
  Vector3d centre, axis;
  double half;

  Segment(const CapsuleShape& capsule, const Pose& pose)
      : centre(pose.position), axis(pose.rotation.col(2)), half(capsule.half_length) {}
  Vector3d at(double s) const { return centre + s * axis; }
  /// 1 or 2 near an end, 0 between.
  std::uint32_t end(double s, double tolerance) const {
    return s <= tolerance - half ? 1u : s >= half - tolerance ? 2u : 0u;
  }
};

/// Points at s and t of two segments; `inside`: neither parameter had to be limited to its segment.
struct Link {
  double s, t, distance;
  bool inside;
};

Link link(const Segment& a, const Segment& b, double s, double t, bool inside) {
  return {s, t, (b.at(t) - a.at(s)).norm(), inside};
}

/// Ends of a against b, ends of b against a, and the crossing if there is one between the ends.
struct Links {
  std::array<Link, 4> ends;
  Link crossing{0.0, 0.0, std::numeric_limits<double>::infinity(), false};
  double sine;
};

Links all_links(const Segment& a, const Segment& b, double tolerance) {
  Links out;
  for (int k = 0; k < 2; ++k) {
    const double s = k ? a.half : -a.half, t = k ? b.half : -b.half;
    const double on_b = b.axis.dot(a.at(s) - b.centre), on_a = a.axis.dot(b.at(t) - a.centre);
    out.ends[k] = link(a, b, s, std::clamp(on_b, -b.half, b.half), std::abs(on_b) <= b.half + tolerance);
    out.ends[2 + k] = link(a, b, std::clamp(on_a, -a.half, a.half), t, std::abs(on_a) <= a.half + tolerance);
  }
  out.sine = a.axis.cross(b.axis).norm();
  if (out.sine > kNoCrossing) {
    const Vector3d w = b.centre - a.centre;
    const double d = a.axis.dot(b.axis), on_a = a.axis.dot(w), on_b = b.axis.dot(w);
    const double s = (on_a - d * on_b) / (out.sine * out.sine), t = d * s - on_b;
    if (std::abs(s) < a.half && std::abs(t) < b.half) out.crossing = link(a, b, s, t, true);
  }
  return out;
}

}  // namespace

Vector3d direction_or(const Vector3d& v, const Vector3d& fallback) {
  const double size = v.cwiseAbs().maxCoeff();  // first: squares of small numbers are zero
  return size > 0.0 ? (v / size).normalized() : fallback;
}

void add_balls(const Vector3d& centre_a, double radius_a, const Vector3d& centre_b, double radius_b,
               const Vector3d& fallback, std::uint32_t feature, ContactSink& sink) {
  const Vector3d apart = centre_b - centre_a, normal = direction_or(apart, fallback);
  sink.add(centre_a + radius_a * normal, normal, apart.norm() - radius_a - radius_b, feature);
}

double nearest_on_segment(const Vector3d& p, const Vector3d& centre, const Vector3d& axis,
                          double half_length) {
  return std::clamp(axis.dot(p - centre), -half_length, half_length);
}

void add_contacts(const SphereShape& a, const Pose& pose_a, const SphereShape& b, const Pose& pose_b,
                  ContactSink& sink) {
  add_balls(pose_a.position, a.radius, pose_b.position, b.radius, pose_a.rotation.col(2), 0, sink);
}

void add_contacts(const SphereShape& sphere, const Pose& sphere_pose, const BoxShape& box, const Pose& pose,
                  ContactSink& sink) {
  const Vector3d centre = pose.rotation.transpose() * (sphere_pose.position - pose.position);
  const Vector3d nearest = centre.cwiseMax(-box.half).cwiseMin(box.half);
  Vector3d side = Vector3d::Zero();  // +-1 where the centre is outside
  for (int i = 0; i < 3; ++i) side[i] = centre[i] > box.half[i] ? 1.0 : centre[i] < -box.half[i] ? -1.0 : 0.0;
  Vector3d outward;
  double distance;
  if (side.isZero(0.0)) {
    // inside: out through the nearest face
    int i;
    distance = (centre.cwiseAbs() - box.half).maxCoeff(&i);
    side[i] = centre[i] < 0.0 ? -1.0 : 1.0;
    outward = side[i] * Vector3d::Unit(i);
  } else {
    distance = (centre - nearest).norm();
    outward = direction_or(centre - nearest, side);
  }
  const Vector3d normal = -(pose.rotation * outward);
  const auto feature = static_cast<std::uint32_t>(13.0 + side.dot(Vector3d(1, 3, 9)));
  sink.add(sphere_pose.position + sphere.radius * normal, normal, distance - sphere.radius, feature);
}

void add_contacts(const SphereShape& sphere, const Pose& sphere_pose, const CapsuleShape& capsule,
                  const Pose& pose, ContactSink& sink) {
  const Segment segment(capsule, pose);
  const double s = nearest_on_segment(sphere_pose.position, segment.centre, segment.axis, segment.half);
  add_balls(sphere_pose.position, sphere.radius, segment.at(s), capsule.radius, pose.rotation.col(0),
            segment.end(s, 0.0), sink);
}

void add_contacts(const CapsuleShape& capsule_a, const Pose& pose_a, const CapsuleShape& capsule_b,
                  const Pose& pose_b, ContactSink& sink) {
  const Segment a(capsule_a, pose_a), b(capsule_b, pose_b);
  const double tolerance = kAtEnd * std::min(a.half, b.half);
  const Links links = all_links(a, b, tolerance);
  std::array<Link, 5> taken;  // one per feature, the nearest
  std::array<std::uint32_t, 5> features;
  int count = 0;
  const Link* closest = &links.crossing;
  for (const Link& end : links.ends)
    if (end.distance < closest->distance) closest = &end;
  const bool line = links.sine < kParallel;
  const auto take = [&](const Link& candidate) {
    const std::uint32_t feature = feature_pair(a.end(candidate.s, tolerance), b.end(candidate.t, tolerance));
    int k = 0;
    while (k < count && features[k] != feature) ++k;
    if (k == count || candidate.distance < taken[k].distance) taken[k] = candidate;
    features[k] = feature;
    count = std::max(count, k + 1);
  };
  // the line of touch of nearly parallel capsules
  double least = std::numeric_limits<double>::infinity();
  for (const Link& end : links.ends)
    if (line && end.inside) take(end), least = std::min(least, end.distance);
  // the closest points
  if (!(closest->distance >= least - kCloser * (a.half + b.half))) take(*closest);
  const Vector3d across = a.axis.cross(b.axis);
  const Vector3d fallback = links.sine > kNoCrossing ? across.normalized() : Vector3d(pose_a.rotation.col(0));
  for (int k = 0; k < count; ++k)
    add_balls(a.at(taken[k].s), capsule_a.radius, b.at(taken[k].t), capsule_b.radius, fallback, features[k],
              sink);
}

}  // namespace feder
