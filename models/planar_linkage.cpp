// Four bars: C lies on circles about B (coupler b) and D (rocker c); h = |D - B|, along BD by
// (h^2 + b^2 - c^2)/(2 h). Rates from a w e'(theta) + b w_b e'(beta) = c w_c e'(psi), e' = (-sin, cos):
//   w_b = a w sin(psi - theta)/(b sin(beta - psi)),   w_c = a w sin(beta - theta)/(c sin(beta - psi))
#include "models/planar_linkage.h"

#include <Eigen/Geometry>
#include <cmath>

#include "engine/check.h"
#include "models/parameters.h"

namespace feder {
namespace {

Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}
double angle_of(const Vector2d& d) {
  return std::atan2(d.y(), d.x());
}

}  // namespace

Matrix3d LinkagePlane::turned(double angle) const {
  return axes * Eigen::AngleAxisd(angle, Vector3d::UnitZ()).toRotationMatrix();
}

LinkagePlane tilted_plane(double tilt) {
  return {Eigen::AngleAxisd(tilt, Vector3d(1.0, 2.0, 2.0) / 3.0).toRotationMatrix()};
}

PlanePoint along(const PlanePoint& from, const PlaneTurn& turn, double length) {
  const Vector2d e = length * direction(turn.angle);
  return {from.place + e, from.velocity + turn.rate * Vector2d(-e.y(), e.x())};
}

Anchor add_bar(SystemBuilder& builder, const std::string& where, const LinkagePlane& plane,
               const BarShape& shape, const PlanePoint& from, const PlaneTurn& turn) {
  const PlanePoint middle = along(from, turn, 0.5 * shape.length);
  return builder.add_body(solid_box(where, shape.mass, {shape.length, shape.width, shape.width}),
                          {.position = plane.at(middle.place),
                           .orientation = plane.turned(turn.angle),
                           .velocity = plane.at(middle.velocity),
                           .angular_velocity = turn.rate * plane.axis()});
}

FourBarMotion four_bar_motion(const std::string& where, const FourBarLengths& l, const PlaneTurn& crank,
                              bool crossed) {
  constexpr double kInLine = 1e-9;            // [rad]
  constexpr double kRounding = 16 * 2.2e-16;  // of a squared height: below, coupler and rocker are in line
  FourBarMotion m;
  m.crank = crank;
  m.B = along({}, crank, l.crank);
  const Vector2d D(l.ground, 0.0), diagonal = D - m.B.place;
  const double h = diagonal.norm(), reach = (h * h + l.coupler * l.coupler - l.rocker * l.rocker) / (2.0 * h),
               height2 = l.coupler * l.coupler - reach * reach;
  const double rounding = kRounding * l.coupler * l.coupler,
               height = height2 > rounding ? std::sqrt(height2) : 0.0;
  if (!(height2 >= -rounding))
    fail_input(where, "distance from the crank's end to the rocker's pivot", h, "m",
               "more than 0 and within " + to_text(std::abs(l.coupler - l.rocker)) + " to " +
                   to_text(l.coupler + l.rocker) + ", where coupler and rocker meet");
  const Vector2d left(-diagonal.y(), diagonal.x());
  const Vector2d C = m.B.place + (reach * diagonal + (crossed ? -1.0 : 1.0) * height * left) / h;
  m.coupler.angle = angle_of(C - m.B.place);
  m.rocker.angle = angle_of(C - D);
  const double sine = std::sin(m.coupler.angle - m.rocker.angle), push = l.crank * crank.rate;
  if (push != 0.0 && std::abs(sine) < kInLine)
    fail_input(where, "angle", crank.angle, "rad",
               "one at which coupler and rocker are not in line, or a crank at rest");
  if (push != 0.0) {
    m.coupler.rate = push * std::sin(m.rocker.angle - crank.angle) / (l.coupler * sine);
    m.rocker.rate = push * std::sin(m.coupler.angle - crank.angle) / (l.rocker * sine);
  }
  m.C = along(m.B, m.coupler, l.coupler);
  return m;
}

}  // namespace feder
