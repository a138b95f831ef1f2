// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/character.h"
#include "skin/skin_layer.h"

namespace thew::skin {

/// A character's own skin: it is carried by the weights of its artist, with the displacement by the
/// muscles added. Each point of the skin near a muscle is tied to the site of the muscle below it
/// at rest. It moves out or in by as much as that site has moved against where the weights alone
/// would have carried it. That keeps the point on its side of the muscle, however far the weights
/// sink in. Then it moves out of other flesh that comes up through it. The skin depends only on
/// sites that are fixed to the muscles: the nearest site jumps as the pose changes, and so would
/// the skin.
struct SkinnedSkin {
  struct SurfaceSite {
    int muscle = -1, triangle = -1;  ///< -1: none within reach
    std::array<double, 3> share{};   ///< barycentric coordinates in the triangle
  };
  /// The site of a muscle that is nearest to a point at rest.
  struct Anchor : SurfaceSite {
    Vec3 out = Vec3::Zero();  ///< m, from the site to the point at rest
  };
  /// A point of the skin that is kept out of the muscles: a vertex, or a point of a triangle that
  /// is so wide that a muscle could come through between its vertices.
  struct SkinPoint {
    Triangle corners;  ///< first vertices of their positions; for a vertex three times that vertex
    std::array<double, 3> shares;  ///< barycentric coordinates, sum 1
    /// Share of the muscles' displacement that it takes: 1 near them, 0 beyond reach.
    double share = 0.0;
    double lack = 0.0;  ///< m, by which it lies too low over the flesh at rest; this much is
                        ///< allowed in any pose
    Anchor anchor = {};
  };
  TriMesh mesh;     ///< m, in the bind pose, in the vertex order of the file
  Surface surface;  ///< of the first vertices of their positions, facing outwards
  SkinWeights weights;
  std::vector<int> map_back;   ///< for each vertex, the first vertex of the same position
  Points rest;                 ///< m, in the rest pose of the muscles
  std::vector<Affine> bodies;  ///< world transforms in that pose, scale included
  std::vector<SkinPoint> points;
  std::vector<SurfaceSite> muscle_samples;  ///< sites all over the muscles
  std::vector<double> share;                ///< by vertex, the share of its point, or 0
  std::vector<char> near;       ///< by vertex, whether it is a corner of a point of `points`
  std::vector<char> seen;       ///< by vertex, whether it is the first of its position and can be
                                ///< seen from outside at rest; muscles may go through the others
  std::vector<Mat3> from_rest;  ///< by vertex, takes directions from the rest pose to the bind
                                ///< pose; set where points need it
  std::vector<int> first_neighbour, neighbours;  ///< of the welded mesh: neighbours of i are
                                                 ///< neighbours[first[i]] to [first[i + 1]]
  /// Vertices that the muscles' displacement reaches as it is smoothed, those that are `near`, and
  /// the latter with their neighbours. All others keep what the weights give.
  std::vector<int> reached, near_vertices, round_near;
  SkinSettings settings;
  /// Pairs of triangles that share an edge near the muscles.
  std::vector<std::array<int, 2>> edges;
  std::vector<std::vector<int>> edges_of;  ///< by triangle, indices of `edges`
  // Set by the mean edge of the mesh near the muscles:
  int passes = 0;         ///< number of passes of smoothing the displacement
  int crease_passes = 0;  ///< number of passes of smoothing creases
};

/// Points farther from the muscles at rest than this, in multiples of SkinSettings::reach, are not
/// tied to one. Chosen by trial.
inline constexpr double kAnchorReach = 2.0;

/// Present position (m) of a site of a muscle, or of a point of a skin whose vertices are at x.
Vec3 position_of(const SkinnedSkin::SurfaceSite& of, const std::vector<Collider>& below);
Vec3 position_of(const SkinnedSkin::SkinPoint& point, const Points& x);

/// Binds a skin: `below` are the muscles in the rest pose, `rest` the transforms of the bodies
/// there, scale included.
SkinnedSkin bind_skinned(const TriMesh& mesh, const std::vector<int>& map_back,
                         const SkinWeights& weights, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, const SkinSettings& settings);
/// Sets `lack` of all points of a skin whose other data are set.
void find_rest_lacks(const std::vector<Collider>& below, SkinnedSkin& skin);
/// Sets `seen` of a skin whose topology and rest are set.
void find_seen(SkinnedSkin& skin);
SkinState initial_skinned(const SkinnedSkin& skin);
/// One step. The result depends only on `bodies` (world transforms, scale included) and on the
/// muscles `below`, not on the state before.
void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state);

/// Smooths the displacement from `work.carried` to x at edges that it folds much more sharply than
/// `work.carried` folds them. Such fins rise in the fold of an elbow where neighbours move in
/// different directions. Folds by the weights alone stay. A coarse mesh is not smoothed, because it
/// needs its creases to enclose the muscles.
void even_creases(const SkinnedSkin& skin, SkinnedWork& work, Points& x);

}  // namespace thew::skin
