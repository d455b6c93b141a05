#pragma once

#include <array>
#include <optional>

namespace feder {

/// Joints of two links in a plane [rad]: A of the first link from x, B of the second from the first.
struct TwoLinkAngles {
  double A = 0.0, B = 0.0;
};

/// Both solutions of x = a cos A + b cos(A + B), y = a sin A + b sin(A + B) (notes F1, F2): B >= 0, then B <=
/// 0; equal where the arm is singular, stretched or folded. Nothing outside the ring |a - b| <= r <= a + b.
/// With a = b the target (0, 0) leaves A free: 0. InputError for lengths that are not > 0 or a place not
/// finite. [m]
std::optional<std::array<TwoLinkAngles, 2>> two_link_angles(double a, double b, double x, double y);

/// Of both the one nearer to `last`, whole turns added: followed along a path it stays on its branch.
std::optional<TwoLinkAngles> two_link_near(double a, double b, double x, double y, const TwoLinkAngles& last);

}  // namespace feder
