// SPDX-License-Identifier: Apache-2.0
//
// Parts triangles that still cross after the solve of a step. Contact holds nodes out of faces and
// points of faces out of bodies; between them edges may cut through, and where a solve is cut short
// a node stays in. What is left is few and shallow, so it is parted by itself.
#pragma once

#include <array>
#include <vector>

#include "skin/contact/collider.h"

namespace thew::skin {

/// Nodes of a body on their way out of others.
struct Parting {
  Points normals;              ///< [node] unit outward normals of the surface
  Points push;                 ///< [node] sum of steps (m), each times its length
  std::vector<double> weight;  ///< [node] sum of these lengths, m
  std::vector<char> out;       ///< [triangle] whether a corner is free; others are attached
};
/// Sets `normals` and `out` for a body at its present positions, `push` to 0.
void begin_parting(const Collider& body, Parting& parting);

/// The pairs of triangles, of a and of b, that cross and that a free node can part. `pairs` is
/// scratch and result. a may be b.
void find_partable(const Collider& a, const Parting& of_a, const Collider& b, const Parting* of_b,
                   std::vector<std::array<int, 2>>& pairs);

/// Adds, for each pair, to the push of a's corners a step out of b, and to b's one out of a:
/// halfway between the one's outward and the other's inward normal, as long as the pair is deep or
/// as what they cut of one another is long, whichever is less, so that what no longer crosses had
/// moved little; at most `longest` and at least a tenth of it (m). `of_b` is null for a bone.
void push_apart(const Collider& a, Parting& of_a, const Collider& b, Parting* of_b,
                const std::vector<std::array<int, 2>>& pairs, double longest);

/// Moves every pushed node by the mean of its steps, the longer counting more, and sets `push` to
/// 0. True if any has moved.
bool part(Parting& parting, Points& x);

}  // namespace thew::skin
