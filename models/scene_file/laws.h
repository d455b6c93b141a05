#pragma once

#include <array>
#include <vector>

#include "engine/drive.h"
#include "engine/forces.h"
#include "engine/law_spring.h"
#include "models/scene_file/curve.h"
#include "models/scene_file/expression.h"

namespace feder {

// What a scene prescribes by an expression or a table, for the engine. Derivatives are exact: of expressions
// by their jets, of curves in closed form. Misuse: an expression in other variables than stated. Where a
// value is not finite, so is what the engine gets; it ends the run by name.

/// s(t), an expression in ("t") [s], or a curve over t.
Target target_from(const Expression& expression);
Target target_from(const Curve& curve);

/// x(t) from its three components.
Motion motion_from(const std::array<Target, 3>& components);
Motion motion_from(const std::array<Expression, 3>& expressions);

/// What LawSpring takes.
struct SpringLaw {
  std::function<Tension(double length, double rate)> law;  ///< [m], [m/s]
  std::function<double(double length)> energy;  ///< [J], empty where the tension depends on the rate
};

/// Tension [N], > 0 pulls, as an expression in ("length", "rate") or a curve over the length. The energy is
/// its integral from `rest` [m]: of a curve exact, of an expression by adaptive Gauss-Lobatto quadrature to
/// 1e-13 of the integral of |tension|, NaN where that cannot be had (a tension that is not finite or wilder
/// than the quadrature's budget).
SpringLaw law_from(const Expression& expression, double rest);
SpringLaw law_from(const Curve& curve, double rest);

/// A force on each of some nodes [N]: three expressions in kForceVariables, of its own place and velocity.
struct ForceField {
  std::array<Expression, 3> force;
  std::vector<int> nodes;
};
/// Component c of the force on a node [N].
double force_component(const ForceField& field, std::size_t c, double t, const VectorXd& q, const VectorXd& v,
                       int node);
inline const std::vector<std::string> kForceVariables = {"t", "x", "y", "z", "vx", "vy", "vz"};

/// The sum of the fields, with the symmetric part of -dF/dx per node as its stiffness where some field
/// depends on the place; no potential. InputError: a node < 0 or twice in one field.
UserForce force_from(const std::vector<ForceField>& fields);

}  // namespace feder
