// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sim/bake/bake.h"
#include "sim/scene/scene.h"
#include "tools/base/command_options.h"
#include "tools/report/report.h"

namespace thew::tools {

/// What there is to say of a bake whose cache is packed, but for its seconds and its pictures.
Report make_report(const Scene& scene, const Model& model, const CommandOptions& options,
                   const std::vector<int>& frames, const BakeResult& result);

/// What is there of a bake beside its report: JSON, cache, the folder of frames, a movie a view.
std::vector<std::string> files_beside_report(const std::filesystem::path& folder,
                                             const std::vector<SceneView>& views);

}  // namespace thew::tools
