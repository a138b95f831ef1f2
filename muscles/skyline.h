// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/types.h"

namespace thew::muscles {

/// Two points side by side: two right-hand sides of three coordinates each, solved in one pass.
using PointPair = double __attribute__((vector_size(64)));
using PointPairs = std::vector<PointPair, AlignedAllocator<PointPair>>;

/// A symmetric positive definite matrix, of which each row is stored from its first entry to the
/// diagonal. The rows are short for tube-like surfaces in a good order.
struct Skyline {
  std::vector<int> order;     ///< order[new] = old index
  std::vector<int> position;  ///< position[old] = new index, -1: not an unknown
  std::vector<int> first;     ///< first column of each row
  /// Where the entries of each row begin; row i has columns first[i] to i.
  std::vector<std::size_t> start;
  std::vector<double> values;

  int size() const { return static_cast<int>(order.size()); }
};

/// 2 GiB, so that a mesh that is too fine is refused before memory runs out.
inline constexpr std::size_t kMaxMatrixBytes = std::size_t{2} << 30;
/// Memory of a matrix and its factor, bytes.
inline std::size_t matrix_bytes(const Skyline& matrix) {
  return 2 * sizeof(double) * (matrix.start.empty() ? 0 : matrix.start.back());
}

/// A Cholesky factor in the same layout.
struct SkylineFactor {
  std::vector<double> values;
  std::vector<double> inverse_diagonal;
};

/// Orders the nodes that are not `driven` so that rows are short (reverse Cuthill-McKee) and makes
/// an entry of 0 for each pair. Throws std::length_error if matrix and factor would take more than
/// kMaxMatrixBytes.
Skyline make_skyline(int nodes, const std::vector<std::array<int, 2>>& pairs,
                     const std::vector<char>& driven);

/// Adds k to the entry of nodes a and b (old indices), if both are unknowns.
void add_entry(Skyline& matrix, int a, int b, double k);

/// Cholesky factor of the matrix plus diag(extra), `extra` by new index. False if that is not
/// positive definite.
bool factorise(const Skyline& matrix, const std::vector<double>& extra, SkylineFactor& factor);

/// Solves for both right-hand sides in place, b by new index.
void solve(const Skyline& matrix, const SkylineFactor& factor, PointPairs& b);

}  // namespace thew::muscles
