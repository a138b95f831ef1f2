// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/cache/cache.h"
#include "sim/scene/model.h"
#include "sim/scene/scene.h"

namespace thew::sim {

/// Whether a camera of the scene depends on what its bodies do.
bool follows_motion(const SceneRender& render);

/// The scene's views with their eyes and targets, as its rig and clip alone have them: whichever
/// frames are baked or drawn, by whom and in which order. A view with `from` stands as near as
/// shows, in all frames of the scene, the bones, the muscles and the skin of the bodies that hang
/// on the one it follows, of all bodies where it follows none, within kFill of the picture's width
/// and height. Props are not looked at. Views of one direction have one camera.
/// Throws Error(kUsage) for a body that the rig does not have, or on which nothing is to be seen.
std::vector<SceneView> frame_views(const Model& model, const SceneRender& render);
inline constexpr double kFill = 0.92;

/// Whether a view shows meshes of a kind: the skin alone, muscles and bones, or all of them; props
/// always.
bool shows(const SceneView& view, BakeMesh::Kind kind);

/// The same of a bake without its scene: a view with `from` stands as near as shows all meshes that
/// it draws, but props, in `frames`, those of them that the bake has. Throws Error(kUsage) for a
/// view that follows a body, since a bake has none, and where nothing is to be seen.
std::vector<SceneView> frame_views(const BakeReader& bake, const std::vector<int>& frames,
                                   const SceneRender& render);

/// The view as it is in a frame; before the scene's first and after its last one it stays.
SceneView view_at(const SceneView& view, int frame);

}  // namespace thew::sim
