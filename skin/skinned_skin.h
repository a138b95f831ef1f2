// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "rig/character.h"
#include "skin/skin_layer.h"

namespace thew {

/// A skin that its user has skinned already: carried by its own weights, with what the muscles
/// below do on top. A vertex near muscle first goes as far out or in as the place of the muscle
/// under it did against what the weights would have made of that place, which keeps it on its side
/// of the muscle; then it keeps the level over the flesh (flesh_field.h) that it has at rest, so
/// that it rides on a muscle that slides by.
struct SkinnedSkin {
  /// The place of a muscle that is nearest to a vertex at rest.
  struct Anchor {
    int muscle = -1, triangle = -1;  ///< -1: none within reach
    std::array<double, 3> share{};   ///< of the triangle's corners
    Vec3 in_bind = Vec3::Zero();     ///< m, where the vertex' weights take it from to be there
  };
  TriMesh mesh;  ///< in the bind pose, the user's vertex order
  SkinWeights weights;
  std::vector<int> map_back;  ///< of each vertex the first one at the same place
  Rows rest;                  ///< in the muscles' rest pose
  std::vector<double> level;  ///< m, of the flesh field at rest
  std::vector<double> share;  ///< of the muscles' displacement: 1 near them, 0 beyond reach
  std::vector<Anchor> anchors;
  std::vector<int> first_neighbour, neighbours;  ///< over the welded mesh, by first vertex
  SkinSettings settings;
  int passes = 0;  ///< of smoothing, by the mesh's fineness
};

/// `below` are the muscles at rest, `rest` the bodies there.
SkinnedSkin bind_skinned(const TriMesh& mesh, const std::vector<int>& map_back,
                         const SkinWeights& weights, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, const SkinSettings& settings);
SkinState initial_skinned(const SkinnedSkin& skin);
/// The result depends on bodies and muscles alone.
void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state);

/// m, deepest of the points inside a surface.
double deepest_of(const Rows& points, const std::vector<Collider>& below);

}  // namespace thew
