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
};
/// Sets `normals` for a body at its present positions, `push` and `weight` to 0.
void begin_parting(const Collider& body, Parting& parting);

/// The pairs of triangles, of a and of b, that cross and of which one has a corner that is free to
/// move; b is a bone or the like unless `b_moves`. Triangles without such a corner are attached.
/// a may be b.
void find_partable(const Collider& a, const Collider& b, bool b_moves,
                   std::vector<std::array<int, 2>>& pairs);

/// Adds its share [1] of a step (m), as far as that is no longer than `longest` (m), to the push of
/// a node that is free.
void push(const Collider& body, int node, double share, const Vec3& step, double longest,
          Parting& parting);

/// Adds, for each pair, to the push of a's corners a step out of b, and to b's one out of a: the
/// shortest displacement of the corners that are free which takes the two triangles apart, a corner
/// out of a face or an edge over an edge, roughly along the way between the one's outward and the
/// other's inward normal; of a corner at most `longest` (m). So what hardly crosses hardly moves,
/// and what a step of another length leaves in another place comes out in the same. `of_b` is null
/// for a bone.
void push_apart(const Collider& a, Parting& of_a, const Collider& b, Parting* of_b,
                const std::vector<std::array<int, 2>>& pairs, double longest);

/// Moves every pushed node by the mean of its steps, the longer counting more.
void part(const Parting& parting, Points& x);

}  // namespace thew::skin
