// The ball of a small support set is enlarged by the point farthest outside until there is none (pivoting,
// Gaertner, Fast and robust smallest enclosing balls, 1999): a lower bound of the radius meets an upper one.
// Many points: the ball (c1, r1) of a sample, then one sweep over all. Points closer to c1 than some r0 lie
// in the ball (c2, r2) of the others if |c2 - c1| + r0 <= r2; otherwise a sweep with (c2, r2) adds those
// outside.
#include "engine/geometry/smallest_ball.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "engine/check.h"
#include "engine/geometry/ball_support.h"
#include "engine/geometry/farthest_point.h"

namespace feder {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
// Squared distances, relative: differences below this are rounding.
constexpr double kRounding = 64.0 * kEpsilon;
constexpr double kNowhere = std::numeric_limits<double>::infinity();
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
// Rounds without gain beyond rounding after which the best ball so far is the answer.
constexpr int kIdleRounds = 20;
// More points than kDirect are sampled; of the sample, kKept points outermost show where to look for the
// rest.
constexpr Eigen::Index kDirect = 16384, kSample = 4096, kKept = 64;

using Points = Eigen::Ref<const Eigen::MatrixXd>;
template <int D>
using Cloud = Eigen::Matrix<double, D, Eigen::Dynamic>;

template <int D>
struct CentredBall {
  DVector<D> centre;
  double squared_radius;
  FewPoints<D> support;
};

template <int D>
CentredBall<D> unknown(Eigen::Index d) {
  return {DVector<D>::Constant(d, kUnknown), kUnknown, FewPoints<D>(d, 0)};
}

// Pivoting. The radius is that of the farthest point from the centre; all NaN if a distance is not finite.
template <int D>
CentredBall<D> ball_of(const Cloud<D>& points) {
  BallSupport<D> support(points.col(0));
  CentredBall<D> best{support.centre(), kNowhere, support.points()};
  double reached = 0.0;
  for (int idle = 0; idle < kIdleRounds; ++idle) {
    const Farthest farthest = farthest_point<D>(points.data(), points.rows(), points.cols(),
                                                support.centre().data(), kNowhere, [](Eigen::Index) {});
    if (!std::isfinite(farthest.sum)) return unknown<D>(points.rows());
    const double inner = support.squared_radius();
    if (farthest.squared_distance < (1.0 - kRounding) * best.squared_radius ||
        inner > (1.0 + kRounding) * reached)
      idle = 0;
    if (farthest.squared_distance < best.squared_radius)
      best = {support.centre(), farthest.squared_distance, support.points()};
    if (farthest.squared_distance <= (1.0 + kRounding) * inner) return best;
    reached = std::max(reached, inner);
    support.enter(points.col(farthest.index));
  }
  return best;
}

// Back from the origin: the radius reaches all of the points from the centre as it is rounded.
template <int D>
Ball placed(const DVector<D>& origin, const DVector<D>& centre, const Cloud<D>& points) {
  const DVector<D> rounded = origin + centre;
  return {rounded, (points.colwise() - (rounded - origin)).colwise().norm().maxCoeff()};
}

// One point out of each of kSample equal stretches, at irregular distances.
template <int D>
Cloud<D> sample_of(const Points& points, const DVector<D>& origin) {
  Cloud<D> sample(points.rows(), kSample);
  const Eigen::Index stretch = points.cols() / kSample;
  std::uint64_t state = 0;
  for (Eigen::Index i = 0; i < kSample; ++i) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    sample.col(i) = points.col(i * stretch + static_cast<Eigen::Index>((state >> 33) % stretch)) - origin;
  }
  return sample;
}

// Squared distance from the centre that kKept points of the sample exceed.
template <int D>
double outermost(const Cloud<D>& sample, const DVector<D>& centre) {
  VectorXd squared = (sample.colwise() - centre).colwise().squaredNorm();
  std::nth_element(squared.begin(), squared.begin() + kKept, squared.end(), std::greater<>());
  return squared[kKept];
}

// A squared distance this large may be that of a point on the ball, by the rounding of its coordinates.
template <int D>
double rounded_up(double squared_radius, const DVector<D>& centre) {
  return squared_radius +
         kRounding * (squared_radius + std::sqrt(squared_radius) * centre.cwiseAbs().maxCoeff());
}

