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

/// How a body's nodes have moved from search to search for contacts.
struct Followed {
  Points x, before;  ///< at the last search and the one before; empty or of another size: not known
  double travelled = 0.0, travelled_before = 0.0;  ///< m, the most that a node moved, all in all
  MovedParts parts;
  void go_on(const Points& now);
};

/// A surface as contact sees it. Rigid bones have no free node.
struct Collider {
  const Surface* surface = nullptr;
  const Bvh* bvh = nullptr;
  const Points* x = nullptr;
  const std::vector<char>* free_nodes = nullptr;  ///< null: none is free
  const Followed* followed = nullptr;             ///< null: it may have been anywhere
  NodeBox box = {};                               ///< of the nodes; what is not near needs no tree
  const std::vector<SurfacePoint>* rigid_points = nullptr;  ///< see face_contact.h
  double thickness = 0.0;  ///< m, of what covers it: kept free beside the gap

  bool wanted = false;  ///< searched for in this step

  // In a step's solve.
  bool soft = false;  ///< gives way itself, and goes half of the way
  const Points* previous_iterate =
      nullptr;  ///< where the others see it: in the iteration before, if it is soft
  const Points* start = nullptr;  ///< soft: when the step began
  /// Rigid: from where its points are to where they were when the step began, and from there.
  Transform back = Transform::Identity(), forth = Transform::Identity();
};

}  // namespace thew::skin
