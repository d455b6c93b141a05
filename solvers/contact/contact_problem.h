#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "engine/state.h"
#include "engine/status.h"

namespace feder {

/// Contacts that push at each other through one matrix: find impulses y, 3 per contact (normal, two
/// tangents), with
///
///     u = W y + b,   0 <= y_n  _|_  u_n >= 0,   |y_t| <= mu y_n,   y_t = -mu y_n u_t / |u_t| where u_t != 0
///
/// W = J A^-1 J^T is the Delassus matrix, symmetric positive semidefinite (singular where contacts are
/// redundant: y is then one of many, J^T y is not), b the velocities without impulses less what the normal
/// rows are to reach.
struct ContactProblem {
  Eigen::MatrixXd W;  ///< 3 k x 3 k [1/kg]
  VectorXd b;         ///< 3 k [m/s]
  VectorXd friction;  ///< mu per contact, >= 0
  int count() const { return static_cast<int>(friction.size()); }
};

/// Largest violation of the contact law by y, as a velocity [m/s]: what a projected step would still change.
/// Also the law's test in tests and certificates; 0 exactly at solutions.
double contact_violation(const ContactProblem& problem, const VectorXd& y);

struct ContactOptions {
  double tolerance = 1e-10;  ///< of the violation, relative to the largest |b|
  double floor = 0.0;        ///< violation that is always accepted [m/s]
  int most_newton = 30;      ///< iterations between two rounds of sweeps
  int most_sweeps = 20000;   ///< of Gauss-Seidel in all
  /// Of particles on what does not move, relative to the fastest velocity: far below the step's own error.
  double held_tolerance = 1e-6;
};

struct ContactReport {
  Status status;
  int newton_iterations = 0, sweeps = 0, factorizations = 0;
  double violation = 0.0;  ///< reached [m/s]
};

/// Projected Gauss-Seidel: contact after contact, normal then tangents, each projected into its cone. Linear
/// convergence; the rival, and the way out where Newton stalls. `y` is the start.
ContactReport solve_by_sweeps(const ContactProblem& problem, const ContactOptions& options, VectorXd& y);

/// The direct solve: semismooth Newton on the law (Alart and Curnier 1991) over the contacts that push, each
/// iteration one dense factorisation; sweeps take over while it does not contract. `y` is the start.
ContactReport solve_contacts(const ContactProblem& problem, const ContactOptions& options, VectorXd& y);

}  // namespace feder
