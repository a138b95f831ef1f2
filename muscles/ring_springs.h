// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/springs.h"

namespace thew {

/// The springs of a closed surface by node, in the order of the node's ring: first the edges, then
/// the vertices opposite the ring's edges. Each spring is computed at both of its ends, which needs
/// no scatter, and the differences along a ring give the gradient of the volume with no further
/// load: dV/dx = 1/6 sum d_j x d_(j+1), twice the ring's area over 6. Nodes of one degree go four
/// at a time, one a lane.
struct RingSprings {
  static constexpr int kLanes = 4;  // AVX2 has the registers for four, not for eight
  using Lanes = double __attribute__((vector_size(8 * kLanes)));
  using Indices = std::array<int, kLanes>;
  struct Slice {
    int degree = 0, first = 0, count = 0;  ///< 2 * degree slots from `first`; nodes that count
    int at = 0;                            ///< of its first node in `order`
    Indices node;                          ///< lanes beyond `count` repeat the last one
  };
  std::vector<Slice> slices;
  std::vector<int> order;              ///< the nodes, slice by slice
  std::vector<Indices> other, spring;  ///< by slot: the far node, the spring (-1: none)
  std::vector<Lanes, AlignedAllocator<Lanes>> stiffness, rest_length;  ///< by slot, N/m and m
};
RingSprings make_ring_springs(const std::vector<Triangle>& triangles, int nodes,
                              const Springs& springs);

/// By spring, m.
void set_rest_lengths(const std::vector<double>& rest_length, RingSprings& rings);

/// f = k (|d| - L + dashpot d/dt |d|) along each spring (N; dashpot in s), overwritten; with
/// `gradient` also dV/dx (m^2): of the nodes of the slices [first, last) alone, f and gradient
/// being as long as x. The same bytes for any vector width.
void ring_forces(const RingSprings& rings, size_t first, size_t last, const Rows& x, const Rows& v,
                 double dashpot, Rows& f, Rows* gradient);

}  // namespace thew
