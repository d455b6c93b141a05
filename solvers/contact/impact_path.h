#pragma once

#include "solvers/contact/impact_law.h"

namespace feder {

/// The impulse path of Coulomb friction, followed to the end that `rule` (kPoisson or kStronge) sets. Inputs
/// as in resolve_impact, u_n <= 0, friction > 0; everything is best near 1 in size.
ImpactResult follow_impact_path(const Matrix3d& W, const Vector3d& u, double friction, double restitution,
                                ImpactRule rule);

}  // namespace feder
