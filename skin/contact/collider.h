// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "skin/contact/moved_parts.h"

namespace thew::skin {

/// A point of a surface, fixed to one of its triangles.
struct SurfacePoint {
  int triangle = -1;
  double barycentric[3] = {0, 0, 0};
};

/// How the nodes of a body have moved from search to search for contacts.
struct MotionHistory {
  /// m, at the last search and the one before; empty or of another size: not known.
  Points x, before;
  /// m, sum over searches of the largest motion of a node.
  double travelled = 0.0, travelled_before = 0.0;
  MovedParts parts;
  /// Takes over the positions of a new search.
  void advance(const Points& now);
};

/// A surface that takes part in contact. Rigid bones have no free nodes.
struct Collider {
  const Surface* surface = nullptr;
  const Bvh* bvh = nullptr;
  const Points* x = nullptr;
  const std::vector<char>* free_nodes = nullptr;  ///< null: no node is free
  const MotionHistory* history = nullptr;         ///< null: its motion is not known
  NodeBox box = {};  ///< box of the nodes; a collider that is near no other needs no tree
  /// Points that are kept out of faces, see face_contact.h.
  const std::vector<SurfacePoint>* rigid_points = nullptr;
  double thickness = 0.0;  ///< m, of tissue on the surface; added to the gap that contact keeps
  const std::vector<double>* thicknesses = nullptr;  ///< m, the same by node; null: alike

  bool searched = false;  ///< whether it takes part in the searches of this step

  // For the solve of a step.
  /// Gives way itself; a contact moves each of two soft surfaces half of the distance.
  bool soft = false;
  /// Positions that the others use: of the iteration before, if it is soft.
  const Points* previous_iterate = nullptr;
  /// Positions at the begin of the step, for one that is soft or bends; null for a rigid one.
  const Points* start = nullptr;
  double bent = 0.0;  ///< m, longest displacement of a node of one that bends, besides its motion
  /// For one that is not soft: the motion from its present position to that at the begin of the
  /// step, and its inverse.
  Transform to_start = Transform::Identity(), from_start = Transform::Identity();
};

inline bool is_free(const Collider& body, int node) {
  return body.free_nodes != nullptr && (*body.free_nodes)[node] != 0;
}

/// The thickness (m) at a node, or at a point of a triangle.
inline double thickness_at(const Collider& of, int node) {
  return of.thicknesses ? (*of.thicknesses)[node] : of.thickness;
}
inline double thickness_at(const Collider& of, int triangle, const double* barycentric) {
  if (!of.thicknesses) return of.thickness;
  const Triangle& t = of.surface->triangles[triangle];
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += barycentric[k] * (*of.thicknesses)[t[k]];
  return sum;
}

}  // namespace thew::skin
