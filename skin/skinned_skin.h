// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "rig/character.h"
#include "skin/skin_layer.h"

namespace thew::skin {

/// A character's own skin. Around the muscles it is a skin layer (skin_layer.h) whose bound shape
/// is what the artist's weights give: elastic, kept out of muscles and bones, out of itself.
/// Everywhere else, and where nothing presses, it is what the weights give. Wide triangles are
/// divided for the layer, so that flesh does not come through between their vertices.
struct SkinnedSkin {
  /// A node of the layer: a vertex, or a point of a triangle that was divided. `corners` are first
  /// vertices of their positions; for a vertex three times that vertex.
  struct Node {
    Triangle corners;
    std::array<double, 3> shares;  ///< barycentric coordinates, sum 1
    bool is_held = false;          ///< at the layer's rim: it keeps what the weights give
    bool is_vertex() const { return corners[0] == corners[1] && corners[1] == corners[2]; }
  };
  TriMesh mesh;     ///< m, in the bind pose, in the vertex order of the file
  Surface surface;  ///< of the first vertices of their positions, facing outwards
  SkinWeights weights;
  std::vector<int> map_back;   ///< for each vertex, the first vertex of the same position
  Points rest;                 ///< m, in the rest pose of the muscles, as the weights give it
  std::vector<Affine> bodies;  ///< world transforms in that pose, scale included
  std::vector<char> seen;      ///< by vertex, whether it is the first of its position and can be
                               ///< seen from outside at rest; muscles may go through the others
  SkinSettings settings;
  std::vector<Node> nodes;  ///< of the layer
  Points lift;              ///< m, by node, what fat adds to its rest position; empty: nothing
  SkinModel layer;          ///< its surface is of triangles that are seen
  SkinMotion start;         ///< the layer where the muscles are made, all joints at 0
  /// By node, the links that carry it and how much, of which its rotation is blended.
  std::vector<std::vector<std::pair<int, double>>> carriers;
};

/// Binds the skin of a character: `rest` are the transforms of its bodies in the rest pose, scale
/// included, `below` the muscles there and then the bones that the skin feels, `muscles` the number
/// of the former, `limbs` by body whether it is moved by them. Of the `maps`, by vertex, fat counts
/// within SkinSettings::reach of a muscle and fades out to where the layer ends.
SkinnedSkin bind_skinned(const Character& character, const std::vector<Affine>& rest,
                         const std::vector<Collider>& below, int muscles,
                         const std::vector<char>& limbs, const SkinSettings& settings,
                         const SkinMaps& maps = {});
/// Sets `seen` of a skin whose topology and rest are set.
void find_seen(SkinnedSkin& skin);
/// Which vertices that are seen at rest, are no free nodes of the layer and lie among muscles lie
/// inside other skin: those of a trunk into which a motion lays an arm. By vertex; `x` (m) is the
/// skin as it is, `bvh` the tree of its surface there.
std::vector<char> find_covered(const SkinnedSkin& skin, const std::vector<Collider>& muscles,
                               const Points& x, const Bvh& bvh);
/// The skin in the rest pose, and its layer.
SkinState initial_skinned(const SkinnedSkin& skin);
SkinState initial_layer(const SkinnedSkin& skin);
/// One step. The result depends only on `bodies` (world transforms, scale included), on what is
/// `below` as in bind_skinned(), on the props, and on the layer of the step before.
/// `share_of_return` is that of step_skin().
void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, const Loop& loop, SkinState& layer,
                  SkinState& state, double share_of_return = kReturn, const Props& props = {});

}  // namespace thew::skin
