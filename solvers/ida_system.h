#pragma once

#include <cstdint>
#include <vector>

#include "engine/kkt.h"

namespace feder {

/// How the finite rows enter: ODE form (lambda eliminated) or compliance form (lambda unknown, index 1).
enum class IdaForm { kAutomatic, kOde, kCompliance };

/// The equations of motion as F(t, y, y') = 0 with analytic sparse Jacobian; no SUNDIALS type, so that tests
/// can look at it.
///
///   y = (q, v) or (q, v, lambda) over free coordinates and active finite rows
///   0 = q' - v
///   0 = M v' + B v - f_ext - J^T lambda       lambda = -d (phi + tau J v) in ODE form
///   0 = phi + tau J v + lambda / d            compliance form only
class IdaSystem {
 public:
  /// `form` must be kOde or kCompliance and the system without hard rows.
  IdaSystem(const System& system, const State& state, IdaForm form);

  int coordinates() const { return static_cast<int>(coordinates_.size()); }  ///< n
  int multipliers() const { return form_ == IdaForm::kOde ? 0 : static_cast<int>(rows_.size()); }
  int unknowns() const { return 2 * coordinates() + multipliers(); }

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
  };

  Status evaluate(double t, const double* y);
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
  std::vector<int> rows_;         ///< active rows, in order
  std::vector<int> multiplier_;   ///< per row: its unknown, -1 in ODE form or where inactive

  State state_;
  Kkt kkt_;
  VectorXd lambda_, rate_, force_;
  VectorXd rate_by_q_;  ///< d(J v)/dq of the stencil rows, laid out as Stencil::jacobian

  std::vector<std::int64_t> starts_, indices_;
  std::vector<int> places_;  ///< per term of `assemble`, in its order: index into values, -1 where masked
};

}  // namespace feder
