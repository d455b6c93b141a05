#include "experiments/support/vtu.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>

#include "engine/system.h"
#include "experiments/support/base64.h"

namespace feder::experiments {

static_assert(std::endian::native == std::endian::little, "the file says LittleEndian");

namespace {

enum CellType : std::uint8_t { kVertex = 1, kLine = 3, kTriangle = 5 };  // of VTK

/// Per scalar row: rest length [m] of distance rows, 0 of others.
std::vector<double> rest_lengths(const System& s) {
  std::vector<double> rest(s.distance.rest.begin(), s.distance.rest.end());
  for_each_stencil_row_type(s.stencil_rows, [&](const auto& list) {
    for (const auto& row : list) {
      double length = 0.0;
      if constexpr (std::is_same_v<std::decay_t<decltype(row)>, AnchorDistanceRow>) length = row.rest;
      rest.insert(rest.end(), row.kRows, length);
    }
  });
  return rest;
}

/// The points of a file: SceneNodes, then every other place as it is first asked for.
class Points {
 public:
  explicit Points(const Scene& scene) {
    for (const SceneNode& node : scene.nodes) (void)number_of({.node = node.node});
  }

  int number_of(const Anchor& anchor) {
    Key key{anchor.body, 0.0, 0.0, 0.0};
    if (anchor.body < 0)
      std::get<1>(key) = anchor.node;
    else
      key = {anchor.body, anchor.point.x(), anchor.point.y(), anchor.point.z()};
    const auto [found, is_new] = numbers_.try_emplace(key, static_cast<int>(anchors.size()));
    if (is_new) anchors.push_back(anchor);
    return found->second;
  }

  std::vector<Anchor> anchors;

 private:
  using Key = std::tuple<int, double, double, double>;
  std::map<Key, int> numbers_;
};

}  // namespace

VtuFrames::VtuFrames(const Scene& scene) : scene_(&scene) {
  Points points(scene);
  const std::vector<double> rest = rest_lengths(scene.model.system);
  std::vector<int> connectivity, offsets, kinds;
  std::vector<std::uint8_t> types;
  const auto add_cell = [&](CellType type, int kind, std::initializer_list<int> places) {
    connectivity.insert(connectivity.end(), places);
    offsets.push_back(static_cast<int>(connectivity.size()));
    types.push_back(type);
    kinds.push_back(kind);
  };
  for (const SceneNode& node : scene.nodes) add_cell(kVertex, 0, {points.number_of({.node = node.node})});
  for (const SceneRow& row : scene.rows)
    for (std::size_t i = 1; i < row.nodes.size(); ++i) {
      add_cell(kLine, 1, {points.number_of(row.nodes[i - 1]), points.number_of(row.nodes[i])});
      row_cells_.push_back({row.first_row, row.rows, rest[row.first_row]});
    }
  points_ = std::move(points.anchors);
  for (const SceneSurface& surface : scene.surfaces) {
    const int first = static_cast<int>(points_.size());
    for (const Vector3d& vertex : surface.vertices)
      points_.push_back({.body = surface.body, .point = vertex});
    for (const std::array<int, 3>& t : surface.triangles)
      add_cell(kTriangle, 2, {first + t[0], first + t[1], first + t[2]});
  }

  text_ =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n<FieldData>\n";
  time_ = add_slot("Name=\"TimeValue\" NumberOfTuples=\"1\"", 1);
  text_ += "</FieldData>\n<Piece NumberOfPoints=\"" + std::to_string(points_.size()) + "\" NumberOfCells=\"" +
           std::to_string(types.size()) + "\">\n<PointData Vectors=\"velocity\">\n";
  velocities_ = add_slot("Name=\"velocity\" NumberOfComponents=\"3\"", 3 * points_.size());
  text_ += "</PointData>\n<CellData Scalars=\"row_force\">\n";
  forces_ = add_slot("Name=\"row_force\"", types.size());
  strains_ = add_slot("Name=\"strain\"", types.size());
  add_array("type=\"Int32\" Name=\"kind\"", kinds);
  text_ += "</CellData>\n<Points>\n";
  places_ = add_slot("Name=\"Points\" NumberOfComponents=\"3\"", 3 * points_.size());
  text_ += "</Points>\n<Cells>\n";
  add_array("type=\"Int32\" Name=\"connectivity\"", connectivity);
  add_array("type=\"Int32\" Name=\"offsets\"", offsets);
  add_array("type=\"UInt8\" Name=\"types\"", types);
  text_ += "</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n";
}

template <class Number>
void VtuFrames::add_array(const std::string& attributes, const std::vector<Number>& values) {
  const std::uint64_t size = values.size() * sizeof(Number);
  std::string bytes(sizeof size + size, '\0');
  std::copy_n(reinterpret_cast<const char*>(&size), sizeof size, bytes.begin());
  std::copy_n(reinterpret_cast<const char*>(values.data()), size, bytes.begin() + sizeof size);
  text_ += "<DataArray " + attributes + " format=\"binary\">\n";
  const std::size_t at = text_.size();
  text_.resize(at + base64_size(bytes.size()));
  encode_base64(bytes, text_.data() + at);
  text_ += "\n</DataArray>\n";
}

VtuFrames::Slot VtuFrames::add_slot(const std::string& attributes, std::size_t count) {
  text_ += "<DataArray type=\"Float64\" " + attributes + " format=\"binary\">\n";
  const Slot slot{text_.size(), count};
  text_.append(base64_size((1 + count) * sizeof(double)), 'A');
  text_ += "\n</DataArray>\n";
  return slot;
}

double* VtuFrames::fill(const Slot& slot) {
  values_.assign(1 + slot.count, 0.0);
  values_[0] = std::bit_cast<double>(std::uint64_t{slot.count * sizeof(double)});
  return values_.data() + 1;
}

void VtuFrames::put(const Slot& slot) {
  encode_base64({reinterpret_cast<const char*>(values_.data()), values_.size() * sizeof(double)},
                text_.data() + slot.at);
}

std::string_view VtuFrames::text(const Frame& frame) {
  const System& s = scene_->model.system;
  *fill(time_) = frame.state.t;
  put(time_);

  double* out = fill(places_);
  for (std::size_t i = 0; i < points_.size(); ++i)
    Eigen::Map<Vector3d>(out + 3 * i) = position(s, points_[i], frame.state.q);
  put(places_);
  out = fill(velocities_);
  for (std::size_t i = 0; i < points_.size(); ++i)
    Eigen::Map<Vector3d>(out + 3 * i) = velocity(s, points_[i], frame.state);
  put(velocities_);

  const VectorXd& lambda = frame.history.lambda;
  out = fill(forces_) + scene_->nodes.size();
  if (lambda.size() > 0)
    for (const RowCell& cell : row_cells_)
      *out++ = cell.rows == 1 ? lambda[cell.first_row] : lambda.segment(cell.first_row, cell.rows).norm();
  else  // not known is not 0
    std::fill_n(out, row_cells_.size(), std::numeric_limits<double>::quiet_NaN());
  put(forces_);
  out = fill(strains_) + scene_->nodes.size();
  for (const RowCell& cell : row_cells_)
    *out++ = cell.rest > 0.0 ? frame.phi[cell.first_row] / cell.rest : 0.0;
  put(strains_);
  return text_;
}

}  // namespace feder::experiments
