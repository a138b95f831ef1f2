// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/scene/scene.h"
#include "tools/base/progress.h"

namespace thew::tools {

/// One frame from all sides: FOLDER/VIEW_turn.0001.png and so on, each view's eye turned about its
/// target and up in `count` even steps, listed in `files`, and VIEW_turn.mp4 where ffmpeg is
/// installed. Says what went wrong with a movie, "" for nothing.
std::string draw_turntable(const BakeReader& bake, int frame, const SceneRender& render, int count,
                           const std::filesystem::path& folder, bool overwrite, ProgressStyle style,
                           std::vector<std::filesystem::path>& files);

}  // namespace thew::tools
