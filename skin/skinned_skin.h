// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/character.h"
#include "skin/skin_layer.h"

namespace thew::skin {

/// A skin that its user has skinned already: carried by its own weights, with what the muscles
/// below do on top. A point near muscle first goes as far out or in as the place of the muscle
/// under it did against what the weights would have made of that place, which keeps it on its side
/// of the muscle, however far the weights sink in; and then out of what else comes up through it.
/// All that it goes by are places fixed to the muscles: the nearest ones leap, and so would the
/// skin.
struct SkinnedSkin {
  struct Place {
    int muscle = -1, triangle = -1;  ///< -1: none within reach
    std::array<double, 3> share{};   ///< of the triangle's corners
  };
  /// The place of a muscle that is nearest to a point at rest.
  struct Anchor : Place {
    Vec3 out = Vec3::Zero();  ///< m, from there to the point at rest
  };
  /// A place of the skin that is looked after: a vertex, or one of those that fill a triangle wide
  /// enough for a muscle to come through between its vertices.
  struct Sample {
    Triangle corners;              ///< vertices, the first of their place; of a vertex all the same
    std::array<double, 3> shares;  ///< of the corners, sum 1
    double share = 0.0;            ///< of the muscles' displacement: 1 near them, 0 beyond reach
    double lack = 0.0;             ///< m, that it has at rest of lying over all flesh
    Anchor anchor = {};
  };
  TriMesh mesh;     ///< in the bind pose, the user's vertex order
  Surface surface;  ///< of the first vertices of their places, outwards
  SkinWeights weights;
  std::vector<int> map_back;  ///< of each vertex the first one at the same place
  Points rest;                ///< in the muscles' rest pose
  std::vector<Sample> points;
  std::vector<Place> samples;   ///< all over the muscles
  std::vector<double> share;    ///< by vertex, of its point, or 0
  std::vector<char> near;       ///< by vertex, whether it is a corner of a point
  std::vector<Mat3> from_rest;  ///< by vertex, directions to the bind pose; where points need it
  std::vector<int> first_neighbour, neighbours;  ///< over the welded mesh, by first vertex
  SkinSettings settings;
  std::vector<std::array<int, 2>> edges;  ///< triangles of the surface that share one near muscles
  // By the mesh's fineness:
  int passes = 0;         ///< of smoothing
  int crease_passes = 0;  ///< of evening out creases
};

/// Reaches from a muscle at rest within which it may ever come near.
inline constexpr double kMostNear = 2.0;

Vec3 place_of(const SkinnedSkin::Place& of, const std::vector<Collider>& below);
Vec3 place_of(const SkinnedSkin::Sample& point, const Points& x);

/// `below` are the muscles at rest, `rest` the bodies there.
SkinnedSkin bind_skinned(const TriMesh& mesh, const std::vector<int>& map_back,
                         const SkinWeights& weights, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, const SkinSettings& settings);
/// Of the points of a skin all else of which is there.
void find_lacks(const std::vector<Collider>& below, SkinnedSkin& skin);
SkinState initial_skinned(const SkinnedSkin& skin);
/// The result depends on bodies and muscles alone.
void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state);

/// Evens out the displacement from `work.carried` to x where it folds triangles that share an edge
/// by much more than they are folded there: fins, which the elbow's fold raises where neighbours go
/// different ways. What the weights alone fold stays, and a coarse mesh, which cannot enclose the
/// muscles without, stays almost as it is.
void even_creases(const SkinnedSkin& skin, SkinnedWork& work, Points& x);

}  // namespace thew::skin
