// Plate (i, j) is body j columns + i, its centre between points i and i + 1 of the profile.
#include "models/plates.h"

#include <cmath>

namespace feder {
namespace {

constexpr double kEndTime = 0.25;  // [s]

class Builder {
 public:
  Builder(const std::string& place, const Plates& plates)
      : plates_(plates), columns_(static_cast<int>(plates.profile.size()) - 1) {
    const MassProperties box = solid_box(place, plates.mass, {plates.edge, plates.thickness, plates.edge});
    for (int j = 0; j < plates.rows; ++j)
      for (int i = 0; i < columns_; ++i) add_plate(box, i, j);
    builder_.set_gravity({0.0, -plates.gravity, 0.0});
  }

  SystemBuilder::Built build() {
    const Vector3d half_x(0.5 * plates_.edge, 0.0, 0.0), half_z(0.0, 0.0, 0.5 * plates_.edge);
    for (int j = 0; j < plates_.rows; ++j) {
      join(world(0, j), at(0, j, -half_x));
      for (int i = 1; i < columns_; ++i) join(at(i - 1, j, half_x), at(i, j, -half_x));
      if (plates_.last_tied) join(at(columns_ - 1, j, half_x), world(columns_, j));
    }
    for (int j = 1; j < plates_.rows; ++j)
      for (int i = 0; i < columns_; ++i) join(at(i, j - 1, half_z), at(i, j, -half_z));
    return builder_.build();
  }

 private:
  Vector3d place(int point, int j) const {
    return plates_.profile[static_cast<std::size_t>(point)] + Vector3d(0.0, 0.0, (j + 0.5) * plates_.edge);
  }
  Anchor world(int point, int j) { return builder_.add_world_point(place(point, j)); }
  Anchor at(int i, int j, const Vector3d& point) const { return {.body = j * columns_ + i, .point = point}; }
  void join(const Anchor& a, const Anchor& b) {
    builder_.add(BallRow{{a, b, plates_.stiffness, plates_.damping_time}});
  }
  void add_plate(const MassProperties& box, int i, int j) {
    const Vector3d from = place(i, j), to = place(i + 1, j), along = (to - from).normalized();
    Matrix3d axes;
    axes << along, Vector3d(-along.y(), along.x(), 0.0), Vector3d::UnitZ();
    builder_.add_body(box, {.position = 0.5 * (from + to), .orientation = axes});
  }

  const Plates& plates_;
  int columns_;
  SystemBuilder builder_;
};

}  // namespace

double plate_joints(double count_x, double count_z, bool last_tied) {
  return (count_x + last_tied) * count_z + count_x * (count_z - 1.0);
}

Model make_plates(const std::string& name, const Plates& plates) {
  auto [system, state] = Builder("model " + name, plates).build();
  Model model{name, std::move(system), std::move(state)};
  model.end_time = kEndTime;
  model.scene_length = plates.edge * static_cast<double>(plates.profile.size() - 1);
  if (plates.damping_time == 0.0) model.conserved = {conserved_energy()};
  return model;
}

}  // namespace feder
