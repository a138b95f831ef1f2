// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/export/gltf/morphs.h"
#include "tools/export/shot.h"

namespace thew::tools {

// What both exporters of glTF say and write.

/// s, by frame: frame / fps as in all formats. glTF has no time below 0: where the first frame is
/// negative, it is at 0.
std::vector<float> seconds_of(const Shot& shot);
/// What there is to say about time 0.
std::string time_note(const Shot& shot);
/// Error(kUsage) where a mesh has more morph targets than readers take.
void check_targets(const std::filesystem::path& file, std::size_t targets);
std::string targets_note(std::size_t targets, std::size_t frames, int basis);
std::string error_note(const Deviation& deviation);
/// The same as numbers in the extras of the asset.
void put_errors(const Deviation& deviation, nlohmann::ordered_json& asset);

}  // namespace thew::tools
