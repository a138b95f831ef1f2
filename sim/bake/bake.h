// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "sim/bake/measure.h"
#include "sim/cache/cache.h"
#include "sim/fidelity/planner.h"
#include "sim/step.h"

namespace thew::sim {

/// What of a bake is not the model's.
struct BakeOutput {
  bool double_precision = false;
  std::string scene_text = {};  ///< to say what differs when another scene is resumed
};

struct BakeOptions {
  std::filesystem::path folder;
  std::vector<int> frames;  ///< to be written, rising; all frames before them are simulated
  int threads = 1;
  bool resume = false;
  BakeOutput output = {};
  std::function<bool()> stop = {};  ///< asked between frames that are not written, and packed ones
};

/// Wall seconds of the thread that bakes, by stage. What `on_frame` takes is not among them.
struct BakeSeconds {
  double setup = 0.0;  ///< plan of a tolerance, first state, frames of an interrupted bake
  double plan = 0.0;   ///< of `setup`
  double settle = 0.0, measure = 0.0, write = 0.0;
  StageSeconds step;  ///< of the frames
};

struct BakeResult {
  std::vector<FrameMeasures> measures;  ///< by written frame
  std::string hash;
  Settled settled;
  BakeSeconds seconds;
  std::optional<FidelityPlan> plan;  ///< where the scene gives a tolerance
  int resumed_frames = 0;            ///< taken from an earlier, interrupted bake
  int threads = 1;                   ///< that the system gave
};

/// Called for each written frame, also for those that an interrupted bake had left; false stops the
/// bake after this frame (its parts stay, for --resume).
using OnFrame = std::function<bool(const BakeFrame& frame)>;

/// The meshes of a bake of the model: muscles, bones, skin.
BakeInfo bake_info(const Model& model, const std::vector<int>& frames,
                   const BakeOutput& output = {});

/// A scene with a tolerance is planned first (the same plan whenever, so that a bake may be
/// resumed). Simulates, writes each frame as it is completed, packs them into DIR/bake.h5.
/// Error(kRetry) where `on_frame` or `stop` stopped it, StepFailure where the solver could not go
/// on; earlier frames stay.
BakeResult bake(const Model& model, const BakeOptions& options, const OnFrame& on_frame);

}  // namespace thew::sim
