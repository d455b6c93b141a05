#pragma once

#include <Eigen/Core>

#include "engine/state.h"
#include "engine/status.h"

namespace feder {

/// How the impulse of one contact follows from its velocity of approach.
enum class ImpactRule {
  kNewton,  ///< u_n' = -e u_n without friction (notes D2, D3)
  kNaive,  ///< Newton's e with friction: sticks inside the cone, else against the first slip. May gain energy
  kPoisson,  ///< along the path of Coulomb friction, p_n = (1 + e) times that of the compression
  kStronge   ///< along the same path, work of the restitution = -e^2 times that of the compression
};

/// What the slip did during an impact.
enum class Slip {
  kNone,        ///< no impact, nothing changed
  kThroughout,  ///< from the first moment to the last
  kStopped,     ///< it came to rest and stuck
  kResumed      ///< it came to rest, friction could not hold it, it set off in another direction
};

/// Axes: normal (from body a to body b), first and second tangent.
struct ImpactResult {
  Vector3d impulse = Vector3d::Zero();   ///< on b; its opposite acts on a [N s]
  Vector3d velocity = Vector3d::Zero();  ///< of b relative to a afterwards, u + W p [m/s]
  double compression_work = 0.0;         ///< of the normal impulse while the bodies approach, <= 0 [J]
  double restitution_work = 0.0;         ///< of the normal impulse while they separate, >= 0 [J]
  double friction_work = 0.0;            ///< of the tangential impulse [J]
  double energy_change = 0.0;            ///< p.(u + u')/2, the sum of the three works up to rounding [J]
  Slip slip = Slip::kNone;
  bool jammed = false;  ///< for a while the sliding drove the bodies together (Painleve)
  int steps = 0;        ///< steps of the series a turning slip needed
  /// kOk; kRefused: the naive rule has no impulse >= 0, none is given; kSingular: W has no motion that parts
  /// the stuck bodies, kLimitReached: more steps than kLargestImpactSteps; both give the impulse so far.
  StatusCode status = StatusCode::kOk;
};

inline constexpr int kLargestImpactSteps = 10000;

/// The impact of one contact with W = J M^-1 J^T [1/kg], symmetric positive semidefinite, W_nn > 0
/// (directions that masked coordinates close have rows of zeros), and relative velocity u [m/s] of b against
/// a. Nothing happens unless u_n < 0. Friction coefficient in [0, infinity], infinity being the limit;
/// restitution in [0, 1]. kStronge never gains energy, kPoisson may in rare states. Misuse: anything outside
/// these bounds, and kNewton with friction.
ImpactResult resolve_impact(const Matrix3d& W, const Vector3d& u, double friction, double restitution,
                            ImpactRule rule = ImpactRule::kStronge);

/// Impact without collision: the contact rests (u_n, exactly 0) and its slip has a negative painleve_margin,
/// so that no finite force keeps it; the impulse path of kStronge from there. Nothing happens if the margin
/// is
/// >= 0, or without slip. Misuse: as above, u_n not 0.
ImpactResult resolve_tangential_impact(const Matrix3d& W, const Vector3d& u, double friction,
                                       double restitution);

/// d u_n / d p_n while sliding along `slip` (any length > 0): W_nn - friction W_nt.slip / norm(slip) [1/kg].
/// Negative: pushing the bodies apart draws them together, and the acceleration of a sliding contact has no
/// or two solutions (Painleve). Misuse: no slip, friction not finite.
double painleve_margin(const Matrix3d& W, double friction, const Eigen::Vector2d& slip);

/// The least friction at which some direction of slip has no positive margin, W_nn / norm(W_nt); infinity
/// without coupling.
double critical_friction(const Matrix3d& W);

}  // namespace feder
