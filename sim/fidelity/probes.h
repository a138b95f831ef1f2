// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sim/scene/model.h"

namespace thew::sim {

/// Frames that are simulated before a probe, so that it has the velocities and contacts of its
/// level.
inline constexpr int kFramesBefore = 2;

/// Frames, ascending, counted from 0 at the scene's first. Chosen from the rig's motion alone.
struct ProbeFrames {
  std::vector<int> probes;  ///< start and fastest of the motion, extremes of each muscle's path,
                            ///< and other poses at equal shares of the travel
  std::vector<int> checks;  ///< other frames at equal shares of the travel, in any pose
};
ProbeFrames choose_probes(const Model& model);

}  // namespace thew::sim
