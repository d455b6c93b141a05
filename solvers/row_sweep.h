#pragma once

#include <array>
#include <tuple>
#include <vector>

#include "engine/kkt.h"
#include "engine/step_rows.h"
#include "solvers/integrator.h"

namespace feder {

/// Projections onto every row of a system in turn, each seeing what the one before moved (notes H3 to H5,
/// with gamma XPBD): at the places q' = q_start moved by dt v
///     dy = -((phi(q') - remembered)/dt + gamma y) / (J W J^T + gamma),   y += dy,   v += W J^T dy.
/// Rows are visited by colours: rows of one colour share no node that moves, so that the result does not
/// depend on how many threads a colour is split among. Rows whose nodes do not move get their y, and push
/// nothing.
class RowSweep {
 public:
  void prepare(const System& system);
  /// What holds for one step: gamma and W from the matrix (set_step done), remembered = memory phi(q_start)
  /// per row [m].
  void begin(double dt, const Kkt& kkt, const VectorXd& remembered, const VectorXd& q_start);
  /// One sweep. q is where v leads (kept so), y per row. `impulse`, if not null, gains J^T dy. Fails with the
  /// name of a degenerate row. The largest |dv| of the sweep stands in `change` [sqrt(kg) m/s].
  Status sweep(RowWeights weights, VectorXd& q, VectorXd& v, VectorXd& y, VectorXd* impulse, double& change);

  int colours() const { return static_cast<int>(colours_.size()); }
  /// All rows that are visited, in their order.
  std::vector<int> order() const;

 private:
  static constexpr std::size_t kTypes = std::tuple_size_v<StencilRows>;
  struct Distance {
    int a, b, row;
    bool moves_a, moves_b;
    bool isotropic;  ///< J W J^T does not depend on the direction: no node free in some coordinates only
    // in this step: length at which the row is closed [m], J W J^T, gamma, 1 / (their sum)
    double target = 0.0, mobility = 0.0, gamma = 0.0, inverse = 0.0;
  };
  struct Colour {
    std::vector<Distance> distance;
    std::array<std::vector<int>, kTypes> stencil;  ///< places in the lists of the row types
  };
  template <bool kBooks>
  double project_distance(const Distance& row, double share, double* q, double* v, double* y,
                          double* impulse) const;
  template <class Row>
  double project_stencil(const Row& row, const Stencil& stencil, double share, VectorXd& q, VectorXd& v,
                         VectorXd& y, double* impulse) const;
  template <bool kBooks>
  double sweep_colour(const Colour& colour, double share, VectorXd& q, VectorXd& v, VectorXd& y,
                      double* impulse);
  Status name_failure(const VectorXd& q) const;

  const System* system_ = nullptr;
  std::vector<Colour> colours_;
  std::array<int, kTypes> first_stencil_{};  // of each type in System::stencils
  double dt_ = 0.0, rate_ = 0.0;             // rate = 1 / dt
  const Kkt* kkt_ = nullptr;
  const VectorXd *remembered_ = nullptr, *q_start_ = nullptr;
};

/// Rows of a matrix as it stands (J, gamma, r), in the given order.
void step_rows_of(const Kkt& kkt, const std::vector<int>& order, StepRows& out);

}  // namespace feder
