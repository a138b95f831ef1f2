// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstring>
#include <vector>

#include "muscles/lengths.h"
#include "muscles/skyline.h"
#include "rig/character.h"
#include "rig/math.h"
#include "rig/mesh.h"
#include "rig/skeleton.h"
#include "skin/contact/contact.h"
#include "skin/flesh_field.h"

namespace thew::skin {

/// Settings of a skin. Where no reason is given, a default was chosen by trial on the arm and on
/// characters.
struct SkinSettings {
  double thickness = 0.002;  ///< m, least distance of nodes of the skin from muscle and bone
  /// 0..1, resistance of the edges to bending and stretch, relative to the anchors of the bound
  /// shape.
  double smoothing = 0.5;
  int iterations = 6;             ///< in each step
  int iterations_per_search = 4;  ///< for the flesh below, what comes through it, and folds
  double fold_gap = 5e-4;         ///< m, distance kept between the walls of a fold
  /// m, bridging radius R of the flesh field: bridges crevices narrower than R / 2.
  double bridging = 0.012;
  double reach = 0.03;        ///< m, distance within which muscles move a skinned skin
  bool keeps_volume = false;  ///< the enclosed volume stays that of the rest shape
  /// rad, most rotation of a joint in one step of the skin: in larger steps the folds of a fast
  /// elbow crossed (skin/notes.md, "Fast folds in one step").
  double max_turn = 4.0 * kDegree;
  Lengths lengths = {};
};
/// All lengths multiplied by the size of a body [1].
SkinSettings times(const SkinSettings& settings, double size);

/// What may be given by node of a skin layer, or by vertex of a character; empty: nowhere.
struct SkinMaps {
  /// m, how far the rest shape lies over the flesh; negative: as modelled.
  std::vector<double> fat = {};
  /// 0..1: 0 sticks to the flesh below it at rest, 1 slides freely.
  std::vector<double> slide = {};
};

/// The point of the flesh that is nearest to a node at rest.
struct SkinSite {
  int collider = -1, triangle = -1;  ///< -1: none is within reach
  std::array<double, 3> barycentric{};
  Vec3 offset = Vec3::Zero();  ///< m, of the node from it, in the frame of the surface there
};

/// Constant data of a skin layer: topology, rest shape, binding to the bodies.
struct SkinModel {
  Surface surface;
  Points rest;                             ///< m, world positions in the bind pose
  std::vector<std::array<int, 4>> bodies;  ///< for each node the bodies that carry it; -1: unused
  std::vector<std::array<double, 4>> shares;  ///< of these bodies, sum 1
  Pose bind_pose;
  double volume = 0.0;  ///< m^3, enclosed at rest
  SkinSettings settings;
  std::vector<double> fat;    ///< m, level of the flesh field at each node at rest
  std::vector<double> least;  ///< m, least distance that each node keeps from the flesh
  /// m, by node, what it keeps from the other wall of a fold: the fold gap, or less where a wall
  /// lies nearer to it at rest, as between two fingers.
  std::vector<double> wall_level;
  /// m, by node of the flesh, all colliders in turn: the depth below the skin that it keeps, less
  /// than Lengths::cover or negative where it is so at rest. Empty: Lengths::cover.
  std::vector<double> cover;
  /// By triangle, whether it crosses another at rest; two such are not parted. Empty: none.
  std::vector<char> crosses_at_rest;
  std::vector<SkinSite> sites;  ///< by node; empty: all slide freely
  // Elastic energy: sum over edges of w_ij |x_i - x_j - e_ij|^2, and over nodes of a_i |x_i -
  // b_i|^2 + s_i |x_i - t_i|^2, with e the rotated rest vector of an edge, b the bound position of
  // a node, and t where its flesh carries it.
  std::vector<int> first_neighbour, neighbours;  ///< neighbours of i: first[i] to first[i + 1]
  std::vector<double> weights;                   ///< w, by neighbour
  std::vector<double> anchor;                    ///< a
  std::vector<double> stick;                     ///< s; empty: 0
  std::vector<double> weight;                    ///< by node, a, s and the sum of its w
  Skyline matrix;
  SkylineFactor factor;
};

/// A constraint on a point of a triangle of the skin: normal . point >= level (m).
struct SkinPlane {
  int triangle;
  std::array<double, 3> barycentric;
  Vec3 normal;
  double level;
};

/// A rigid motion as a dual quaternion turn + eps shift, with shift = 1/2 (0, t) turn and t the
/// translation (m).
struct DualQuaternion {
  Eigen::Vector4d turn = Eigen::Vector4d::Zero(), shift = Eigen::Vector4d::Zero();
};

/// A node of one wall of a fold against a point of the other: wall.normal . (x_node - point) >=
/// wall.level.
struct SkinFold {
  int node;
  SkinPlane wall;
};

/// Scratch of step_skinned (skinned_skin.h), kept so that a step does not allocate.
struct SkinnedWork {
  std::vector<Affine> of_links;
  std::vector<Eigen::Vector4d> turns;  ///< by link, quaternion of its rotation since the rest pose
  Points carried;                      ///< m, positions by the weights alone
  Points before;                       ///< m, positions before triangles are moved out
  std::vector<double> most;            ///< m, by vertex, how far it may be moved for that
};

/// State of a skin that goes from step to step; a step that fails restores it.
struct SkinMotion {
  Points x;
  // Rotated back to the bind pose:
  Points offset;  ///< m, x less the elastic shape
  /// Of the flesh on each node, in m (force over the stiffness of an edge of weight 1).
  Points force;
  Points slip;                     ///< m, x less the bound shape
  std::vector<double> correction;  ///< m, distance of x from the prediction in the last step
};

/// Nodes of one collider that lie near one another.
struct FleshGroup : NodeGroup {
  int collider;
};

struct SkinState : SkinMotion {
  Bvh bvh;
  Points fitted_at;  ///< m, x to which fit_tree() has fitted the tree
  // Scratch, kept so that a step does not allocate.
  /// m, by node, what a cached shape adds to the bound one, rotated back to the bind pose; empty:
  /// there is none.
  Points carried;
  Points bound;    ///< m, as the bodies alone carry the nodes, and with `carried`
  Points elastic;  ///< m, positions of least elastic energy, without the flesh
  Points stuck;    ///< m, where the flesh would carry a node that sticks to it
  /// By neighbour: m, rotated rest vector e of an edge, and m^2, what the vector of the edge times
  /// e is at least if the edge is surely longer than the least length (kMinEdge).
  Points turned;
  Points displaced;  ///< m, x less elastic
  Points pulls;      ///< m, by node, what relax() adds to the sum of its neighbours
  std::vector<double> inverse_weight;  ///< by node, of the sum of the weights in relax()
  std::vector<int> by_planes;          ///< the nodes, those with fewer planes first
  /// By node with one plane: outward_direction(), and what climb_distance() divides by.
  Points outward;
  Points areas;                   ///< m^2, by triangle, twice its area vector
  Points own_normals;             ///< of the skin
  Points normals;                 ///< unit normals, averaged with those of the neighbours
  Points predicted;               ///< m, x before the passes
  Points begun_at, begun_before;  ///< m, x before this pass, and before the one before it
  Points searched_at;             ///< m, x at the last search for the flesh below
  std::vector<Mat3> turns;
  FleshPlanes planes;
  std::vector<SkinPlane> covers;
  std::vector<SkinFold> folds;
  Points separation;         ///< m, by which the walls of folds were last moved apart, by node
  std::vector<double> room;  ///< m, how far a node may move inwards, at most Lengths::yielding_fat
  Points swelling;           ///< displacement of the nodes by a volume multiplier of 1
  std::vector<int> hints;
  std::vector<NodeGroup> groups;  ///< of the skin; set once
  std::vector<FleshGroup> flesh_groups;
  std::vector<int> flesh_begin;       ///< by collider, index of its first node among all
  std::vector<int> cover_hints;       ///< by node of the flesh
  std::vector<double> cover_slack;    ///< m, by node of the flesh, how far the skin may surely move
                                      ///< without coming near it
  Points covers_at;                   ///< m, x at the last search for covers
  std::vector<char> covered;          ///< by node of the flesh, whether it is near a triangle
  std::vector<SkinPlane> cover_over;  ///< by node of the flesh, if it is
  std::vector<SkinPlane> walls;       ///< by node, the other wall of its fold; triangle -1: none
  std::vector<NodeBox> normal_boxes;  ///< by node of the tree, range of the sums of corner normals
  std::vector<DualQuaternion> motions;        ///< motion of each body since the bind pose
  std::vector<std::array<int, 2>> crossings;  ///< triangles of the skin that cross...
  Points crossings_at;                        ///< m, ...where it lay then
  Points untangled;                           ///< m, x before a round of untangle()
  std::vector<char> marked, frozen;           ///< nodes
  std::vector<char> held;                     ///< nodes, by props
  std::vector<SkinPlane> at_props;            ///< points of props
  Points unswollen;                           ///< m, x before the volume is restored
  PointPairs solution;
  SkinnedWork skinned;
};

inline bool same_bytes(const Points& a, const Points& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Point)) == 0);
}

/// Fits the tree to x, if it is not.
void fit_tree(const Surface& surface, SkinState& state);

struct SkinMetrics {
  double max_penetration = 0.0;  ///< m, largest depth of nodes of the skin in muscle or bone
  /// m, the same of those nodes of a character's skin that find_covered() tells; no part of it.
  double max_covered_penetration = 0.0;
  /// m, largest height over the skin of nodes of muscles and, for a skin layer, of bones.
  double max_poke_through = 0.0;
  int intersecting_pairs = 0;  ///< pairs of triangles of the skin that cross
  double volume_error = 0.0;   ///< |V - V0| / V0 of the enclosed volume
};

}  // namespace thew::skin
