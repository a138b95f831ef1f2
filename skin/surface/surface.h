// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/types.h"

namespace thew::skin {

/// What does not change of a closed surface while its nodes move.
struct Surface {
  std::vector<Triangle> triangles;
  std::vector<std::array<int, 3>> neighbours;  ///< triangle across each edge (k, k+1)
  std::vector<std::vector<int>> vertex_triangles;
  bool convex = false;  ///< and rigid, so that it stays so
};
Surface make_surface(std::vector<Triangle> triangles, int nodes);
/// Whether no node lies outside a face.
bool is_convex(const Surface& surface, const Points& x);

/// How often the surface goes round p: about 1 inside, 0 outside, the sum of both where it has
/// holes or is of several.
double winding_number(const Surface& surface, const Points& x, const Vec3& p);

/// Outward unit normal of a triangle (zero where it has no area), and of a node, weighted by angle.
Vec3 face_normal(const Surface& surface, const Points& x, int triangle);
Vec3 node_normal(const Surface& surface, const Points& x, int node);

/// Bounds of nodes, for a first look at what may touch.
struct NodeBox {
  Point low = Point{-1e300, -1e300, -1e300, 0.0}, high = -low;  ///< everywhere
};
/// Holds nothing yet.
inline NodeBox empty_box() {
  NodeBox box;
  std::swap(box.low, box.high);
  return box;
}
[[gnu::always_inline]] inline void grow(NodeBox& box, const Point& low, const Point& high) {
  box.low = low < box.low ? low : box.low;
  box.high = high > box.high ? high : box.high;
}
NodeBox box_of(const Points& x);
int longest_axis(const Point& extent);
/// Whether they come within `reach` (m) of each other.
bool are_near(const NodeBox& a, const NodeBox& b, double reach);

/// Bounding volume tree over the triangles of a surface: built once at rest, then refitted.
struct Bvh {
  struct Node {
    float lo[3], hi[3];  ///< rounded outwards
    int first, count;  ///< count > 0: a leaf over order[first, first + count); else children first,
                       ///< first + 1
  };
  std::vector<Node> nodes;
  std::vector<int> order;
};
Bvh build_bvh(const Surface& surface, const Points& x);
void refit_bvh(const Surface& surface, const Points& x, Bvh& bvh);
/// m, of a point outside of the box of all of it, 0 inside. The tree is not empty.
double box_distance(const Bvh& bvh, const Point& p);

/// The nearest point of a surface. `distance` is signed, negative inside, by the angle-weighted
/// pseudonormal of the feature (Baerentzen and Aanaes 2005).
struct ClosestPoint {
  int triangle = -1;  ///< -1: nothing within the bound
  double barycentric[3] = {0, 0, 0};
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< outward unit pseudonormal at the point
  double distance = 0.0;        ///< m
};
/// Searches only within `bound` (m) of p. `hint`: a triangle to start from, or -1.
ClosestPoint closest_point(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                           double bound, int hint = -1);

/// Triangles whose boxes come within `reach` (m) of p, in no particular order but always the same.
void triangles_near(const Bvh& bvh, const Vec3& p, double reach, std::vector<int>& triangles);
/// The nearest point of one triangle; the normal is the face's.
ClosestPoint closest_on_triangle(const Surface& surface, const Points& x, int triangle,
                                 const Vec3& p);

/// Pairs (i, j), i < j for one surface with itself, of properly crossing triangles; triangles that
/// share a vertex are left out.
std::vector<std::array<int, 2>> crossing_triangles(const Surface& a, const Bvh& bvh_a,
                                                   const Points& xa, const Surface& b,
                                                   const Bvh& bvh_b, const Points& xb);
/// The same into memory that is there.
void find_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                    const Bvh& bvh_b, const Points& xb, std::vector<std::array<int, 2>>& pairs);

}  // namespace thew::skin
