#pragma once

#include <vector>

#include "solvers/linear/block_pivots.h"

namespace feder {

/// Links in the order of work, in runs: two at a time side by side where two are ready, or one by one.
struct LinkRun {
  int end;
  bool pairs;
};

/// The links of a factorisation, numbered in the order of work.
struct LinkView {
  int count;
  const LinkRun* run;
  const int* column;       ///< block column of each
  const int* parent;       ///< block column it passes on to, -1: none
  const int* value;        ///< where its diagonal block starts in `values`, the block below follows
  const char* follows;     ///< its child is the one just before it in its run (and its half of a pair)
  const int* child_start;  ///< all other children, in `child`
  const int* child;
};

/// What one link leaves: A = L D L^T with ones on the diagonal of L.
struct Link {
  double l21, l31, l32, r1, r2, r3;  ///< r = 1 / D
  double below[9];                   ///< the block of L below, column-major
  double unused;                     ///< two cache lines
};

/// What a link takes from the diagonal block of its parent: lower triangle by columns.
void passed(const Link& link, double (&taken)[6]);

/// An order of work that keeps two lanes busy. `parent` of each link is a link or -1.
struct LinkSchedule {
  std::vector<int> order;     ///< links
  std::vector<char> follows;  ///< by place in `order`, as in LinkView
  std::vector<LinkRun> runs;
};
LinkSchedule schedule_links(const std::vector<int>& parent);

/// Factors all links; false at a bad pivot.
bool factor_links(const LinkView&, const double* values, Link* out, PivotWatch& watch);
/// Substitutions on the links' part of x and, forward, what it takes from their parents.
void forward_links(const LinkView&, const Link*, double* x);
void backward_links(const LinkView&, const Link*, double* x);

}  // namespace feder
