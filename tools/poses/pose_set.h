// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "sim/cache/array_file.h"
#include "sim/cache/cache.h"
#include "sim/scene/model.h"

namespace thew::tools {

/// What a deformer is trained on. README.md says what each text and array is.
struct PoseSet {
  std::vector<std::pair<std::string, std::string>> texts;
  std::vector<sim::NamedArray> arrays;
};

/// Of a bake whose frames are the poses. `poses` has the values of moving_joints() by frame; where
/// an animation moves all bodies it is empty, and the set has how each body is turned instead.
/// Error(kUsage) where the model has no skin.
PoseSet make_pose_set(const sim::Model& model, const std::vector<std::vector<double>>& poses,
                      const sim::BakeReader& bake);

/// A zip archive of .npy files, as numpy.load reads it, without compression; texts are arrays of
/// UTF-8 bytes.
void write_npz(const PoseSet& set, const std::filesystem::path& file);

}  // namespace thew::tools
