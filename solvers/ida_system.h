#pragma once

#include <cstdint>
#include <vector>

#include "engine/kkt.h"

namespace feder {

/// How the rows enter: finite ones in ODE form (lambda eliminated) or in compliance form (lambda unknown,
/// index 1); hard ones in the form of Gear, Gupta and Leimkuhler (index 2: phi = 0 and J v + phi_t = 0, the
/// latter with multipliers mu in q'), finite ones beside them eliminated.
enum class IdaForm { kAutomatic, kOde, kCompliance, kGgl };

/// The equations of motion as F(t, y, y') = 0 with analytic sparse Jacobian; no SUNDIALS type, so that tests
/// can look at it.
///
///   y = (q, v), (q, v, lambda) or (q, v, lambda, mu); q: free coordinates of places, 4 numbers per body
///   0 = q' - G (v + M^-1 J^T mu)              mu of hard rows, ggl only; G = 1/2 quaternion for spins
///   0 = M v' + w x I w + B v - f_ext - J^T lambda      lambda = -d phi - b J v if eliminated
///   0 = phi + (b J v + lambda) / d            compliance form only, finite rows
///   0 = phi,  0 = J v + phi_t                 ggl only, hard rows
class IdaSystem {
 public:
  /// `form` must be kGgl for a system with hard rows, kOde or kCompliance for one without.
  IdaSystem(const System& system, const State& state, IdaForm form);

  int coordinates() const { return static_cast<int>(coordinates_.size()); }  ///< n, of v
  int positions() const { return positions_; }                               ///< of q
  int multipliers() const { return multipliers_; }                           ///< of lambda
  int unknowns() const {
    return positions_ + coordinates() + multipliers_ * (form_ == IdaForm::kGgl ? 2 : 1);
  }

  /// y and y' that satisfy F = 0 at the state; y' of the multipliers, which does not occur in F, is 0.
  Status initial(const State& state, double* y, double* y_prime);
  /// q and v of the state; masked coordinates keep their place.
  void read(double t, const double* y, State& state) const;

  /// r = F(t, y, y'). Fails by name where a row is degenerate or a value is not finite.
  Status residual(double t, const double* y, const double* y_prime, double* r);
  /// values = dF/dy + cj dF/dy' in the order of the pattern. The velocity dependence of a user force is left
  /// out (Newton then converges more slowly to the same solution).
  Status jacobian(double t, const double* y, double cj, double* values);

  /// Compressed columns; fixed by the constructor.
  const std::vector<std::int64_t>& column_starts() const { return starts_; }
  const std::vector<std::int64_t>& row_indices() const { return indices_; }
  int nonzeros() const { return static_cast<int>(indices_.size()); }

 private:
  /// One row element (distance or stencil row, or the stiffness of a user force) over `columns` coordinates.
  struct Element {
    int rows = 0, first_row = 0, columns = 0;
    std::vector<int> unknown;           ///< place of each coordinate, -1 where masked
    const double* J = nullptr;          ///< rows x columns
    const double* rate_by_q = nullptr;  ///< d(J v)/dq, rows x columns, null without damping
    const double* K = nullptr;          ///< columns x columns, its part of Kg
    std::vector<int> coordinate;        ///< 3 node + axis
  };

  Status evaluate(double t, const double* y);
  Status initial_multipliers(const State& state, double* y, VectorXd& acceleration);
  bool hard(int row) const { return form_ == IdaForm::kGgl && multiplier_[row] >= 0; }
  template <class Sink>
  void add_by_position(int row, int coordinate, double value, Sink&& add) const;
  template <class Sink>
  void assemble_kinematics(double cj, Sink&& add) const;
  template <class Sink>
  void assemble_turning(Sink&& add) const;
  void evaluate_rate_derivatives();
  template <class Visit>
  void for_each_element(Visit&& visit) const;
  template <class Sink>
  void assemble(double cj, Sink&& add) const;
  template <class Sink>
  void assemble_element(const Element& e, Sink&& add) const;
  void find_pattern();

  const System& system_;
  IdaForm form_;
  std::vector<int> coordinates_;  ///< free coordinates, in order
  std::vector<int> unknown_;      ///< per coordinate: its place among them, -1 where masked
  std::vector<int> position_;  ///< per coordinate of a place: its unknown; of a spin: the body's first of 4
  std::vector<int> turning_;   ///< bodies with a free spin
  int positions_ = 0, multipliers_ = 0;
  std::vector<int> rows_;        ///< active rows, in order
  std::vector<int> multiplier_;  ///< per row: its unknown, -1 in ODE form or where inactive

  State state_;
  Kkt kkt_;
  VectorXd lambda_, mu_, rate_, force_, row_force_, slide_;  ///< slide_: M^-1 J^T mu
  VectorXd rate_by_q_;  ///< d(J v)/dq of the stencil rows, laid out as Stencil::jacobian

  std::vector<std::int64_t> starts_, indices_;
  std::vector<int> places_;  ///< per term of `assemble`, in its order: index into values, -1 where masked
};

}  // namespace feder
