// cos B = (r^2 - a^2 - b^2) / (2 a b), as half-angle: tan^2(B/2) = ((a+b)^2 - r^2) / (r^2 - (a-b)^2), which
// loses nothing where the arm is nearly stretched or folded; A = atan2(y, x) - atan2(b sin B, a + b cos B).
#include "solvers/two_link.h"

#include <cmath>
#include <numbers>

#include "engine/check.h"

namespace feder {

std::optional<std::array<TwoLinkAngles, 2>> two_link_angles(double a, double b, double x, double y) {
  require_positive("two links", "a", a, "m");
  require_positive("two links", "b", b, "m");
  require_finite("two links", "x", x, "m");
  require_finite("two links", "y", y, "m");
  const double r = std::hypot(x, y);
  const double outer = (a + b - r) * (a + b + r), inner = (r - std::abs(a - b)) * (r + std::abs(a - b));
  if (outer < 0.0 || inner < 0.0) return std::nullopt;
  std::array<TwoLinkAngles, 2> both;
  for (const int side : {0, 1}) {
    const double B = (side == 0 ? 2.0 : -2.0) * std::atan2(std::sqrt(outer), std::sqrt(inner));
    const double towards = r > 0.0 ? std::atan2(y, x) : 0.0;
    both[side] = {towards - std::atan2(b * std::sin(B), a + b * std::cos(B)), B};
  }
  return both;
}

std::optional<TwoLinkAngles> two_link_near(double a, double b, double x, double y,
                                           const TwoLinkAngles& last) {
  const auto both = two_link_angles(a, b, x, y);
  if (!both) return std::nullopt;
  auto near = [](double angle, double wanted) {
    return angle + 2.0 * std::numbers::pi * std::round((wanted - angle) / (2.0 * std::numbers::pi));
  };
  TwoLinkAngles best;
  double least = std::numeric_limits<double>::infinity();
  for (const TwoLinkAngles& one : *both) {
    const TwoLinkAngles turned{near(one.A, last.A), near(one.B, last.B)};
    const double way = std::hypot(turned.A - last.A, turned.B - last.B);
    if (way < least) least = way, best = turned;
  }
  return best;
}

}  // namespace feder
