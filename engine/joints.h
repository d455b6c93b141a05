#pragma once

#include <vector>

#include "engine/system.h"

namespace feder {

/// Materials of a joint's rows that hold places and of those that hold directions; rigid by default.
struct JointMaterial {
  Material linear{kRigid}, angular{kRigid};  ///< [N/m], [N m]
};

/// Joints between two bodies, or a body and the world (Anchor{}), as rows of the one matrix. Places and axes
/// are given in the world at the start, where every joint is closed. Each returns the public ids of its rows,
/// in the order named. Freedoms left:
std::vector<int> add_ball(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                          const JointMaterial& material = {});  ///< 3: ball
std::vector<int> add_universal(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                               const Vector3d& axis_a, const Vector3d& axis_b,
                               const JointMaterial& material = {});  ///< 2: ball, perpendicular axes
std::vector<int> add_hinge(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                           const Vector3d& axis, const JointMaterial& material = {});  ///< 1: ball, two
std::vector<int> add_cylindrical(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                                 const Vector3d& axis,
                                 const JointMaterial& material = {});  ///< 2: two along, two perpendicular
std::vector<int> add_prismatic(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                               const Vector3d& axis,
                               const JointMaterial& material = {});  ///< 1: two along, three perpendicular
std::vector<int> add_weld(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                          const JointMaterial& material = {});  ///< 0: ball, three perpendicular

/// The angle by which b has turned about an axis against the start (0 there), counted over turns: a torsion
/// spring or damper at rest at `rest` [rad], a motor with a target. Pairs with a hinge or cylindrical joint.
int add_turn(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& axis, const Material& material,
             double rest = 0.0);
int add_turn(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& axis, const Material& material,
             const Target& target);
/// The way b has slid along an axis of a against the start (0 there).
int add_slide(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const Vector3d& axis,
              const Material& material, double rest = 0.0);
int add_slide(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const Vector3d& axis,
              const Material& material, const Target& target);

}  // namespace feder
