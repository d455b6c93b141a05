#pragma once

#include <string>
#include <vector>

#include "models/scene_file/jet.h"

namespace feder {

/// A curve through points: cubic between them, with continuous slope, monotone wherever the points are, a
/// straight line of the last slope beyond them. The second derivative jumps at the points (there it is that
/// of the piece to the right, at the last point that to the left).
class Curve {
 public:
  /// At least 2 points, abscissae strictly increasing, all finite; otherwise InputError naming `where`, the
  /// index (from 0) and the value.
  Curve(const std::string& where, std::vector<double> abscissae, std::vector<double> values);

  /// Value, slope and second derivative.
  Jet at(double x) const;
  /// Integral from the first point to x, exact.
  double integral(double x) const;

 private:
  std::size_t piece(double x) const;

  std::vector<double> x_, y_, slope_;
  std::vector<double> integral_;  // from the first point to each
};

}  // namespace feder
