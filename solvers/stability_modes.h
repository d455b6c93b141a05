#pragma once

#include <functional>
#include <optional>

#include "engine/state.h"

namespace feder {

/// x.(Kg - Km)x, or x.Kx, [1/s^2] and x.Cx [1/s] of a mass-normalised vector.
struct RayleighForms {
  double excess, damping;
};

/// Shared by the dense and the matrix-free limit of the notes' step: mu = 1/dt [1/s], 0 if stable at every
/// step, NaN if an eigenvector is missing. `top_vector(mu)` is the mass-normalised top eigenvector of Kg - Km
/// - 2 mu C; an excess up to `zero` [1/s^2] counts as none.
double notes_step_rate(const std::function<std::optional<VectorXd>(double mu)>& top_vector,
                       const std::function<RayleighForms(const VectorXd&)>& forms, double zero,
                       double tolerance);

/// The same of symplectic Euler: `top_vector(mu)` is the top eigenvector of K + 2 mu C, `forms` gives x.Kx
/// and x.Cx, `first` is the most damped mode (with mu = 0 nothing would find it where there is no stiffness).
double symplectic_euler_rate(const std::function<std::optional<VectorXd>(double mu)>& top_vector,
                             const std::function<RayleighForms(const VectorXd&)>& forms,
                             const VectorXd& first, double tolerance);

}  // namespace feder
