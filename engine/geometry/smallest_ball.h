#pragma once

#include <optional>

#include "engine/state.h"

namespace feder {

/// Closed ball in R^d. radius < 0: empty [m].
struct Ball {
  VectorXd centre;
  double radius = -1.0;
};

/// The smallest ball with all the points (columns, d x k, 1 <= k <= d + 1) [m] on its boundary: its centre
/// lies in their affine hull (notes A13). Nothing if they are affinely dependent to rounding or not finite.
/// Misuse: k out of range.
std::optional<Ball> ball_through(const Eigen::Ref<const Eigen::MatrixXd>& points);

/// The smallest ball that contains all the points (columns, d x n, any d >= 1 and n) [m], to rounding of
/// their coordinates; any order, duplicates and degenerate positions. Empty without points. Expected time O(d
/// n), a few sweeps at worst and mostly one; memory a fraction of the points, without recursion. InputError
/// names a point that is not finite.
Ball smallest_ball(const Eigen::Ref<const Eigen::MatrixXd>& points);

}  // namespace feder
