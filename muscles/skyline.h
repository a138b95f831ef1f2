// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/types.h"

namespace thew::muscles {

/// Two rows side by side: two right-hand sides of three coordinates, solved in one pass.
using PointPair = double __attribute__((vector_size(64)));
using PointPairs = std::vector<PointPair, AlignedAllocator<PointPair>>;

/// A symmetric positive definite matrix, its rows kept from the first entry to the diagonal.
/// Surfaces of tubes have short rows when numbered well.
struct Skyline {
  std::vector<int> order;          ///< order[new] = old index
  std::vector<int> position;       ///< position[old] = new index, -1: not an unknown
  std::vector<int> first;          ///< first column of each row
  std::vector<std::size_t> start;  ///< of each row's entries; row i holds columns first[i]..i
  std::vector<double> values;

  int size() const { return static_cast<int>(order.size()); }
};

inline constexpr std::size_t kMostMatrixBytes = std::size_t{2} << 30;
/// What a matrix and its factor take.
inline std::size_t matrix_bytes(const Skyline& matrix) {
  return 2 * sizeof(double) * (matrix.start.empty() ? 0 : matrix.start.back());
}

/// A Cholesky factor in the same layout.
struct SkylineFactor {
  std::vector<double> values;
  std::vector<double> inverse_diagonal;
};

/// Orders the nodes that are not `driven` to keep the rows short (reverse Cuthill-McKee) and
/// makes room for an entry per pair. All values are zero. std::length_error where matrix and factor
/// would take more than kMostMatrixBytes.
Skyline make_skyline(int nodes, const std::vector<std::array<int, 2>>& pairs,
                     const std::vector<char>& driven);

/// values(a, b) += k by old indices, where both are unknowns.
void add_entry(Skyline& matrix, int a, int b, double k);

/// Cholesky factor of values + diag(extra), extra by new index. False where not positive definite.
bool factorise(const Skyline& matrix, const std::vector<double>& extra, SkylineFactor& factor);

/// Solves in place, b by new index.
void solve(const Skyline& matrix, const SkylineFactor& factor, PointPairs& b);

}  // namespace thew::muscles
