// Tables as their sources print them; angles in degrees where the source has degrees. m and rad.
#include "models/robot/arms.h"

#include "engine/check.h"

namespace feder {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0, kRight = 0.5 * std::numbers::pi, kInch = 0.0254;

DhRow revolute(double a, double alpha, double d, double least, double greatest) {
  return {.a = a, .alpha = alpha, .d = d, .least = least, .greatest = greatest};
}
DhRow in_degrees(double a, double alpha, double d, double least, double greatest) {
  return revolute(a, alpha, d, least * kDegree, greatest * kDegree);
}

}  // namespace

// THE LIST.
const std::vector<ArmInfo>& arm_list() {
  static const std::vector<ArmInfo> list = {
      {"planar_2r", "two links in a plane", [] { return planar_2r(); }},
      {"planar_nr", "five links in a plane: redundant", [] { return planar_nr(5); }},
      {"puma560", "Unimation PUMA 560, six joints, wrist axes meet", puma560},
      {"stanford", "Stanford (Scheinman) arm, third joint prismatic", stanford},
      {"ur5", "Universal Robots UR5, six joints, no spherical wrist", ur5},
      {"panda", "Franka Emika Panda, seven joints: redundant", panda},
  };
  return list;
}

Arm make_arm(const std::string& name) {
  std::string names;
  for (const ArmInfo& info : arm_list()) {
    if (info.name == name) return info.make();
    names += (names.empty() ? "" : ", ") + info.name;
  }
  throw InputError("arm '" + name + "': unknown, expected one of " + names);
}

Arm planar_2r(double a, double b) {
  require_positive("arm 'planar_2r'", "a", a, "m");
  require_positive("arm 'planar_2r'", "b", b, "m");
  return {.name = "planar_2r", .rows = {{.a = a}, {.a = b}}, .task = {0, 1}};
}

Arm planar_nr(int n) {
  if (n < 1) fail_input("arm 'planar_nr'", "n", n, "", "at least 1");
  Arm arm{.name = "planar_nr", .rows = {}, .task = {0, 1}};
  arm.rows.assign(static_cast<std::size_t>(n), {.a = 1.0 / n});
  return arm;
}

// Standard. P. Corke, B. Armstrong-Helouvry: A search for consensus among model parameters reported for the
// PUMA 560 robot, ICRA 1994. Limits: L. T. Wang, C. C. Chen, IEEE Trans. Robotics and Automation 7(4), 1991.
Arm puma560() {
  return {.name = "puma560",
          .rows = {in_degrees(0.0, kRight, 0.0, -160.0, 160.0), in_degrees(0.4318, 0.0, 0.0, -45.0, 225.0),
                   in_degrees(0.0203, -kRight, 0.15005, -225.0, 45.0),
                   in_degrees(0.0, kRight, 0.4318, -110.0, 170.0),
                   in_degrees(0.0, -kRight, 0.0, -100.0, 100.0), in_degrees(0.0, 0.0, 0.0, -266.0, 266.0)}};
}

// Standard. Modelling, trajectory calculation and servoing of a computer controlled arm, Stanford AIM-177,
// figure 2.3. Limits of the turning joints and the rack of 38 inch: Dobrotin and Scheinman, IJCAI 1973; where
// the rack begins is not published: 12 inch, as the Robotics Toolbox reads it off a photograph.
Arm stanford() {
  Arm arm{.name = "stanford",
          .rows = {in_degrees(0.0, -kRight, 0.412, -170.0, 170.0),
                   in_degrees(0.0, kRight, 0.154, -170.0, 170.0),
                   {.theta = -kRight, .prismatic = true, .least = 12.0 * kInch, .greatest = 50.0 * kInch},
                   in_degrees(0.0, -kRight, 0.0, -170.0, 170.0),
                   in_degrees(0.0, kRight, 0.0, -90.0, 90.0),
                   in_degrees(0.0, 0.0, 0.263, -170.0, 170.0)}};
  return arm;
}

// Standard. Universal Robots: DH parameters for calculations of kinematics and dynamics (UR5, third series).
// Limits: UR5 data sheet, every joint +-360 degrees.
Arm ur5() {
  const double full = 360.0;
  return {
      .name = "ur5",
      .rows = {in_degrees(0.0, kRight, 0.089159, -full, full), in_degrees(-0.425, 0.0, 0.0, -full, full),
               in_degrees(-0.39225, 0.0, 0.0, -full, full), in_degrees(0.0, kRight, 0.10915, -full, full),
               in_degrees(0.0, -kRight, 0.09465, -full, full), in_degrees(0.0, 0.0, 0.0823, -full, full)}};
}

// Modified. Franka Emika: Robot and interface specifications (Denavit-Hartenberg parameters, limits for
// Panda); the tool is the flange, 0.107 m behind the last joint.
Arm panda() {
  return {
      .name = "panda",
      .convention = DhConvention::kModified,
      .rows = {revolute(0.0, 0.0, 0.333, -2.8973, 2.8973), revolute(0.0, -kRight, 0.0, -1.7628, 1.7628),
               revolute(0.0, kRight, 0.316, -2.8973, 2.8973), revolute(0.0825, kRight, 0.0, -3.0718, -0.0698),
               revolute(-0.0825, -kRight, 0.384, -2.8973, 2.8973),
               revolute(0.0, kRight, 0.0, -0.0175, 3.7525), revolute(0.088, kRight, 0.0, -2.8973, 2.8973)},
      .tool = {.rotation = Matrix3d::Identity(), .position = {0.0, 0.0, 0.107}}};
}

}  // namespace feder