template <int D>
Ball ball_of_many(const Points& points) {
  const DVector<D> origin = points.col(0);
  const Cloud<D> sample = sample_of<D>(points, origin);
  CentredBall<D> inner = ball_of<D>(sample);
  if (!std::isfinite(inner.squared_radius)) return {origin, kUnknown};
  double beyond = outermost<D>(sample, inner.centre);

  std::vector<double> outer(inner.support.reshaped().begin(), inner.support.reshaped().end());
  Ball best{origin, kNowhere};
  for (int idle = 0; idle < kIdleRounds; ++idle) {
    const DVector<D> centre = origin + inner.centre;
    const Farthest farthest = farthest_point<D>(points.data(), points.rows(), points.cols(), centre.data(),
                                                beyond, [&](Eigen::Index i) {
                                                  for (Eigen::Index j = 0; j < points.rows(); ++j)
                                                    outer.push_back(points(j, i) - origin[j]);
                                                });
    if (!std::isfinite(farthest.sum)) return {origin, kUnknown};
    const double radius = std::sqrt(farthest.squared_distance);
    if (radius < (1.0 - kRounding) * best.radius) idle = 0;
    if (radius < best.radius) best = {centre, radius};
    if (farthest.squared_distance <= rounded_up<D>(inner.squared_radius, centre)) break;

    const Cloud<D> rest =
        Eigen::Map<const Cloud<D>>(outer.data(), points.rows(), std::ssize(outer) / points.rows());
    const CentredBall<D> next = ball_of<D>(rest);
    if ((next.centre - inner.centre).norm() + std::sqrt(beyond) <= std::sqrt(next.squared_radius))
      return placed<D>(origin, next.centre, rest);
    if (next.squared_radius > (1.0 + kRounding) * inner.squared_radius) idle = 0;
    inner = next;
    beyond = rounded_up<D>(inner.squared_radius, origin + inner.centre);
  }
  return best;
}

template <int D>
Ball ball_of_points(const Points& points) {
  if (points.cols() > kDirect) return ball_of_many<D>(points);
  const DVector<D> origin = points.col(0);
  const Cloud<D> near = points.colwise() - origin;
  return placed<D>(origin, ball_of<D>(near).centre, near);
}

Ball ball_of_points(const Points& points) {
  switch (points.rows()) {
    case 2:
      return ball_of_points<2>(points);
    case 3:
      return ball_of_points<3>(points);
    default:
      return ball_of_points<Eigen::Dynamic>(points);
  }
}

// Numbers whose squares leave the range of double, or that are no numbers: from the first point and divided
// by the power of two next to their extent.
Ball ball_of_extreme(const Points& points) {
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    for (double x : points.col(i)) require_finite("point " + std::to_string(i), "coordinate", x, "m");
  const VectorXd origin = points.col(0);
  const double extent = (points.colwise() - origin).cwiseAbs().maxCoeff();
  if (extent == 0.0) return {origin, 0.0};
  const int exponent = std::isfinite(extent) ? std::ilogb(extent) : std::numeric_limits<double>::max_exponent;
  auto scaled = [exponent](double x, double from) {
    return exponent > 0 ? std::ldexp(x, -exponent) - std::ldexp(from, -exponent)
                        : std::ldexp(x - from, -exponent);
  };
  Eigen::MatrixXd near(points.rows(), points.cols());
  for (Eigen::Index i = 0; i < points.cols(); ++i) near.col(i) = points.col(i).binaryExpr(origin, scaled);
  const Ball ball = ball_of_points(near);
  auto unscaled = [exponent](double x) { return std::ldexp(x, exponent); };
  return {origin + ball.centre.unaryExpr(unscaled), unscaled(ball.radius)};
}

}  // namespace

std::optional<Ball> ball_through(const Eigen::Ref<const Eigen::MatrixXd>& points) {
  FEDER_CHECK(points.cols() >= 1 && points.cols() <= points.rows() + 1, "1 to d + 1 points in R^d");
  if (!points.allFinite()) return std::nullopt;
  const Circumcentre<Eigen::Dynamic> found = circumcentre<Eigen::Dynamic>(points);
  if (!found.independent) return std::nullopt;
  return Ball{found.centre, (points.colwise() - found.centre).colwise().norm().maxCoeff()};
}

Ball smallest_ball(const Eigen::Ref<const Eigen::MatrixXd>& points) {
  FEDER_CHECK(points.rows() >= 1, "points of no dimension");
  if (points.cols() == 0) return {VectorXd::Zero(points.rows())};
  const Ball ball = points.outerStride() == points.rows() ? ball_of_points(points)
                                                          : ball_of_points(Eigen::MatrixXd(points));
  constexpr double kSafe = 1e140;
  return ball.radius > 1.0 / kSafe && ball.radius < kSafe ? ball : ball_of_extreme(points);
}

}  // namespace feder
