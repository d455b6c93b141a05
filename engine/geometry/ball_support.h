// The points a smallest ball rests on, with convex weights of its centre: maximal is
//   sum l_i |p_i|^2 - |sum l_i p_i|^2,   l_i >= 0, sum l_i = 1,
// the squared radius. An entering point starts with weight 0; the weights move to those of the new
// circumcentre and drop what reaches 0 on the way (Wolfe, Finding the nearest point in a polytope, 1976).
#pragma once

#include <algorithm>
#include <limits>

#include "engine/geometry/circumcentre.h"

namespace feder {

template <int D>
class BallSupport {
 public:
  explicit BallSupport(const DVector<D>& p) : points_(p), weights_(FewNumbers<D>::Ones(1)), centre_(p) {}
  const FewPoints<D>& points() const { return points_; }
  const DVector<D>& centre() const { return centre_; }
  double squared_radius() const { return (points_.colwise() - centre_).colwise().squaredNorm().maxCoeff(); }

  /// The smallest ball of a part of support and p, larger than before if p was outside.
  void enter(const DVector<D>& p) {
    append(p);
    for (;;) {
      const Circumcentre<D> target = circumcentre<D>(points_);
      const FewNumbers<D> direction = target.independent ? target.weights - weights_ : uphill(target.weights);
      double step = target.independent ? 1.0 : std::numeric_limits<double>::infinity();
      Eigen::Index leaving = -1;
      for (Eigen::Index i = 0; i < direction.size(); ++i)
        if (direction[i] < 0.0 && std::max(0.0, weights_[i]) < -step * direction[i]) {
          step = std::max(0.0, weights_[i]) / -direction[i];
          leaving = i;
        }
      if (leaving < 0) {
        weights_ = target.weights;
        centre_ = target.centre;
        return;
      }
      weights_ += step * direction;
      remove(leaving);
    }
  }

 private:
  // Along an affine dependence the centre stays and the objective is linear.
  FewNumbers<D> uphill(const FewNumbers<D>& dependence) const {
    const double slope =
        (points_.colwise() - centre_).colwise().squaredNorm().transpose().cwiseProduct(dependence).sum();
    return slope < 0.0 ? FewNumbers<D>(-dependence) : dependence;
  }
  void append(const DVector<D>& p) {
    points_.conservativeResize(points_.rows(), points_.cols() + 1);
    points_.col(points_.cols() - 1) = p;
    weights_.conservativeResize(points_.cols());
    weights_[points_.cols() - 1] = 0.0;
  }
  void remove(Eigen::Index i) {
    const Eigen::Index last = points_.cols() - 1;
    points_.col(i) = points_.col(last).eval();
    weights_[i] = weights_[last];
    points_.conservativeResize(points_.rows(), last);
    weights_.conservativeResize(last);
  }

  FewPoints<D> points_;
  FewNumbers<D> weights_;
  DVector<D> centre_;
};

}  // namespace feder
