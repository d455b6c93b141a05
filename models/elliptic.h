#pragma once

namespace feder {

/// A modulus k and its complement k' = sqrt(1 - k^2), given separately because k' decides near k = 1. 0 <= k,
/// 0 < k'.
struct Modulus {
  double k, complement;
};

/// Complete elliptic integral of the first kind K(k).
double elliptic_k(const Modulus& modulus);

/// The Jacobi functions sn, cn, dn (u | k).
struct JacobiElliptic {
  double sn, cn, dn;
};
JacobiElliptic jacobi_elliptic(double u, const Modulus& modulus);

}  // namespace feder
