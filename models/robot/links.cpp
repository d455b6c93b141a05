// A bar reaches from one frame's origin to the next: of a standard table from frame i - 1 to frame i, of a
// modified one from frame i to frame i + 1. Both are at rest in frame i.
#include "models/robot/links.h"

#include <Eigen/Geometry>

namespace feder {
namespace {

constexpr double kWidth = 0.08;       // of the bars' square sections and of knots where axes meet [m]
constexpr double kMassPerLink = 1.0;  // of arms that are none in reality [kg]
constexpr double kPandaMass = 18.0;   // data sheet: whole arm; the maker publishes none of its links [kg]

MassProperties uniform_link(const std::string& place, double mass, const Vector3d& from, const Vector3d& to) {
  const Vector3d along = to - from;
  const double length = along.norm();
  if (length < kWidth)
    return moved(solid_sphere(place, mass, 0.5 * kWidth), Matrix3d::Identity(), 0.5 * (from + to));
  const Matrix3d axes = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitX(), along).toRotationMatrix();
  return moved(solid_box(place, mass, {length, kWidth, kWidth}), axes, 0.5 * (from + to));
}

// In frame i. A rack that slides reaches back by all it can.
std::pair<Vector3d, Vector3d> ends(const Arm& arm, int i) {
  if (arm.convention == DhConvention::kStandard) {
    const DhRow& row = arm.rows[i];
    const Pose T = row_transform(row, arm.convention, row.prismatic ? row.greatest : 0.0);
    return {-(T.rotation.transpose() * T.position), Vector3d::Zero()};
  }
  if (i + 1 == arm.joints()) return {Vector3d::Zero(), arm.tool.position};
  return {Vector3d::Zero(), row_transform(arm.rows[i + 1], arm.convention, 0.0).position};
}

// Stanford: Paul 1981, table 6.5. UR5: the ROS package ur_description, from its controller.
std::vector<double> masses(const Arm& arm) {
  const auto n = static_cast<std::size_t>(arm.joints());
  if (arm.name == "stanford") return {9.29, 5.01, 4.25, 1.08, 0.63, 0.51};
  if (arm.name == "ur5") return {3.7, 8.393, 2.275, 1.219, 1.219, 0.1879};
  if (arm.name == "panda") return std::vector<double>(n, kPandaMass / arm.joints());
  return std::vector<double>(n, kMassPerLink);
}

MassProperties published(double mass, const Vector3d& centre, const Vector3d& moments) {
  return {mass, centre, moments.asDiagonal()};
}

// Link 1: only its moment about the base axis, 0.35, is published and matters; 1 kg and equal moments are
// chosen. Link 3: no body has the published 0.066, 0.086, 0.0125 (0.086 exceeds the sum of the others):
// 0.0025 is taken from the largest and given to both others, and it is flat. Centres and axes are those of
// the standard frames, as the Robotics Toolbox has them.
std::vector<MassProperties> puma560_links() {
  return {published(1.0, {0.0, 0.0, 0.0}, {0.35, 0.35, 0.35}),
          published(17.4, {-0.3638, 0.006, 0.2275}, {0.13, 0.524, 0.539}),
          published(4.8, {-0.0203, -0.0141, 0.070}, {0.0685, 0.0835, 0.0150}),
          published(0.82, {0.0, 0.019, 0.0}, {1.8e-3, 1.3e-3, 1.8e-3}),
          published(0.34, {0.0, 0.0, 0.0}, {0.3e-3, 0.4e-3, 0.3e-3}),
          published(0.09, {0.0, 0.0, 0.032}, {0.15e-3, 0.15e-3, 0.04e-3})};
}

}  // namespace

std::vector<MassProperties> link_bodies(const Arm& arm) {
  check_arm(arm);
  if (arm.name == "puma560") return puma560_links();
  std::vector<MassProperties> links;
  const std::vector<double> mass = masses(arm);
  for (int i = 0; i < arm.joints(); ++i) {
    const auto [from, to] = ends(arm, i);
    links.push_back(uniform_link("arm '" + arm.name + "' link " + std::to_string(i + 1), mass[i], from, to));
  }
  return links;
}

}  // namespace feder
