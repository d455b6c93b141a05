// Parts of planar linkages, turned anywhere in space.
#pragma once

#include <Eigen/Core>
#include <string>

#include "engine/system.h"

namespace feder {

using Eigen::Vector2d;

/// The plane a linkage moves in: columns x, y and the axis of its hinges.
struct LinkagePlane {
  Matrix3d axes = Matrix3d::Identity();

  Vector3d at(const Vector2d& p) const { return axes.leftCols<2>() * p; }
  Vector3d axis() const { return axes.col(2); }
  Matrix3d turned(double angle) const;  ///< body axes, x at this angle from the plane's x
};
/// The xy plane turned about (1, 2, 2)/3: no axis of it stays in a coordinate plane.
LinkagePlane tilted_plane(double tilt);

/// A point that moves in the plane [m, m/s].
struct PlanePoint {
  Vector2d place = Vector2d::Zero(), velocity = Vector2d::Zero();
};
/// A direction that turns in the plane [rad, rad/s].
struct PlaneTurn {
  double angle = 0.0, rate = 0.0;
};
/// The point `length` further along `turn`.
PlanePoint along(const PlanePoint& from, const PlaneTurn& turn, double length);

struct BarShape {
  double mass, length, width;  ///< a solid box with a square section [kg, m, m]
};
/// A bar from `from` along `turn`; its own axes lie in its middle, x along it.
Anchor add_bar(SystemBuilder& builder, const std::string& where, const LinkagePlane& plane,
               const BarShape& shape, const PlanePoint& from, const PlaneTurn& turn);

/// Lengths of a four-bar linkage: ground from A = (0, 0) to D = (ground, 0), crank AB, coupler BC, rocker DC.
struct FourBarLengths {
  double ground, crank, coupler, rocker;
};
struct FourBarMotion {
  PlaneTurn crank, coupler, rocker;
  PlanePoint B, C;
};
/// The pose with C to the left of BD (`crossed`: to the right) and its velocities. InputError naming `where`
/// if coupler and rocker do not meet at this crank angle, or lie in line and cannot follow its rate.
FourBarMotion four_bar_motion(const std::string& where, const FourBarLengths& lengths, const PlaneTurn& crank,
                              bool crossed);

}  // namespace feder
