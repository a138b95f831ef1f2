// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// A mesh's motion as one rigid piece, from its rest pose to each frame.
using RigidMotion = std::vector<Transform>;

/// The rotation and translation that come closest to a frame (Umeyama 1991), if they come as close
/// as float32 does.
std::optional<Transform> rigid_fit(const std::vector<Vec3>& rest, const std::vector<Vec3>& frame);

/// By chosen mesh; empty where it is not rigid, and where it stands still. Reads all frames.
std::vector<RigidMotion> rigid_motions(const Shot& shot);

}  // namespace thew::tools
