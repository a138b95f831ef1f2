// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/lengths.h"
#include "skin/contact/contact_memory.h"

namespace thew::skin {

/// Node `node` of collider `mover` against a point of collider `other`, fixed barycentrically to a
/// triangle of it: normal . (x_node - sum b_k y_k) >= gap + offset.
struct Contact {
  int node = -1;
  int other = -1;
  int triangle = -1;
  int point = -1;  ///< of the other's held points, of a face's contact
  double barycentric[3] = {0, 0, 0};
  Vec3 normal = Vec3::UnitZ();  ///< out of the other surface
  double distance = 0.0;        ///< signed, when found
  double offset = 0.0;          ///< m: both thicknesses, and a share in a face's contact
  bool of_face = false;         ///< of a face of which the node is a corner, with a held point
};

struct ContactSettings {
  double margin = 0.0015;    ///< m, how far ahead contacts are looked for
  double max_depth = 0.006;  ///< m, so deep ones too; twice so deep in what gives way itself
  double gap = 6e-4;         ///< m, kept between surfaces
  double spacing = 0.005;    ///< m, of held points against faces
  Lengths lengths = {};
};
ContactSettings times(const ContactSettings& settings, double size);

/// Halfway between the other surface's normal and straight back into the mover, whose own normal
/// does not flip.
Vec3 steady_normal(const Vec3& own, const Vec3& normal);
/// The corners' normals between them, which do not turn within the gap as a node slides over an
/// edge.
Vec3 smooth_normal(const Surface& surface, const Points& x, int triangle,
                   const double* barycentric);
/// From the nearest point to p, outwards; its pseudonormal where p lies on the surface, nearer than
/// `touching` (m).
Vec3 contact_normal(const ClosestPoint& near, const Vec3& p, double touching);

/// By node, then by collider, then by held point.
void order_contacts(std::vector<Contact>& contacts);

/// Contacts [c, end) hold as one: of a node's face or faces with held points of one other surface,
/// of which the nearest counts.
size_t end_of_one(const std::vector<Contact>& contacts, size_t c);
/// That of them which presses, or the first.
size_t pressing_one(const std::vector<double>& push, size_t c, size_t end);

/// Which colliders may touch; memory that goes from call to call, so that none allocates.
struct NearPairs {
  /// By collider: those others whose boxes are near enough for a contact, ascending.
  std::vector<std::vector<int>> near;
  std::vector<int> order;  ///< of the sweep, along the axis on which the boxes lie farthest apart
};
void find_near_pairs(const std::vector<Collider>& colliders, const ContactSettings& settings,
                     NearPairs& pairs);

/// All contacts of the free nodes of `mover` with the colliders `near`, by node, then by collider.
/// `pressing`: contacts of the step before that bore a force, in the same order; they are let go of
/// beyond `max_depth`, not `margin`, so that no force vanishes in a step. `memory` goes from call
/// to call (sized on first use).
void find_contacts(const std::vector<Collider>& colliders, int mover, const std::vector<int>& near,
                   const ContactSettings& settings, const std::vector<Contact>& pressing,
                   ContactMemory& memory, std::vector<Contact>& contacts);

}  // namespace thew::skin
