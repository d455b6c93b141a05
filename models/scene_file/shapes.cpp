#include "models/scene_file/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "models/mesh_io.h"
#include "models/scene_file/surfaces.h"

namespace feder {
namespace {

using Kind = ShapeKeys::Kind;

// Which keys each kind needs and may have, beside mass and density.
struct KindInfo {
  std::vector<std::string> needed, optional;
  bool mass = true, density = true;
};
const KindInfo& info_of(int kind) {
  static const std::vector<KindInfo> list = {
      {{"edges"}, {}},
      {{"radius"}, {}},
      {{"radius"}, {}, true, false},
      {{"radius", "height"}, {}},
      {{"length"}, {}, true, false},
      {{"mesh"}, {"scale"}},
      {{"inertia"}, {"centre"}, true, false},
      {{"parts"}, {}, false, false},
  };
  return list[static_cast<std::size_t>(kind)];
}

Matrix3d inertia_of(const std::vector<double>& numbers) {
  Matrix3d I = Matrix3d::Zero();
  for (int c = 0; c < 3; ++c) I(c, c) = numbers[static_cast<std::size_t>(c)];
  if (numbers.size() == 6) {
    I(0, 1) = I(1, 0) = numbers[3];
    I(0, 2) = I(2, 0) = numbers[4];
    I(1, 2) = I(2, 1) = numbers[5];
  }
  return I;
}

// The mass, given or density times volume [kg].
double mass_of(const ShapeKeys& keys, double volume) {
  return keys.mass.given ? keys.mass.value : keys.density.value * volume;
}

BodyShape simple_shape(const std::string& label, const ShapeKeys& k) {
  constexpr double kPi = std::numbers::pi;
  const double r = k.radius.value, h = k.height.value;
  switch (k.shape.value) {
    case ShapeKeys::kBox:
      return {solid_box(label, mass_of(k, k.edges.value.prod()), k.edges.value), box_surface(k.edges.value)};
    case ShapeKeys::kSphere:
      return {solid_sphere(label, mass_of(k, 4.0 / 3.0 * kPi * r * r * r), r), sphere_surface(r)};
    case ShapeKeys::kHollowSphere:
      return {hollow_sphere(label, k.mass.value, r), sphere_surface(r)};
    case ShapeKeys::kCylinder:
      return {solid_cylinder(label, mass_of(k, kPi * r * r * h), r, h), cylinder_surface(r, h)};
    case ShapeKeys::kRod:
      return {thin_rod(label, k.mass.value, k.length.value), {}};
    default:
      return {{k.mass.value, k.centre.value, inertia_of(k.inertia.value)}, {}};
  }
}

}  // namespace

bool ShapeReader::check_keys_of_kind(const std::string& label, TextPlace place, const ShapeKeys& keys,
                                     bool has_parts) {
  const std::pair<const char*, std::pair<bool, TextPlace>> given[] = {
      {"edges", {keys.edges.given, keys.edges.place}},
      {"radius", {keys.radius.given, keys.radius.place}},
      {"height", {keys.height.given, keys.height.place}},
      {"length", {keys.length.given, keys.length.place}},
      {"mesh", {keys.mesh.given, keys.mesh.place}},
      {"scale", {keys.scale.given, keys.scale.place}},
      {"inertia", {keys.inertia.given, keys.inertia.place}},
      {"centre", {keys.centre.given, keys.centre.place}},
      {"parts", {has_parts, place}},
      {"mass", {keys.mass.given, keys.mass.place}},
      {"density", {keys.density.given, keys.density.place}}};
  const KindInfo& kind = info_of(keys.shape.value);
  const std::size_t before = problems_.count();
  auto in = [](const std::vector<std::string>& list, const std::string& word) {
    return std::find(list.begin(), list.end(), word) != list.end();
  };
  for (const auto& [name, at] : given) {
    const bool needed = in(kind.needed, name), allowed = needed || in(kind.optional, name) ||
                                                         (std::string(name) == "mass" && kind.mass) ||
                                                         (std::string(name) == "density" && kind.density);
    if (needed && !at.first) problems_.add(place, label + ": '" + name + "' is missing for this shape");
    if (!allowed && at.first)
      problems_.add(at.second, label + ": '" + name + "' has no meaning for this shape");
  }
  if (kind.mass && keys.mass.given == keys.density.given)
    problems_.add(place, label + (keys.mass.given ? ": it has both mass and density, expected one"
                                  : kind.density  ? ": 'mass' or 'density' is missing"
                                                  : ": 'mass' is missing"));
  if (keys.mass.given && std::isinf(keys.mass.value))
    problems_.add(keys.mass.place, label + ": mass = 'fixed', expected a number > 0: parts have masses");
  return problems_.count() == before;
}

std::optional<std::filesystem::path> ShapeReader::inside(const std::string& label, const NameText& file) {
  std::error_code error;
  const std::filesystem::path root = std::filesystem::weakly_canonical(folder_, error),
                              path = std::filesystem::weakly_canonical(folder_ / file.value, error);
  const std::filesystem::path relative = path.lexically_relative(root);
  const bool no_path = file.value.find('\0') != std::string::npos;
  if (no_path || (!allow_outside_ && (error || relative.empty() || *relative.begin() == ".."))) {
    problems_.add(file.place, label + ": mesh = " + quoted(file.value) +
                                  ", expected a file inside the scene's folder (or --allow-outside)");
    return std::nullopt;
  }
  return path;
}

std::optional<BodyShape> ShapeReader::read_mesh_shape(const std::string& label, const ShapeKeys& keys) {
  const auto path = inside(label, keys.mesh);
  if (!path) return std::nullopt;
  try {
    TriangleMesh mesh = read_mesh(*path);
    if (keys.scale.given)
      for (Vector3d& vertex : mesh.vertices) vertex *= keys.scale.value;
    const double density = keys.density.given ? keys.density.value : 1.0;
    MassProperties properties = solid_mesh(label, density, mesh);
    if (keys.mass.given) {
      properties.inertia *= keys.mass.value / properties.mass;
      properties.mass = keys.mass.value;
    }
    return BodyShape{properties, {-1, std::move(mesh.vertices), std::move(mesh.triangles)}};
  } catch (const InputError& error) {
    problems_.add(keys.mesh.place, label + ": " + error.what());
    return std::nullopt;
  }
}

std::optional<BodyShape> ShapeReader::read_parts(const std::string& label,
                                                 const std::vector<PartEntry>& parts) {
  BodyShape whole;
  std::vector<MassProperties> properties;
  bool sound = true;
  for (const PartEntry& part : parts) {
    const std::string where = label + ": " + part.label;
    if (part.shape.given && part.shape.value == ShapeKeys::kParts) {
      problems_.add(part.shape.place, where + ": shape = 'parts', expected a shape without parts of its own");
      sound = false;
      continue;
    }
    const std::optional<BodyShape> shape = read(where, part.place, part, {});
    if (!shape) {
      sound = false;
      continue;
    }
    properties.push_back(moved(shape->properties, part.orientation.axes, part.position));
    const int first = static_cast<int>(whole.surface.vertices.size());
    for (const Vector3d& vertex : shape->surface.vertices)
      whole.surface.vertices.push_back(part.orientation.axes * vertex + part.position);
    for (const std::array<int, 3>& t : shape->surface.triangles)
      whole.surface.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  if (!sound) return std::nullopt;
  whole.properties = combined(label, properties);
  return whole;
}

std::optional<BodyShape> ShapeReader::read(const std::string& label, TextPlace place, const ShapeKeys& keys,
                                           const std::vector<PartEntry>& parts) {
  if (!keys.shape.given || !check_keys_of_kind(label, place, keys, !parts.empty())) return std::nullopt;
  try {
    if (keys.shape.value == ShapeKeys::kMesh) return read_mesh_shape(label, keys);
    if (keys.shape.value == ShapeKeys::kParts) return read_parts(label, parts);
    return simple_shape(label, keys);
  } catch (const InputError& error) {
    problems_.add(place, error.what());
    return std::nullopt;
  }
}

}  // namespace feder
