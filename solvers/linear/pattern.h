#pragma once

#include <utility>
#include <vector>

#include "engine/system.h"

namespace feder {

/// One triangle of a symmetric sparse matrix in compressed columns, rows sorted, diagonal present.
struct SymmetricPattern {
  int size = 0;
  bool upper = false;             ///< which triangle is stored
  std::vector<int> column_start;  ///< size + 1
  std::vector<int> row;

  int entries() const { return static_cast<int>(row.size()); }
  /// Place of entry (i, j) = (j, i) in the value array; -1 if i or j is negative. Analysis only: it searches.
  int slot(int i, int j) const;
  /// The same matrix stored as the other triangle.
  SymmetricPattern flipped() const;
};

/// Lower triangle from index pairs (any order, doubles welcome); the diagonal is added.
SymmetricPattern make_pattern(int size, std::vector<std::pair<int, int>> entries);

/// A block of the Jacobian: the three numbers of one row at one node.
/// Distance rows: sign * Kkt::u[offset ..]; stencil rows: Kkt::jacobian[offset ..].
struct Incidence {
  int row, node;
  int offset;
  bool distance;
  double sign;

  const double* block(const double* u, const double* jacobian) const {
    return (distance ? u : jacobian) + offset;
  }
};

/// All blocks of active rows at nodes with a free coordinate, ordered by row.
std::vector<Incidence> incidences(const System& system);

/// Pairs of nodes (i < j, both with a free coordinate) coupled by a row or a stencil.
std::vector<std::pair<int, int>> coupled_nodes(const System& system);

}  // namespace feder
