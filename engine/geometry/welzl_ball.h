#pragma once

#include <cstdint>

#include "engine/geometry/smallest_ball.h"

namespace feder {

struct WelzlBall {
  Ball ball;
  std::int64_t inside_tests = 0;
};

/// smallest_ball by Welzl's algorithm as the notes have it (A15), counting the tests of a point against a
/// ball (A17: expected number per point below (d+1)! sum_{j=1..d+1} 1/j!, so 3, 10, 41 for d = 1, 2, 3). The
/// seed fixes the random order of the points; recursion is at most d + 1 deep. For the experiment that shows
/// the bound: smallest_ball is faster. InputError as there.
WelzlBall welzl_ball(const Eigen::Ref<const Eigen::MatrixXd>& points, std::uint64_t seed);

}  // namespace feder
