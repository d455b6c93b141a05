#pragma once

#include <functional>
#include <string>

#include "engine/anchor_rows.h"

namespace feder {

/// What a spring with a law of its own pulls with at one length and rate, and its derivatives.
struct Tension {
  double force = 0.0;      ///< [N], > 0 pulls the ends together
  double by_length = 0.0;  ///< [N/m]
  double by_rate = 0.0;    ///< [kg/s]
};

/// A spring between any two anchors whose tension is f(length, rate). It is a force, not a row: explicit
/// methods take it as it is, the Newton integrator implicitly with both derivatives, the one-step implicit
/// ones at (q_n, v_n), with by_length in their matrix where they have geometric stiffness.
struct LawSpring : AnchorPair {
  std::function<Tension(double length, double rate)> law;  ///< length [m] > 0, rate [m/s]
  std::function<double(double length)> energy = {};  ///< [J], where the tension is that of a length alone

  void check(const std::string& where) const;
  double length(const double* q) const;
  /// f -= D^T u T, D = d(x_b - x_a), u its direction. False at length 0 or a value that is not finite.
  bool add_force(const double* q, const double* v, double* f) const;
  /// out = sigma K + rho C with K = -df/dq (symmetric part), C = -df/dv, over its nodes.
  void stiffness(const double* q, const double* v, double sigma, double rho,
                 Eigen::Ref<Eigen::MatrixXd> out) const;
};

}  // namespace feder
