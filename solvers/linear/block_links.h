#pragma once

#include "solvers/linear/block_pivots.h"

namespace feder {

/// The links of a factorisation, numbered by their place in the list.
struct LinkView {
  int count;
  const int* column;       ///< block column of each
  const int* parent;       ///< block column it passes on to, -1: none
  const int* value;        ///< where its diagonal block starts in `values`, the block below follows
  const int* child_start;  ///< children but the link just before it, in `child`
  const int* child;
  const char* follows;  ///< its child is the link just before it
};

/// What one link leaves: A = L D L^T with ones on the diagonal of L.
struct Link {
  double l21, l31, l32, r1, r2, r3;  ///< r = 1 / D
  double below[9];                   ///< the block of L below, column-major
  double unused;                     ///< two cache lines
};

/// What a child takes from the diagonal block of its parent, lower triangle.
struct Passed {
  double a11 = 0.0, a21 = 0.0, a31 = 0.0, a22 = 0.0, a32 = 0.0, a33 = 0.0;
};
Passed passed(const Link& link);

/// Factors all links in order; false at a bad pivot.
bool factor_links(const LinkView&, const double* values, Link* out, PivotWatch& watch);
/// Substitutions on the links' part of x and, forward, what it takes from their parents.
void forward_links(const LinkView&, const Link*, double* x);
void backward_links(const LinkView&, const Link*, double* x);

}  // namespace feder
