// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "sim/scene/model.h"

namespace thew::sim {

/// Frames of a probe's run, before the probe itself.
inline constexpr int kFramesBefore = 2;

/// Frames counted from 0 for the scene's first, rising. From the rig's motion alone.
struct ProbeFrames {
  std::vector<int> probes;  ///< start and fastest of the motion, extremes of each muscle's path,
                            ///< and other poses at equal parts of the way
  std::vector<int> checks;  ///< others at equal parts of the way, whatever their pose
};
ProbeFrames choose_probes(const Model& model);

}  // namespace thew::sim
