#pragma once

#include <utility>
#include <vector>

#include "engine/status.h"
#include "engine/system.h"

namespace feder {

/// Which part of the geometric stiffness Kg = -sum_k lambda_k Hess phi_k enters Mt.
enum class GeometricStiffness { kOff, kClamped, kFull };

/// Size of a KKT residual, the larger of both block rows. NaN if anything is not finite.
struct ResidualSize {
  /// Backward error: against |p| + |Mt v| + |J||y| and |r| + |J||v| + |gamma y|. Rounding reaches about
  /// 1e-16.
  double backward_error = 0.0;
  /// Against |p| + |Mt v| + |J^T y| and |r| + |J v| + |gamma y|: the terms as they act, after the multipliers
  /// have cancelled. What the velocity sees; stricter where stiff rows carry self-stress.
  double balance_error = 0.0;
};

/// One linearisation of the system: the step matrix of design.md section 1,
///
///     [ Mt   -J^T  ] [ v ]   [ p ]
///     [ -J  -gamma ] [ y ] = [ r ],     Mt = M + rho B + sigma Kg,   y = dt lambda,
///
/// in parts, so that each route assembles what it needs. Vectors over coordinates have 3 entries per node
/// (masked ones are not unknowns: v is 0 there); vectors over rows have System::rows entries. Rows that
/// cannot push (d = 0; with sigma = 0 also b = 0) have J = 0, phi = 0, gamma = 1, so y = -r = 0. Sized once
/// by `prepare`; refilled without allocation.
struct Kkt {
  const System* system = nullptr;
  bool geometric = false;  ///< Mt has off-diagonal blocks

  VectorXd mass;           ///< M + rho B, the diagonal [kg]
  VectorXd inverse_mass;   ///< its inverse, 0 where masked [1/kg]
  VectorXd gamma;          ///< 1 / (sigma d + rho b) >= 0, 0 for hard rows [1/kg for distance rows]
  VectorXd inverse_gamma;  ///< 0 for hard rows (they have none) and inactive rows
  VectorXd p, r;

  VectorXd u;                   ///< distance rows: J is -u at a and +u at b, 3 per row
  VectorXd length;              ///< distance rows: |x_b - x_a| [m]
  VectorXd phi;                 ///< all rows
  VectorXd geometric_distance;  ///< sigma Kg of a distance row is this times (E - u u^T) [kg]
  VectorXd jacobian;            ///< stencil rows, see Stencil::jacobian
  VectorXd geometric_stencil;   ///< sigma Kg of the stencils, see Stencil::matrix

  /// Allocates for a system; must be called before anything else.
  void prepare(const System& s);
  /// gamma and Mt's diagonal for a one-stage method with sigma [s^2] and rho [s]; cheap if nothing changed.
  void set_step(double sigma, double rho);
  /// Changes whenever set_step changed gamma or Mt's diagonal: a key for what routes keep between steps.
  long step_serial() const { return step_serial_; }
  /// phi, J (and nothing else) at q; `length` only if asked, as Kg needs it. Fails with the name of a
  /// degenerate row or of a non-finite value.
  Status evaluate(const VectorXd& q, bool with_length = true);
  /// J of the spins by their velocity over a step instead of by their pose: columns times J_r(dt w), dt w the
  /// angle turned since the step began. Call after evaluate; nothing to do without bodies.
  void take_spins_over_a_step(double dt, const VectorXd& v);
  /// Takes hard rows that depend on others out of the matrix (J = 0, phi = 0, gamma = 1), now and in every
  /// later evaluate; those dropped before and not now come back.
  void drop_rows(const std::vector<int>& rows);
  const std::vector<int>& dropped() const { return dropped_; }
  double dropped_gap() const;  ///< largest |phi| of the dropped rows
  double kept_gap() const;     ///< of the other hard rows
  /// Largest |phi + J w| of a dropped row, and which.
  std::pair<int, double> dropped_gap_after(const VectorXd& w) const;
  double scale() const { return scale_; }  ///< largest coordinate at the last evaluate, with hard rows [m]
  /// Fills sigma Kg at q for multipliers lambda (per row; the user force adds its stiffness). Call after
  /// evaluate. `kept`: fraction of the negative part of each row's block that stays in kClamped, 0 to 1; 1 is
  /// kFull. Law springs add sigma K + rho C; rho = 0 where their damping stays explicit.
  void set_geometric_stiffness(GeometricStiffness kind, double sigma, const State& state,
                               const VectorXd& lambda, double kept = 0.0, double rho = 0.0);

  /// Mt's own block of a stencil without rows (System::contact_stencil) [kg]; from now on Mt is not diagonal.
  Eigen::Map<Matrix3d> node_block(int stencil);

  /// out = J v.
  void multiply_jacobian(const VectorXd& v, VectorXd& out) const;
  /// out = J Mt^-1 x where Mt is diagonal (0 where masked).
  void multiply_jacobian_inverse_mass(const VectorXd& x, VectorXd& out) const;
  /// out += J^T y.
  void add_jacobian_transpose(const VectorXd& y, VectorXd& out) const;
  /// out += sigma Kg v.
  void add_geometric(const VectorXd& v, VectorXd& out) const;
  /// residual_v = p - Mt v + J^T y (0 where masked), residual_y = r + J v + gamma y, and how large they are.
  ResidualSize residual(const VectorXd& v, const VectorXd& y, VectorXd* residual_v,
                        VectorXd* residual_y) const;
  /// The size alone: nothing is stored.
  ResidualSize residual_size(const VectorXd& v, const VectorXd& y) const;

 private:
  double* jacobian_of(int row, int& size);
  void swap_dropped();
  template <class Velocity>
  void multiply_stencils(Velocity&& velocity, VectorXd& out) const;

  double sigma_ = -1.0, rho_ = -1.0;
  long step_serial_ = 0;
  std::vector<int> dropped_;
  VectorXd dropped_phi_, dropped_jacobian_;  // what drop_rows took out
  double scale_ = 0.0;
  std::vector<int> inert_distance_;  // rows that cannot push in this step: J = 0
  std::vector<int> inert_stencil_;   // the same, by stencil
  mutable VectorXd scratch_v_, scratch_y_, scratch_geometric_;
};

/// phi of every row at q. Degenerate rows give 0.
void evaluate_phi(const System& system, const VectorXd& q, VectorXd& phi);

/// f = all forces at the state: constant, user, drag, and the finite rows J^T lambda. No matrix is touched.
/// Masked coordinates get a value too; they carry no inverse mass. Fails by name on coincident points and
/// non-finite values.
Status evaluate_forces(const System& system, const State& state, VectorXd& f);
/// The same without drag and row damping: for methods that treat those implicitly.
Status evaluate_undamped_forces(const System& system, const State& state, VectorXd& f);
/// Constant forces, torques, law springs, user force and fluid; 0 where masked, not finite where a law spring
/// has no length.
void evaluate_external_forces(const System& system, const State& state, VectorXd& f);

}  // namespace feder
