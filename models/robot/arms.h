#pragma once

#include <string>
#include <vector>

#include "models/robot/dh.h"

namespace feder {

/// An arm of the catalogue.
struct ArmInfo {
  std::string name, description;
  Arm (*make)();
};

/// THE LIST of arms, in arms.cpp.
const std::vector<ArmInfo>& arm_list();
/// By name; throws InputError listing the names if there is none like it.
Arm make_arm(const std::string& name);

/// Two links a and b [m] in the xy plane (notes F1). No real arm: joints turn from -pi to pi.
Arm planar_2r(double a = 1.0, double b = 0.6);
/// n links of equal length, together 1 m, in the xy plane.
Arm planar_nr(int n);
Arm puma560();
Arm stanford();
Arm ur5();
Arm panda();

}  // namespace feder
