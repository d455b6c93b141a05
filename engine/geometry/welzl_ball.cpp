// Welzl's algorithm (Smallest enclosing disks, 1991; notes A15): with R on the boundary,
//   S = ball(R); if |R| < d + 1: for i = 0 ... n-1: if p_i not in S: S = ball of p_0 ... p_i-1 with R + p_i.
#include "engine/geometry/welzl_ball.h"

#include <algorithm>
#include <cmath>

#include "engine/check.h"
#include "engine/geometry/circumcentre.h"

namespace feder {
namespace {

// Squared distances, relative: a point this little outside is inside.
constexpr double kRounding = 1e-13;

// SplitMix64: the same order with every standard library.
std::uint64_t random_bits(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

template <int D>
class Welzl {
 public:
  Welzl(const Eigen::Ref<const Eigen::MatrixXd>& points, std::uint64_t seed)
      : points_(points), centre_(DVector<D>::Zero(points.rows())) {
    // Fisher-Yates
    for (Eigen::Index i = points_.cols() - 1; i > 0; --i)
      points_.col(i).swap(points_.col(static_cast<Eigen::Index>(random_bits(seed) % (i + 1))));
  }
  WelzlBall solve() {
    enclose(points_.cols(), FewPoints<D>(points_.rows(), 0));
    return {{centre_, std::sqrt(squared_radius_)}, inside_tests_};
  }

 private:
  // The ball of the first n points with `boundary` on it, centre_ and radius of ball(boundary) already set.
  void enclose(Eigen::Index n, const FewPoints<D>& boundary) {
    if (boundary.cols() == points_.rows() + 1) return;
    for (Eigen::Index i = 0; i < n; ++i) {
      ++inside_tests_;
      if ((points_.col(i) - centre_).squaredNorm() <= (1.0 + kRounding) * squared_radius_) continue;
      FewPoints<D> larger(points_.rows(), boundary.cols() + 1);
      larger << boundary, points_.col(i);
      const Circumcentre<D> through = circumcentre<D>(larger);
      if (!through.independent) continue;  // outside by rounding alone
      centre_ = through.centre;
      squared_radius_ = (larger.colwise() - centre_).colwise().squaredNorm().maxCoeff();
      enclose(i, larger);
    }
  }

  Eigen::Matrix<double, D, Eigen::Dynamic> points_;
  DVector<D> centre_;
  double squared_radius_ = -1.0;
  std::int64_t inside_tests_ = 0;
};

}  // namespace

WelzlBall welzl_ball(const Eigen::Ref<const Eigen::MatrixXd>& points, std::uint64_t seed) {
  FEDER_CHECK(points.rows() >= 1, "points of no dimension");
  if (points.cols() == 0) return {{VectorXd::Zero(points.rows())}};
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    for (double x : points.col(i))
      if (!std::isfinite(x)) require_finite("point " + std::to_string(i), "coordinate", x, "m");
  switch (points.rows()) {
    case 2:
      return Welzl<2>(points, seed).solve();
    case 3:
      return Welzl<3>(points, seed).solve();
    default:
      return Welzl<Eigen::Dynamic>(points, seed).solve();
  }
}

}  // namespace feder
