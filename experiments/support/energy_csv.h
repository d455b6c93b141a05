#pragma once

#include <string>

#include "experiments/support/frame.h"
#include "experiments/support/text_buffer.h"
#include "models/scene_file/scene.h"

namespace feder::experiments {

/// energy.csv: one line per time with the energies [J], linear momentum [kg m/s] and angular momentum about
/// the origin [kg m^2/s] of engine/energy.h.
class EnergyCsv {
 public:
  explicit EnergyCsv(const Scene& scene) : system_(&scene.model.system) {}

  static std::string name() { return "energy.csv"; }
  static std::string start(std::int64_t) { return "t,kinetic,rows,external,total,px,py,pz,lx,ly,lz\n"; }
  void add(const Frame& frame, TextBuffer& text) const;
  static std::string end() { return {}; }

 private:
  const System* system_;
};

}  // namespace feder::experiments
