#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "engine/geometry/triangle_mesh.h"
#include "engine/state.h"

namespace feder {

/// Mass, centre and inertia of a rigid distribution, all in the axes its points were given in. A thin rod or
/// a single point is a valid part of a composition, but no rigid body of its own: see check_inertia.
struct MassProperties {
  double mass = 0.0;                    ///< [kg]
  Vector3d centre = Vector3d::Zero();   ///< centre of mass [m]
  Matrix3d inertia = Matrix3d::Zero();  ///< about the centre [kg m^2], symmetric
};

struct PointMass {
  double mass = 0.0;                     ///< [kg]
  Vector3d position = Vector3d::Zero();  ///< [m]
};

/// inertia = axes * moments.asDiagonal() * axes^T.
struct PrincipalAxes {
  Matrix3d axes;     ///< columns; a rotation, determinant +1
  Vector3d moments;  ///< ascending [kg m^2]
};

// Shapes, centred at the origin. Masses [kg], lengths [m] and densities [kg/m^3] must be finite and > 0,
// otherwise InputError naming `where`. The inertia is not checked: a part may be flat or thin.
MassProperties solid_box(const std::string& where, double mass, const Vector3d& edges);
MassProperties solid_sphere(const std::string& where, double mass, double radius);
/// A shell without thickness.
MassProperties hollow_sphere(const std::string& where, double mass, double radius);
/// Axis z.
MassProperties solid_cylinder(const std::string& where, double mass, double radius, double height);
/// Along z, without thickness: inertia(2, 2) is exactly 0.
MassProperties thin_rod(const std::string& where, double mass, double length);

/// At least one point; masses > 0, positions finite, otherwise InputError naming the point.
MassProperties point_masses(const std::string& where, const std::vector<PointMass>& points);

/// The solid inside a closed triangle mesh of constant density [kg/m^3]. InputError as check_closed_mesh, and
/// for an inertia no solid has (a cavity outside the body).
MassProperties solid_mesh(const std::string& where, double density, const TriangleMesh& mesh);

/// The same body after x -> rotation x + translation [m]; axes and origin stay. Misuse: not a rotation.
MassProperties moved(const MassProperties& p, const Matrix3d& rotation, const Vector3d& translation);

/// One rigid body made of at least one part (notes C8); independent of their order up to rounding. InputError
/// names a part without mass or with entries that are not finite.
MassProperties combined(const std::string& where, const std::vector<MassProperties>& parts);

/// Inertia about another point [m] (Steiner, notes C7) [kg m^2].
Matrix3d inertia_about(const MassProperties& p, const Vector3d& point);

/// Misuse: an inertia that is not finite. Only the lower triangle is read.
PrincipalAxes principal_axes(const MassProperties& p);

/// C = integral of x x^T dm and I = tr(C) E - C about the same point, both [kg m^2] (notes C5).
Matrix3d inertia_from_covariance(const Matrix3d& covariance);
Matrix3d covariance_from_inertia(const Matrix3d& inertia);

/// Refuses what is no rigid body: InputError unless the mass is > 0, everything is finite, the inertia is
/// symmetric, every principal moment is > 0 (with a zero moment, a thin rod or a point, the mass matrix is
/// singular) and none exceeds the sum of the others. Equality, a flat plate, passes. All up to rounding,
/// 1e-12 of the largest moment.
void check_inertia(const std::string& where, const MassProperties& p);

}  // namespace feder
