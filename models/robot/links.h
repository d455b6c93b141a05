#pragma once

#include <vector>

#include "engine/mass_properties.h"
#include "models/robot/dh.h"

namespace feder {

/// The links of an arm of the catalogue as rigid bodies, each in the axes of its frame (frames(arm, q)[i +
/// 1]).
///   puma560: published (Armstrong, Khatib and Burdick, ICRA 1986), but for the two links named in links.cpp
///   others: uniform bars between the joint axes, of published masses where there are any
std::vector<MassProperties> link_bodies(const Arm& arm);

}  // namespace feder
