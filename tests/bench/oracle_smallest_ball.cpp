// smallest_ball beside CGAL's Min_sphere_of_spheres_d (double precision, header only, compiled with the flags
// of the library here): radii on 1e5 points, times on 1e6 points in 3-D, taken in turn in one run. Both get
// the points in their own format; whole calls, processor time of one thread.
#include <CGAL/Min_sphere_of_points_d_traits_3.h>
#include <CGAL/Min_sphere_of_spheres_d.h>
#include <CGAL/Simple_cartesian.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <vector>

#include "engine/geometry/smallest_ball.h"
#include "tests/support/random.h"

namespace feder {
namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using PeerBall = CGAL::Min_sphere_of_spheres_d<CGAL::Min_sphere_of_points_d_traits_3<Kernel, double>>;
constexpr int kTurns = 11;
const char* const kSets[] = {"cube", "ball", "sphere", "sphere and inside", "thin shell", "far cube", "line"};

Vector3d in_ball(Random& random) {
  for (;;)
    if (const Vector3d x = random.vector(); x.squaredNorm() <= 1.0) return x;
}

Vector3d point_of(const std::string& set, Random& random) {
  if (set == "cube") return random.vector();
  if (set == "far cube") return random.vector() + Vector3d(1e6, -2e6, 3e6);
  if (set == "line") return random.uniform() * Vector3d(1.0, 2.0, 3.0);
  const Vector3d x = in_ball(random);
  if (set == "ball") return x;
  if (set == "thin shell") return random.uniform(1.0 - 1e-6, 1.0) * x.normalized();
  return set == "sphere" || random.below(2) ? x.normalized() : x;
}

struct Points {
  Eigen::MatrixXd columns;
  std::vector<Kernel::Point_3> peer;
};

Points points_of(const std::string& set, int count) {
  Random random(1);
  Points out{Eigen::MatrixXd(3, count), {}};
  for (int i = 0; i < count; ++i) {
    out.columns.col(i) = point_of(set, random);
    out.peer.emplace_back(out.columns(0, i), out.columns(1, i), out.columns(2, i));
  }
  return out;
}

// Of processor time: what else the machine does counts less.
template <class Action>
double seconds(Action&& action) {
  const std::clock_t start = std::clock();
  action();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

// How far the farthest point is outside, relative.
double outside(const Eigen::MatrixXd& points, const Vector3d& centre, double radius) {
  return (points.colwise() - VectorXd(centre)).colwise().norm().maxCoeff() / radius - 1.0;
}

void compare_radii(const std::string& set) {
  const Points points = points_of(set, 100000);
  const Ball own = smallest_ball(points.columns);
  PeerBall peer(points.peer.begin(), points.peer.end());
  const double radius = peer.radius();
  const Vector3d centre(peer.center_cartesian_begin());
  std::printf("%-18s %12.9f %11.1e %11.1e %11.1e %11.1e\n", set.c_str(), own.radius,
              (own.radius - radius) / radius, (centre - own.centre).norm() / radius,
              outside(points.columns, own.centre, own.radius), outside(points.columns, centre, radius));
}

void compare_times(const std::string& set) {
  const Points points = points_of(set, 1000000);
  std::vector<double> own, peer, ratio;
  double radii = 0.0;
  for (int turn = 0; turn < kTurns; ++turn) {
    own.push_back(seconds([&] { radii += smallest_ball(points.columns).radius; }));
    peer.push_back(seconds([&] {
      PeerBall ball(points.peer.begin(), points.peer.end());
      radii -= ball.radius();
    }));
    ratio.push_back(peer.back() / own.back());
  }
  for (auto* list : {&own, &peer, &ratio}) std::sort(list->begin(), list->end());
  std::printf("%-18s %9.2f %9.2f   %6.2f [%6.2f %6.2f]   %8.1e\n", set.c_str(), 1e3 * own[kTurns / 2],
              1e3 * peer[kTurns / 2], ratio[kTurns / 2], ratio[kTurns / 4], ratio[3 * kTurns / 4],
              radii / kTurns);
  std::fflush(stdout);
}

}  // namespace
}  // namespace feder

int main() {
  std::printf("%-18s %12s %11s %11s %11s %11s\n", "1e5 points", "radius", "to CGAL", "centres", "outside",
              "of CGAL's");
  for (const char* set : feder::kSets) feder::compare_radii(set);
  std::printf("\n%-18s %9s %9s   %s\n", "1e6 points", "Feder ms", "CGAL ms",
              "CGAL / Feder [quartiles]   radii differ");
  for (const char* set : feder::kSets) feder::compare_times(set);
}
