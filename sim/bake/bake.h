// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <vector>

#include "sim/bake/measure.h"
#include "sim/cache/cache.h"
#include "sim/fidelity/planner.h"
#include "sim/settle.h"
#include "sim/step.h"

namespace thew::sim {

/// What a bake needs besides the model.
struct BakeOutput {
  bool double_precision = false;
  /// For a message that says what differs when another scene is resumed.
  std::string scene_text = {};
  /// For whoever finds it interrupted: what was called, and in which folder.
  std::string command = {}, directory = {};
};

struct BakeOptions {
  std::filesystem::path folder;
  /// To be written, ascending. All frames before them are simulated, unless each stands by itself
  /// (lone_frame.h).
  std::vector<int> frames;
  int threads = 1;
  bool resume = false;
  BakeOutput output = {};
  std::function<bool()> stop = {};  ///< returns true to stop; called between frames
  bool is_chunk = false;            ///< leaves the frames in DIR/bake.parts, for join_chunks()
};

/// Seconds by stage, without the time spent in `on_frame`.
struct BakeSeconds {
  Seconds setup;  ///< plan of a tolerance, first state, reading an interrupted bake
  Seconds plan;   ///< plan of a tolerance; part of `setup`
  Seconds settle, measure, write;
  StageSeconds step;  ///< all frames
};

struct BakeResult {
  std::vector<FrameMeasures> measures;  ///< by written frame
  std::string hash;
  Settled settled;
  BakeSeconds seconds;
  std::optional<FidelityPlan> plan;  ///< where the scene gives a tolerance
  int resumed_frames = 0;            ///< read from an earlier, interrupted bake
  int threads = 1;                   ///< as many as the system gave
};

/// Called for each written frame, also for those of an interrupted bake that is resumed. Returning
/// false stops the bake after this frame; its parts stay, so that it can be resumed.
using OnFrame = std::function<bool(const BakeFrame& frame)>;

/// The description of a bake of the model. Its meshes are muscles, bones and skin, in this order.
BakeInfo bake_info(const Model& model, const std::vector<int>& frames,
                   const BakeOutput& output = {});

/// Simulates the model, writes each frame as it is completed, and packs them into DIR/bake.h5. A
/// scene with a tolerance is planned first, always with the same result, so that its bake can be
/// resumed. Error(kRetry) where `on_frame` or `stop` stopped it; StepFailure where the solver
/// failed; Error of BakeWriter. Frames that are written stay in all cases.
BakeResult bake(const Model& model, const BakeOptions& options, const OnFrame& on_frame);

/// The same bake, to the last byte, from frames that others have baked: folders in which bakes of
/// the scene have left them, as chunks. Error(kInput) where a frame is in none of them, or where
/// two of them differ in it; Error(kOutput) where one is damaged; Error(kUsage) where one is of
/// another scene.
BakeResult join_chunks(const Model& model, const BakeOptions& options,
                       const std::vector<std::filesystem::path>& chunks, const OnFrame& on_frame);

}  // namespace thew::sim
