// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace thew::tools {

/// Writes the arm into `folder` from its source table: arm.urdf, arm.toml, muscles/*.obj,
/// bones/*.obj, skin.obj. Throws Error(kInput) or Error(kOutput).
void write_arm(const std::filesystem::path& table, const std::filesystem::path& folder);

}  // namespace thew::tools
