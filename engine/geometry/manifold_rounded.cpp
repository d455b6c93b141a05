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
constexpr double kNoCrossing = 1e-10;  // sine of the angle below which axes have no crossing
constexpr double kMeeting = 1e-13;     // axes closer than this, relative to the lengths, give no direction

/// Points at s and t of two segments; `inside`: neither parameter had to be limited to its segment.
struct Link {
  double s, t;
  Vector3d apart;
  bool inside;
};

/// The axes of two capsules: the ends of a against b, those of b against a, and the crossing if there is one
/// between the ends.
class Axes {
 public:
  Axes(const Pose& pose_a, double half_a, const Pose& pose_b, double half_b)
      : a_(pose_a.rotation.col(2)),
        b_(pose_b.rotation.col(2)),
        w_(pose_b.position - pose_a.position),
        half_a_(half_a),
        half_b_(half_b),
        across_(a_.cross(b_)),
        sine_(across_.norm()),
        tolerance_(kAtEnd * std::min(half_a, half_b)) {
    for (double sign : {-1.0, 1.0}) {
      add_end(sign * half_a, b_.dot(sign * half_a * a_ - w_), true);
      add_end(a_.dot(w_ + sign * half_b * b_), sign * half_b, false);
    }
    if (sine_ <= kNoCrossing) return;
    const double d = a_.dot(b_), on_a = a_.dot(w_), on_b = b_.dot(w_);
    const double s = (on_a - d * on_b) / (sine_ * sine_), t = d * s - on_b;
    if (!(std::abs(s) < half_a_ && std::abs(t) < half_b_)) return;
    links_[count_++] = {s, t, without(without(w_ + t * b_ - s * a_, a_), b_), true};
  }

  double sine() const { return sine_; }
  double size() const { return w_.norm() + half_a_ + half_b_; }
  /// The normal of axes that meet; `side`: a direction across a, for axes that are parallel.
  Vector3d across(const Vector3d& side) const {
    return sine_ > kNoCrossing ? Vector3d(across_ / sine_) : side;
  }
  const Link* begin() const { return links_.data(); }
  const Link* end() const { return links_.data() + count_; }
  /// 1 or 2 near an end, 0 between.
  std::uint32_t feature(const Link& link) const {
    return feature_pair(end_feature(link.s, half_a_), end_feature(link.t, half_b_));
  }

 private:
  // An end of one against the other segment, whose parameter is limited to it.
  void add_end(double s, double t, bool of_a) {
    double& other = of_a ? t : s;
    const double half = of_a ? half_b_ : half_a_, wanted = other;
    other = std::clamp(wanted, -half, half);
    Vector3d apart = w_ + t * b_ - s * a_;
    if (wanted == other) apart = without(apart, of_a ? b_ : a_);
    links_[count_++] = {s, t, apart, std::abs(wanted) <= half + tolerance_};
  }
  // Across the axis to the last digit, even where next to nothing is left.
  static Vector3d without(const Vector3d& v, const Vector3d& axis) { return v - axis.dot(v) * axis; }
  std::uint32_t end_feature(double s, double half) const {
    return s <= tolerance_ - half ? 1u : s >= half - tolerance_ ? 2u : 0u;
  }

  const Vector3d a_, b_, w_;
  const double half_a_, half_b_;
  const Vector3d across_;
  const double sine_, tolerance_;
  std::array<Link, 5> links_;
  std::ptrdiff_t count_ = 0;
};

}  // namespace

Vector3d direction_or(const Vector3d& v, const Vector3d& fallback) {
  const double size = v.cwiseAbs().maxCoeff();  // first: squares of small numbers are zero
  return size > 0.0 ? (v / size).normalized() : fallback;
}

void add_balls(const Vector3d& centre_a, double radius_a, const Vector3d& centre_b, double radius_b,
               const Vector3d& fallback, double rounding, std::uint32_t feature, ContactSink& sink) {
  const Vector3d apart = centre_b - centre_a;
  const Vector3d normal = apart.norm() <= rounding ? fallback : direction_or(apart, fallback);
  sink.add(centre_a + radius_a * normal, normal, apart.norm() - radius_a - radius_b, feature);
}

void add_contacts(const SphereShape& a, const Pose& pose_a, const SphereShape& b, const Pose& pose_b,
                  ContactSink& sink) {
  add_balls(pose_a.position, a.radius, pose_b.position, b.radius, pose_a.rotation.col(2), 0.0, 0, sink);
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
  // in the axes of the capsule: between the ends the normal is across the axis to the last digit
  const Vector3d centre = pose.rotation.transpose() * (sphere_pose.position - pose.position);
  const double half = capsule.half_length, s = std::clamp(centre.z(), -half, half);
  const Vector3d apart(centre.x(), centre.y(), centre.z() - s);
  const Vector3d normal = -(pose.rotation * direction_or(apart, Vector3d::UnitX()));
  const std::uint32_t feature = s <= -half ? 1u : s >= half ? 2u : 0u;
  sink.add(sphere_pose.position + sphere.radius * normal, normal,
           apart.norm() - sphere.radius - capsule.radius, feature);
}

void add_contacts(const CapsuleShape& a, const Pose& pose_a, const CapsuleShape& b, const Pose& pose_b,
                  ContactSink& sink) {
  const Axes axes(pose_a, a.half_length, pose_b, b.half_length);
  std::array<Link, 5> taken;  // one per feature, the nearest
  std::array<std::uint32_t, 5> features;
  std::size_t count = 0;
  const auto take = [&](const Link& link) {
    const std::uint32_t feature = axes.feature(link);
    std::size_t k = 0;
    while (k < count && features[k] != feature) ++k;
    if (k == count || link.apart.norm() < taken[k].apart.norm()) taken[k] = link;
    features[k] = feature;
    count = std::max(count, k + 1);
  };
  // the line of touch of nearly parallel capsules, then the closest points
  double least = std::numeric_limits<double>::infinity();
  const Link* closest = axes.begin();
  for (const Link& link : axes) {
    if (link.apart.norm() < closest->apart.norm()) closest = &link;
    if (axes.sine() > kParallel || !link.inside || axes.feature(link) == 0) continue;
    take(link);
    least = std::min(least, link.apart.norm());
  }
  if (!(closest->apart.norm() >= least - kCloser * axes.size())) take(*closest);
  const Vector3d across = axes.across(pose_a.rotation.col(0));
  for (std::size_t k = 0; k < count; ++k) {
    const Vector3d on_a = pose_a.position + taken[k].s * pose_a.rotation.col(2);
    add_balls(on_a, a.radius, on_a + taken[k].apart, b.radius, across, kMeeting * axes.size(), features[k],
              sink);
  }
}

}  // namespace feder
