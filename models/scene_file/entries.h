// What a scene file can say: one struct per table, filled by the keys in entries.cpp.
#pragma once

#include <string>
#include <vector>

#include "models/scene_file/keys.h"

namespace feder {

/// An entry's own place and how messages call it: "spring 'rope'", "spring 3".
struct Entry {
  TextPlace place = {};
  std::string label = {};
  bool broken = false;  ///< some key was refused: names are still looked up, nothing is built
};

struct MaterialKeys {
  NameText material = {};  ///< name of a [[material]]
  PlacedNumber stiffness = {}, damping_time = {}, damping = {};
};

struct MaterialEntry : Entry {
  NameText name = {};
  double stiffness = 0.0, damping_time = 0.0, damping = 0.0;
};
struct PointEntry : Entry {
  NameText name = {}, group = {};
  PlacedVector position = {};
  std::array<FunctionText, 3> motion = {};
};
struct ParticleEntry : Entry {
  NameText name = {}, group = {};
  double mass = 0.0;  ///< infinite: "fixed"
  Vector3d position = Vector3d::Zero();
  PlacedVector velocity = {};
  FreeMask free = kFree;
};

/// A shape with its mass, part of a body or all of it.
struct ShapeKeys {
  enum Kind { kBox, kSphere, kHollowSphere, kCylinder, kRod, kMesh, kGiven, kParts };
  Placed<int> shape = {};
  PlacedNumber mass = {}, density = {}, radius = {}, height = {}, length = {}, scale = {};
  PlacedVector edges = {};
  NameText mesh = {};
  Placed<std::vector<double>> inertia = {};
  PlacedVector centre = {};
};
struct PartEntry : Entry, ShapeKeys {
  Vector3d position = Vector3d::Zero();
  Orientation orientation = {};
};
struct BodyEntry : Entry, ShapeKeys {
  NameText name = {}, group = {};
  std::vector<PartEntry> parts = {};
  Vector3d position = Vector3d::Zero(), velocity = Vector3d::Zero(), angular_velocity = Vector3d::Zero();
  Orientation orientation = {};
  FreeMask free = kFree, free_spin = kFree;
};

struct SpringEntry : Entry, MaterialKeys {
  NameText name = {};
  std::vector<AnchorText> between = {};
  PlacedNumber length = {};
};
struct LawSpringEntry : Entry {
  NameText name = {};
  std::vector<AnchorText> between = {};
  FunctionText tension = {};
};
struct BendingEntry : Entry, MaterialKeys {
  NameText name = {};
  std::vector<AnchorText> over = {};
  PlacedNumber rest_angle = {};
};
struct JointEntry : Entry, MaterialKeys {
  enum Kind { kBall, kUniversal, kHinge, kCylindrical, kPrismatic, kWeld };
  NameText name = {};
  int type = kBall;
  std::vector<AnchorText> between = {};
  Vector3d place_at = Vector3d::Zero();
  PlacedVector axis = {}, axis_b = {};
  PlacedNumber angular_stiffness = {}, angular_damping_time = {}, angular_damping = {};
};
struct TurnEntry : Entry, MaterialKeys {
  NameText name = {};
  std::vector<AnchorText> between = {};
  Vector3d axis = Vector3d::UnitZ();
  FunctionText target = {};
};
struct SlideEntry : Entry, MaterialKeys {
  NameText name = {};
  std::vector<AnchorText> between = {};
  Vector3d place_at = Vector3d::Zero(), axis = Vector3d::UnitX();
  FunctionText target = {};
};
struct PerpendicularEntry : Entry, MaterialKeys {
  NameText name = {};
  std::vector<AnchorText> between = {};
  Vector3d direction_a = Vector3d::UnitX(), direction_b = Vector3d::UnitY();
};
struct ForceEntry : Entry {
  AnchorText on = {};
  std::array<FunctionText, 3> force = {};
};
struct TorqueEntry : Entry {
  NameText on = {};
  Vector3d torque = Vector3d::Zero();
};

struct ChainEntry : Entry, MaterialKeys {
  NameText name = {};
  Vector3d from = Vector3d::Zero(), to = Vector3d::UnitX();
  int count = 0;
  double mass = 0.0, bending_stiffness = 0.0;
  std::vector<std::string> fixed = {};
};
struct ClothEntry : Entry, MaterialKeys {
  NameText name = {};
  Vector3d corner = Vector3d::Zero(), edge_u = Vector3d::UnitX(), edge_v = Vector3d::UnitZ();
  std::vector<double> count = {};
  double mass = 0.0;
  PlacedNumber shear_stiffness = {}, bend_stiffness = {};
  std::vector<std::string> fixed = {};
};
struct LatticeEntry : Entry, MaterialKeys {
  NameText name = {};
  Vector3d corner = Vector3d::Zero(), size = Vector3d::Ones();
  std::vector<double> count = {};
  double mass = 0.0;
  std::vector<std::string> fixed = {};
};
struct NetEntry : Entry, MaterialKeys {
  NameText name = {};
  Vector3d corner = Vector3d::Zero();
  std::vector<double> count = {};
  double edge = 0.0, thickness = 0.0, mass = 0.0;
  std::vector<std::string> fixed = {};
};

/// A scene file, read and checked key by key; names are not looked up yet.
struct Document : Entry {
  std::string title;
  NameText model;
  PlacedNumber end_time, quick_end_time, scene_length;
  Vector3d gravity = Vector3d::Zero();
  double drag = 0.0;
  std::vector<MaterialEntry> materials;
  std::vector<PointEntry> points;
  std::vector<ParticleEntry> particles;
  std::vector<BodyEntry> bodies;
  std::vector<SpringEntry> springs;
  std::vector<LawSpringEntry> law_springs;
  std::vector<BendingEntry> bendings;
  std::vector<JointEntry> joints;
  std::vector<TurnEntry> turns;
  std::vector<SlideEntry> slides;
  std::vector<PerpendicularEntry> perpendiculars;
  std::vector<ForceEntry> forces;
  std::vector<TorqueEntry> torques;
  std::vector<ChainEntry> chains;
  std::vector<ClothEntry> cloths;
  std::vector<LatticeEntry> lattices;
  std::vector<NetEntry> nets;
};

/// A table of the file: "[output]", or "[[spring]]" which may be repeated.
struct TableInfo {
  std::string name, what;
  bool repeated = true;
  std::vector<KeyInfo> keys;
};
/// Every table of a scene, in the order of the reference page; the first, without a name, is the top level.
std::vector<TableInfo> scene_tables();

/// Reads a document. Tables named in `others` are left to the caller.
Document read_document(const Value& root, const std::vector<std::string>& others, Diagnostics& problems);

}  // namespace feder
