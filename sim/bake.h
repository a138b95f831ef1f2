// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "sim/cache.h"
#include "sim/fidelity_planner.h"
#include "sim/measure.h"
#include "sim/step.h"

namespace thew {

struct BakeOptions {
  std::filesystem::path folder;
  std::vector<int> frames;  ///< to be written, rising; all frames before them are simulated
  int threads = 1;
  bool resume = false;
  std::function<bool()> stop = {};  ///< asked between frames that are not written, and packed ones
};

struct BakeResult {
  std::vector<FrameMeasures> measures;  ///< by written frame
  std::string hash;
  Settled settled;
  StageSeconds seconds;
  double write_seconds = 0.0, plan_seconds = 0.0;
  std::optional<FidelityPlan> plan;  ///< where the scene gives a tolerance
  int resumed_frames = 0;            ///< taken from an earlier, interrupted bake
  int threads = 1;                   ///< that the system gave
};

/// Called for each written frame, also for those that an interrupted bake had left; false stops the
/// bake after this frame (its parts stay, for --resume).
using OnFrame = std::function<bool(const BakeFrame& frame)>;

/// The meshes of a bake of the model: muscles, bones, skin.
BakeInfo bake_info(const Model& model, const std::vector<int>& frames);

/// A scene with a tolerance is planned first (the same plan whenever, so that a bake may be
/// resumed). Simulates, writes each frame as it is completed, packs them into DIR/bake.h5.
/// Error(kRetry) where `on_frame` or `stop` stopped it, StepFailure where the solver could not go
/// on; earlier frames stay.
BakeResult bake(const Model& model, const BakeOptions& options, const OnFrame& on_frame);

}  // namespace thew
