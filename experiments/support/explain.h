#pragma once

#include <string>
#include <vector>

#include "models/model.h"

namespace feder::experiments {

/// Scalar rows of one type.
struct RowCount {
  std::string type;  ///< "distance", "ball" ...
  int finite = 0;    ///< 0 < d < infinity, or a damper alone
  int hard = 0;      ///< d = infinity
  int inactive = 0;  ///< d = b = 0
  int damped = 0;    ///< of the finite and hard ones
  int total() const { return finite + hard + inactive; }
};

/// What is known of one integrator on the scene.
struct MethodOutlook {
  std::string name;
  int order = 0;
  std::string refusal;   ///< empty: admitted
  double limit = 0.0;    ///< largest stable dt [s]; infinity: none; 0: no dt is stable; NaN: not predictable
  std::string why;       ///< what decides the limit, or why there is no prediction
  double steps = 0.0;    ///< to the end time at the limit; 1 without limit, infinity at 0, NaN if unknown
  std::string dt_asked;  ///< "stable", "unstable", "unknown", "refused"; empty where no dt was asked
};

/// What is known of one linear route on the scene.
struct RouteOutlook {
  std::string name;
  std::string refusal, refusal_geometric;     ///< empty: admitted, without and with geometric stiffness
  double flops = 0.0, flops_geometric = 0.0;  ///< per factorisation; NaN: refused, or not analysed
};

/// Method and step that follow from the rules at the top of recommend.cpp.
struct Recommendation {
  std::string integrator;  ///< empty if nothing moves
  double dt = 0.0;         ///< [s]
  double steps = 0.0;      ///< to the end time
  std::string why;         ///< the rule that decided, with its figures
  std::string not_known;   ///< what could prove it wrong
};

/// What can be said about a scene before the first step. A count of -1 and a figure of NaN were not computed
/// or do not exist; the text beside them says why.
struct Explanation {
  std::string scene;
  double end_time = 0.0;      ///< [s]
  double scene_length = 0.0;  ///< [m]
  double dt_asked = 0.0;      ///< [s], 0: none

  int unknowns = 0;  ///< free coordinates
  int particles = 0, world_points = 0, bodies = 0;
  int driven = 0;                ///< points and row targets that follow a motion
  std::vector<RowCount> rows;    ///< types that occur
  RowCount all_rows;             ///< their sums
  double matrix_nonzeros = 0.0;  ///< of the KKT matrix, both triangles, without geometric stiffness

  std::string not_linearised;               ///< why the start has no linearisation; else empty
  int rank = -1, dependent = -1;            ///< of the hard rows at the start
  std::string rank_note;                    ///< why they were not computed; else empty
  std::vector<std::string> dependent_rows;  ///< names of the first kNamedRows
  double gap = 0.0;                         ///< largest |phi| of a hard row [m] or [1]
  double velocity_gap = 0.0;                ///< largest |J v + phi_t| of a hard row [m/s] or [1/s]
  int degrees_of_freedom = -1;              ///< unknowns - rank
  std::string index;                        ///< of the differential-algebraic system

  /// Of the finite rows; an upper bound where `spectrum_left_out` names a hard row or turning body.
  double largest_frequency = 0.0;     ///< [rad/s]; 0: no stiffness
  double smallest_frequency = 0.0;    ///< [rad/s]; NaN: none, hard rows, or too many unknowns
  double excited_frequency = 0.0;     ///< of acceleration or velocity at the start (Spectrum) [rad/s]
  double frequency_accuracy = 0.0;    ///< relative, of the largest; 0: rounding
  double largest_damping_rate = 0.0;  ///< [1/s], twice the decay rate of the mode
  std::string spectrum_left_out;
  double stiffness_ratio = 0.0;  ///< largest over smallest frequency
  double fastest_periods = 0.0;  ///< in the run: largest frequency x end time / 2 pi
  double turning_rate = 0.0;     ///< largest |angular velocity| of a body or rod at the start [rad/s]
  double swing_rate = 0.0;       ///< sqrt(gravity / shortest of rods and radii of gyration) [rad/s], or 0

  std::vector<MethodOutlook> methods;
  std::vector<RouteOutlook> routes;
  std::string route_note;             ///< why some were not analysed; else empty
  std::string auto_reason;            ///< what "auto" takes without geometric stiffness, and why
  std::string auto_reason_geometric;  ///< with it (implicit_euler_geometric, implicit_euler_newton)
  std::string judge;                  ///< what make_reference does with its defaults
  Recommendation recommended;
};

inline constexpr int kNamedRows = 5;
// Costs are bounded; what is skipped is said.
inline constexpr int kMostSharpUnknowns = 3000;           ///< frequencies to 1e-6, 1e-3 beyond
inline constexpr int kMostFrequencyUnknowns = 1'000'000;  ///< Lanczos: 5 s on S1(100000), 300 000 unknowns
inline constexpr int kMostRankRows = 40'000;              ///< SPQR: 4 s on the net S3b(80,80), 38 240 rows
/// Pairs of rows that meet at a node; S2(300) has 1.2e7 and takes 40 s over all routes.
inline constexpr double kMostRoutePairs = 3e6;

/// dt [s]: the step somebody thinks of, 0 for none. Throws InputError unless dt is 0 or finite and positive.
Explanation explain(const Model& model, double dt = 0.0);

/// For people: aligned, about 40 lines, units everywhere.
std::string to_text(const Explanation& explanation);
/// For programs: the same figures; NaN and infinity, which JSON lacks, as the texts "nan" and "inf".
std::string to_json(const Explanation& explanation);

}  // namespace feder::experiments
