#include "engine/joints.h"

#include <Eigen/Geometry>

#include "engine/check.h"

namespace feder {
namespace {

// Right-handed axes, the first along `axis`.
struct Axes {
  Vector3d x, y, z;
};
Axes axes_along(const char* joint, const Vector3d& axis) {
  const double length = axis.norm();
  if (!(length > 0.0) || !axis.allFinite())
    fail_input(joint, "length of its axis", length, "m", "a direction");
  const Vector3d x = axis / length, y = x.unitOrthogonal();
  return {x, y, x.cross(y)};
}

// Writes the rows of one joint and keeps their ids.
class Joint {
 public:
  Joint(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const JointMaterial& material)
      : builder_(builder),
        material_(material),
        a_(builder.anchor_at(a, place)),
        b_(builder.anchor_at(b, place)) {}

  void ball() {
    const Material& m = material_.linear;
    rows.push_back(builder_.add(BallRow{{a_, b_, m.stiffness, m.damping_time, m.damping}}));
  }
  void perpendicular(const Vector3d& of_a, const Vector3d& of_b) {
    const Material& m = material_.angular;
    rows.push_back(builder_.add(PerpendicularRow{{a_, b_, m.stiffness, m.damping_time, m.damping},
                                                 builder_.direction_in(a_, of_a),
                                                 builder_.direction_in(b_, of_b)}));
  }
  void on_axis(const Axes& axes) {  // slides and turns along x
    along(axes.y);
    along(axes.z);
    perpendicular(axes.x, axes.y);
    perpendicular(axes.x, axes.z);
  }
  void along(const Vector3d& axis) {
    const Material& m = material_.linear;
    rows.push_back(builder_.add(
        AlongRow{{{a_, b_, m.stiffness, m.damping_time, m.damping}}, builder_.direction_in(a_, axis)}));
  }

  std::vector<int> rows;

 private:
  SystemBuilder& builder_;
  JointMaterial material_;
  Anchor a_, b_;
};

}  // namespace

std::vector<int> add_ball(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                          const JointMaterial& material) {
  Joint joint(builder, a, b, place, material);
  joint.ball();
  return joint.rows;
}

std::vector<int> add_universal(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                               const Vector3d& axis_a, const Vector3d& axis_b,
                               const JointMaterial& material) {
  Joint joint(builder, a, b, place, material);
  joint.ball();
  joint.perpendicular(axes_along("universal joint", axis_a).x, axes_along("universal joint", axis_b).x);
  return joint.rows;
}

std::vector<int> add_hinge(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                           const Vector3d& axis, const JointMaterial& material) {
  const Axes axes = axes_along("hinge", axis);
  Joint joint(builder, a, b, place, material);
  joint.ball();
  joint.perpendicular(axes.x, axes.y);
  joint.perpendicular(axes.x, axes.z);
  return joint.rows;
}

std::vector<int> add_cylindrical(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                                 const Vector3d& axis, const JointMaterial& material) {
  const Axes axes = axes_along("cylindrical joint", axis);
  Joint joint(builder, a, b, place, material);
  joint.on_axis(axes);
  return joint.rows;
}

std::vector<int> add_prismatic(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                               const Vector3d& axis, const JointMaterial& material) {
  const Axes axes = axes_along("prismatic joint", axis);
  Joint joint(builder, a, b, place, material);
  joint.on_axis(axes);
  joint.perpendicular(axes.y, axes.z);
  return joint.rows;
}

std::vector<int> add_weld(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place,
                          const JointMaterial& material) {
  Joint joint(builder, a, b, place, material);
  joint.ball();
  joint.perpendicular(Vector3d::UnitX(), Vector3d::UnitY());
  joint.perpendicular(Vector3d::UnitX(), Vector3d::UnitZ());
  joint.perpendicular(Vector3d::UnitY(), Vector3d::UnitZ());
  return joint.rows;
}

namespace {

// An anchor of the row itself: its place does not matter to a turn.
int add_turn_row(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& axis, const Material& m,
                 double rest, Anchor dial) {
  const Axes axes = axes_along("turn", axis);
  if (a.body < 0 && a.node < 0) a = builder.anchor_at(a, Vector3d::Zero());
  if (b.body < 0 && b.node < 0) b = builder.anchor_at(b, Vector3d::Zero());
  return builder.add(TurnRow{{{a, b, m.stiffness, m.damping_time, m.damping}, rest, dial},
                             builder.direction_in(a, axes.x),
                             builder.direction_in(a, axes.y),
                             builder.direction_in(b, axes.y)});
}

int add_slide_row(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const Vector3d& axis,
                  const Material& m, double rest, Anchor dial) {
  const Axes axes = axes_along("slide", axis);
  a = builder.anchor_at(a, place), b = builder.anchor_at(b, place);
  return builder.add(AlongRow{{{a, b, m.stiffness, m.damping_time, m.damping}, rest, dial},
                              builder.direction_in(a, axes.x)});
}

}  // namespace

int add_turn(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& axis, const Material& material,
             double rest) {
  return add_turn_row(builder, a, b, axis, material, rest, {});
}
int add_turn(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& axis, const Material& material,
             const Target& target) {
  return add_turn_row(builder, a, b, axis, material, 0.0, builder.add_dial(target));
}
int add_slide(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const Vector3d& axis,
              const Material& material, double rest) {
  return add_slide_row(builder, a, b, place, axis, material, rest, {});
}
int add_slide(SystemBuilder& builder, Anchor a, Anchor b, const Vector3d& place, const Vector3d& axis,
              const Material& material, const Target& target) {
  return add_slide_row(builder, a, b, place, axis, material, 0.0, builder.add_dial(target));
}

}  // namespace feder
