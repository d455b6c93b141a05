// Each joint goes from half its sweep below the middle of its limits to as much above, every second one back.
#include "models/robot_arm.h"

#include <algorithm>
#include <numbers>

#include "engine/check.h"
#include "models/parameters.h"
#include "models/robot/arms.h"
#include "models/robot/links.h"

namespace feder {
namespace {

using Options = RobotArm;

std::vector<std::string> arm_names() {
  std::vector<std::string> names;
  for (const ArmInfo& info : arm_list()) names.push_back(info.name);
  return names;
}

// Of Field, for a member that counts through a list of names.
Field<Options> named_arm() {
  const std::vector<std::string> names = arm_names();
  return {{"arm", names[static_cast<std::size_t>(Options{}.arm)], "", "which arm", "one of " + join(names)},
          [=](Options& o, const std::string& place, const std::string& text) {
            o.arm = parse_choice(place, "arm", text, names);
          },
          [=](const Options& o, const std::string& place) {
            if (o.arm < 0 || o.arm >= std::ssize(names))
              fail_input(place, "arm", o.arm, "", "a place in the list");
          }};
}

const Fields<Options>& fields() {
  static const Fields<Options> list = {
      named_arm(),
      field("control", &Options::control,
            "free: falls; motors: on its path exactly; pd: springs and dampers; computed_torque: inverse "
            "dynamics",
            {"free", "motors", "pd", "computed_torque"}),
      field("sweep", &Options::sweep, "", "way of each joint, of its limits", {0.0, 0.5}),
      field("duration", &Options::duration, "s", "of the motion", kPositive),
      field("frequency", &Options::frequency, "rad/s", "of pd and computed_torque", kPositive),
      field("gravity", &Options::gravity, "m/s^2", "along -z", kAnyNumber),
  };
  return list;
}

}  // namespace

JointPath path_of(const Options& o) {
  const Arm arm = arm_list()[static_cast<std::size_t>(o.arm)].make();
  JointPath path{VectorXd(arm.joints()), VectorXd(arm.joints()), o.duration};
  for (int i = 0; i < arm.joints(); ++i) {
    const DhRow& row = arm.rows[i];
    const double range = row.greatest - row.least,
                 way = row.prismatic ? range : std::min(range, std::numbers::pi);
    const double middle = 0.5 * (row.least + row.greatest), half = (i % 2 ? -0.5 : 0.5) * o.sweep * way;
    path.start[i] = middle - half, path.goal[i] = middle + half;
  }
  return path;
}

Model make_robot_arm(const Options& o) {
  check_fields("model robot_arm", fields(), o);
  const Arm arm = arm_list()[static_cast<std::size_t>(o.arm)].make();
  const std::vector<MassProperties> links = link_bodies(arm);
  const JointPath path = path_of(o);
  const Vector3d gravity(0.0, 0.0, -o.gravity);

  SystemBuilder builder;
  const ArmBodies bodies = add_arm(builder, arm, links, path.start, VectorXd::Zero(arm.joints()));
  builder.set_gravity(gravity);
  const std::vector<Material> rigid(arm.rows.size(), {kRigid});
  switch (o.control) {
    case ArmControl::kLoose:
      break;
    case ArmControl::kMotors:
      add_drives(builder, arm, bodies, path, rigid);
      break;
    case ArmControl::kPd:
      add_drives(builder, arm, bodies, path, pd_materials(arm, links, path.start, o.frequency));
      break;
    case ArmControl::kComputedTorque:
      builder.set_user_force(
          computed_torque(arm, links, builder.build().system.bodies, path, gravity, o.frequency));
  }
  auto [system, state] = builder.build();

  Model model{"robot_arm", std::move(system), std::move(state)};
  model.end_time = 1.2 * o.duration;
  model.scene_length = reach_of(arm).greatest;
  if (o.control == ArmControl::kLoose) model.conserved = {conserved_energy()};
  return model;
}

ModelInfo robot_arm_model() {
  return describe("robot_arm", "an arm of published tables as bodies, led along a path of its joints",
                  fields(), make_robot_arm);
}

}  // namespace feder
