#pragma once

#include <array>
#include <string>
#include <vector>

#include "models/model.h"

namespace feder {

/// Something of a scene that has a place: what output files list, in file order.
struct SceneNode {
  enum class Kind { kParticle, kPoint, kBody };
  std::string name;  ///< unique in the scene, for example "crank" or "cloth[3,4]"
  Kind kind = Kind::kParticle;
  int node = -1;  ///< its place is q[3 node .. 3 node + 2] (of a body: its centre of mass)
  int body = -1;  ///< into System::bodies, -1 if it is none
};

/// One engine row (of one or three scalar rows) of an entry.
struct SceneRow {
  std::string name;           ///< that of the entry; unique together with `type`
  std::string type;           ///< "distance", "ball", "perpendicular 1" ...
  int first_row = 0;          ///< into phi and lambda
  int rows = 1;               ///< scalar rows
  std::vector<Anchor> nodes;  ///< two places it lies between (three for bending): what a viewer connects
};

/// Several nodes under one name.
struct SceneGroup {
  std::string name;
  std::vector<int> members;  ///< into Scene::nodes
};

/// The surface of a body, for viewers alone: nothing is computed with it.
struct SceneSurface {
  int body = -1;
  std::vector<Vector3d> vertices;             ///< in the axes the body was given in [m]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
};

/// A model with the names its user gave.
struct Scene {
  Model model;
  std::vector<SceneNode> nodes;
  std::vector<SceneRow> rows;
  std::vector<SceneGroup> groups;
  std::vector<SceneSurface> surfaces;
};

}  // namespace feder
