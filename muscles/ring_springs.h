// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/lanes.h"
#include "muscles/springs.h"

namespace thew::muscles {

/// The springs of a closed surface, sorted by node in the order of its ring: first the edges, then
/// the springs to the vertices opposite the edges of the ring. Each spring is computed at both of
/// its ends, so that a node writes only its own force. The edge vectors d_j of a ring also give the
/// gradient of the volume without another load: dV/dx = 1/6 sum d_j x d_(j+1), twice the area of
/// the ring over 6. Nodes of equal degree are computed four at a time, one in each lane.
struct RingSprings {
  using Indices = std::array<int, kLanes>;
  using BySlot = std::vector<Lanes, AlignedAllocator<Lanes>>;
  struct Slice {
    int degree = 0, first = 0, count = 0;  ///< slots first to first + 2 * degree; number of nodes
    int at = 0;                            ///< index of its first node in `order`
    Indices node;                          ///< lanes beyond `count` repeat the last one
  };
  std::vector<Slice> slices;
  std::vector<int> order;  ///< the nodes, slice by slice
  /// By slot: the node at the other end, the spring (-1: none).
  std::vector<Indices> other, spring;
  BySlot stiffness, rest_length;  ///< N/m and m
  size_t free_slices = 0;         ///< the free nodes are those of the first `free_slices` slices

  /// Slices [first, last).
  struct Range {
    size_t first, last;
  };
  Range all() const { return {0, slices.size()}; }
};
RingSprings make_ring_springs(const std::vector<Triangle>& triangles,
                              const std::vector<char>& driven, const Springs& springs);

/// Rearranges lengths (m) that are given by spring.
void lengths_by_slot(const RingSprings& rings, const std::vector<double>& by_spring,
                     RingSprings::BySlot& by_slot);

/// Sets f (N) at the nodes of the slices `of` to the sum of k (|d| - L + dashpot d|d|/dt) along the
/// springs, with dashpot in s. If `gradient` is given, sets it to dV/dx (m^2) at these nodes. Both
/// are as long as x. The bytes are the same for any vector width.
void ring_forces(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                 RingSprings::Range of, const Points& x, const Points& v, double dashpot, Points& f,
                 Points* gradient);

/// Parts of the spring force at the free nodes, with d = x_i - x_j. add_ring_projections: f += sum
/// k L d / |d| (N), the part that is not linear in d. add_ring_edges: f += scale sum k d (N).
void add_ring_projections(const RingSprings& rings, const RingSprings::BySlot& rest_length,
                          const Points& x, Points& f);
void add_ring_edges(const RingSprings& rings, double scale, const Points& x, Points& f);

}  // namespace thew::muscles
