// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/lanes.h"
#include "muscles/springs.h"

namespace thew::muscles {

/// The springs of a closed surface by node, in the order of the node's ring: first the edges, then
/// the vertices opposite the ring's edges. Each spring is computed at both of its ends, which needs
/// no scatter, and the differences along a ring give the gradient of the volume with no further
/// load: dV/dx = 1/6 sum d_j x d_(j+1), twice the ring's area over 6. Nodes of one degree go four
/// at a time, one a lane.
struct RingSprings {
  using Indices = std::array<int, kLanes>;
  using BySlot = std::vector<Lanes, AlignedAllocator<Lanes>>;
  struct Slice {
    int degree = 0, first = 0, count = 0;  ///< 2 * degree slots from `first`; nodes that count
    int at = 0;                            ///< of its first node in `order`
    Indices node;                          ///< lanes beyond `count` repeat the last one
  };
  std::vector<Slice> slices;
  std::vector<int> order;              ///< the nodes, slice by slice
  std::vector<Indices> other, spring;  ///< by slot: the far node, the spring (-1: none)
  BySlot stiffness, rest_length;       ///< N/m and m
  size_t free_slices = 0;              ///< the first so many have all nodes that are not driven

  /// Slices [first, last).
  struct Range {
    size_t first, last;
  };
  Range all() const { return {0, slices.size()}; }
};
RingSprings make_ring_springs(const std::vector<Triangle>& triangles,
                              const std::vector<char>& driven, const Springs& springs);

/// Lengths (m) given by spring.
void lengths_by_slot(const RingSprings& rings, const std::vector<double>& by_spring,
                     RingSprings::BySlot& by_slot);

/// f = k (|d| - L + dashpot d/dt |d|) along each spring (N; dashpot in s), overwritten; with
/// `gradient` also dV/dx (m^2): of the nodes of the slices `of` alone, f and gradient being as long
/// as x. The same bytes for any vector width.
void ring_forces(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                 RingSprings::Range of, const Points& x, const Points& v, double dashpot, Points& f,
                 Points* gradient);

/// What of the springs' force is not in proportion to d = x_i - x_j, at the free nodes:
/// f += sum k L d / |d| (N). And f += scale sum k d.
void add_ring_projections(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                          const Points& x, Points& f);
void add_ring_edges(const RingSprings& rings, double scale, const Points& x, Points& f);

}  // namespace thew::muscles
