// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/types.h"

namespace thew::skin {

/// Topology of a closed surface, which does not change while its nodes move.
struct Surface {
  std::vector<Triangle> triangles;
  std::vector<std::array<int, 3>> neighbours;  ///< triangle across each edge (k, k+1); -1: none
  std::vector<std::vector<int>> vertex_triangles;
  bool convex = false;  ///< convex, and rigid so that it stays convex
};
Surface make_surface(std::vector<Triangle> triangles, int nodes);
/// Whether no node lies outside the plane of a face by more than rounding.
bool is_convex(const Surface& surface, const Points& x);

/// Generalised winding number of the surface around p: about 1 inside, 0 outside, between them for
/// a surface with holes.
double winding_number(const Surface& surface, const Points& x, const Vec3& p);

/// Outward unit normal of a triangle (zero if it has no area), and of a node (mean of its
/// triangles, weighted by their angles at the node).
Vec3 face_normal(const Surface& surface, const Points& x, int triangle);
Vec3 node_normal(const Surface& surface, const Points& x, int node);

/// Axis-aligned box of nodes, for the broad phase. The default is everywhere.
struct NodeBox {
  Point low = Point{-1e300, -1e300, -1e300, 0.0}, high = -low;  ///< everywhere
};
/// A box that contains nothing.
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
/// Whether the boxes come within `reach` (m) of each other along each axis.
bool are_near(const NodeBox& a, const NodeBox& b, double reach);

/// Tree of boxes over the triangles of a surface: built once at rest by the surface area heuristic,
/// then refitted.
struct Bvh {
  struct Node {
    float lo[3], hi[3];  ///< rounded outwards
    int first, count;  ///< count > 0: a leaf over order[first, first + count); else children first,
                       ///< first + 1
  };
  /// The same tree with up to eight children to a node, whose boxes are tested at once.
  struct alignas(32) Wide {
    static constexpr int kChildren = 8;
    float low[3][kChildren], high[3][kChildren];  ///< no point lies in the box of a missing child
    int node[kChildren];                          ///< of `nodes`; -1: missing
    int child[kChildren];                         ///< of `wide`; -1: a block or missing
  };
  /// The triangles of a leaf, or of a node above two leaves: their boxes and nodes in eight lanes,
  /// four for a leaf.
  struct alignas(32) Block {
    static constexpr int kLanes = 8, kHalf = 4;
    float low[3][kLanes], high[3][kLanes];  ///< no point lies in the box of a missing triangle
    int node[3][kLanes];                    ///< of the surface; 0: missing
    int triangle[kLanes];                   ///< of the surface; 0: missing
  };
  std::vector<Node> nodes;
  std::vector<int> order;
  std::vector<Wide> wide;  ///< down to the blocks
  std::vector<Block> blocks;
  std::vector<int> block_of;  ///< by node, -1 for those above blocks
};
Bvh build_bvh(const Surface& surface, const Points& x);
void refit_bvh(const Surface& surface, const Points& x, Bvh& bvh);
/// Distance (m) of a point or a box from the box of the whole tree; 0 inside. The tree must not be
/// empty.
double box_distance(const Bvh& bvh, const Point& p);
double box_distance(const Bvh& bvh, const NodeBox& box);

/// The nearest point of a surface. The sign of `distance` follows from the angle-weighted
/// pseudonormal of the face, edge or node (Baerentzen and Aanaes 2005).
struct ClosestPoint {
  int triangle = -1;  ///< -1: no point within the bound
  double barycentric[3] = {0, 0, 0};
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();  ///< outward unit pseudonormal at the point
  double distance = 0.0;        ///< m, negative inside
};
/// Searches within `bound` (m) of p. `hint` is a triangle to start from, or -1; it does not change
/// the result.
ClosestPoint closest_point(const Surface& surface, const Bvh& bvh, const Points& x, const Vec3& p,
                           double bound, int hint = -1);

/// Up to eight points that lie near one another, which search a surface together.
struct PointGroup {
  static constexpr int kMost = 8;
  int count = 0;
  std::array<Vec3, kMost> at;
  std::array<double, kMost> bound;  ///< m
  std::array<int, kMost> hint;
  std::array<ClosestPoint, kMost> closest;
};
/// Sets the closest point of each, as closest_point does.
void find_closest_points(const Surface& surface, const Bvh& bvh, const Points& x,
                         PointGroup& group);
/// Nodes of a surface that lie near one another.
struct NodeGroup {
  int count = 0;
  std::array<int, PointGroup::kMost> nodes;
};
/// All nodes of a surface, in the order of the leaves of its tree.
std::vector<NodeGroup> groups_of(const Surface& surface, const Bvh& bvh);

/// Triangles of leaves whose boxes come within `reach` (m) of p, in an order that is always the
/// same.
void triangles_near(const Bvh& bvh, const Vec3& p, double reach, std::vector<int>& triangles);
/// The nearest point of one triangle, with the normal of the face.
ClosestPoint closest_on_triangle(const Surface& surface, const Points& x, int triangle,
                                 const Vec3& p);

/// Pairs (i, j) of triangles of a and b that cross properly, with i < j for a surface with itself,
/// where triangles that share a vertex are left out.
std::vector<std::array<int, 2>> crossing_triangles(const Surface& a, const Bvh& bvh_a,
                                                   const Points& xa, const Surface& b,
                                                   const Bvh& bvh_b, const Points& xb);
/// The same, into memory of the caller.
void find_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                    const Bvh& bvh_b, const Points& xb, std::vector<std::array<int, 2>>& pairs);
/// The same with pairs that may not cross, in no order that means anything: the triangles of all
/// other pairs are apart, whatever rounding does.
void find_near_crossings(const Surface& a, const Bvh& bvh_a, const Points& xa, const Surface& b,
                         const Bvh& bvh_b, const Points& xb,
                         std::vector<std::array<int, 2>>& pairs);
/// Whether triangle pair[0] of a and pair[1] of b cross.
bool are_crossing(const Surface& a, const Points& xa, const Surface& b, const Points& xb,
                  const std::array<int, 2>& pair);

}  // namespace thew::skin
