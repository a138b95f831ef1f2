// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/skeleton.h"

namespace thew::rig {

/// Reads a URDF through urdfdom and checks what urdfdom leaves out: logged errors, size and depth
/// of nesting, lower > upper, zero or unnormalised axes, mimic joints, cycles, unreachable links,
/// missing visuals, paths (also package://) that leave `allowed_root`. Throws Error(kInput).
Skeleton import_urdf(const std::filesystem::path& file, const std::filesystem::path& allowed_root);

}  // namespace thew::rig
