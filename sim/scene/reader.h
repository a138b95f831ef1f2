// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/scene/scene.h"

namespace thew::sim {

/// Friction, and muscles that meet themselves, need an integrator that solves contact within its
/// iterations.
bool can_solve_contact(const Scene& scene, const std::string& integrator);

/// Reads and checks a scene file; `overrides` are "solver.integrator=explicit" (any key of the
/// scene, as TOML values; a bare word is a string; [[muscle]] and [[render.view]] by name:
/// "muscle.biceps_long.weights=left"). Unknown keys are refused with "did you mean", and old names
/// of keys put a warning into the scene. Relative paths are relative to the scene's folder and stay
/// below `allowed_root`, which is that folder unless given. Throws Error(kUsage) with file and
/// line; Error(kInput) for what is wrong in a clip or weight file.
Scene read_scene(const std::filesystem::path& file, const std::vector<std::string>& overrides = {},
                 const std::filesystem::path& allowed_root = {});
/// The [render] of a scene alone; all else may be missing.
SceneRender read_render(const std::filesystem::path& file,
                        const std::vector<std::string>& overrides = {});

}  // namespace thew::sim
