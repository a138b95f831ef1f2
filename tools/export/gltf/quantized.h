// SPDX-License-Identifier: Apache-2.0
//
// KHR_mesh_quantization: displacements of positions as int16, of normals as int8, shares of the
// largest that there is. Half as large as float32.
#pragma once

#include "tools/export/gltf/glb.h"
#include "tools/export/gltf/morphs.h"

namespace thew::tools {

inline constexpr const char* kQuantization = "KHR_mesh_quantization";

/// Rounds a morph target a frame to whole steps, so that morphed() gives what a reader sees.
/// Returns the scale (m) that the mesh's node needs: its numbers are shares of it. A displacement
/// of normals is 1 at most by axis: where one of the base is farther from some frame, the base
/// takes another that is not. Where no other is near enough, normals stay as they are.
double quantize(Morphs& morphs);

/// As quantize() has rounded them: the base over `scale` as float32, a target in steps. Each
/// returns the number of the new accessor.
std::size_t add_scaled(Glb& glb, const std::vector<Vec3>& values, double scale);
std::size_t add_steps_16(Glb& glb, const std::vector<Vec3>& values, double scale);
/// int8 where all of them are whole steps of it, else float32.
std::size_t add_normal_steps(Glb& glb, const std::vector<Vec3>& values);

}  // namespace thew::tools
