// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/lengths.h"
#include "skin/contact/contact_memory.h"

namespace thew::skin {

/// A contact of node `node` of a collider with a point of collider `other`, which is fixed to a
/// triangle by barycentric coordinates b: normal . (x_node - sum b_k y_k) >= gap + offset.
struct Contact {
  int node = -1;
  int other = -1;
  int triangle = -1;
  int point = -1;  ///< for a face contact: index in the rigid points of the other; else -1
  double barycentric[3] = {0, 0, 0};
  Vec3 normal = Vec3::UnitZ();  ///< unit, out of the other surface
  double distance = 0.0;        ///< m, signed, when it was found
  double offset = 0.0;          ///< m: both thicknesses; for a face contact see face_contact.cpp
  bool of_face = false;  ///< whether it is a face contact: the node is a corner of a face that
                         ///< meets a rigid point
};

/// Lengths of contact. The defaults were chosen by trial on the arm (skin/notes.md, "Contact").
struct ContactSettings {
  double margin = 0.0015;  ///< m, distance up to which contacts are found
  /// m, depth up to which contacts are found; twice that between two soft surfaces.
  double max_depth = 0.006;
  double gap = 6e-4;       ///< m, distance that contact keeps between surfaces
  double spacing = 0.005;  ///< m, distance between rigid points
  Lengths lengths = {};
};
/// All lengths multiplied by the size of a body [1].
ContactSettings times(const ContactSettings& settings, double size);

/// Contact normal halfway between the normal of the other surface and the reversed own normal of
/// the mover (both unit). Past the middle of something thin the first jumps to the other side, the
/// second does not.
Vec3 steady_normal(const Vec3& own, const Vec3& normal);
/// Unit normal at a point of a triangle, interpolated from the corners, so that it does not turn
/// abruptly as a node slides over an edge.
Vec3 smooth_normal(const Surface& surface, const Points& x, int triangle,
                   const double* barycentric);
/// Unit vector from the nearest point to p, reversed if p is inside; the pseudonormal of that point
/// if p is nearer to it than `least_direction` (m).
Vec3 contact_normal(const ClosestPoint& near, const Vec3& p, double least_direction);

/// Sorts by node, then by collider, then by rigid point.
void order_contacts(std::vector<Contact>& contacts);

/// End of the group of contacts that begins at c. All face contacts of one node with one other
/// surface form a group, of which only the nearest counts; any other contact is a group by itself.
size_t group_end(const std::vector<Contact>& contacts, size_t c);
/// The contact of a group [c, end) whose multiplier is positive, or c.
size_t active_in_group(const std::vector<double>& multipliers, size_t c, size_t end);

/// Pairs of colliders that may touch (broad phase). Kept, so that a search does not allocate.
struct CandidatePairs {
  /// For each collider the others whose boxes are near enough for a contact, ascending.
  std::vector<std::vector<int>> near;
  /// Order of the colliders in the sweep along the axis on which they are spread most.
  std::vector<int> order;
};
void find_candidate_pairs(const std::vector<Collider>& colliders, const ContactSettings& settings,
                          CandidatePairs& pairs);

/// Finds all contacts of the free nodes of `mover` with the colliders `near`, sorted by node, then
/// by collider. `pressing` are the contacts of the step before that bore a force, in the same
/// order; they are kept up to a distance of `max_depth` instead of `margin`, so that no force
/// vanishes within a step. `memory` is kept from call to call and sized on first use.
void find_contacts(const std::vector<Collider>& colliders, int mover, const std::vector<int>& near,
                   const ContactSettings& settings, const std::vector<Contact>& pressing,
                   ContactMemory& memory, std::vector<Contact>& contacts);

}  // namespace thew::skin
