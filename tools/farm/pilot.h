// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "tools/farm/jobs.h"

namespace thew::tools {

/// What bakes of one kind cost, on as many threads as a task has.
struct Cost {
  double memory_mib = 0.0;
  double setup = 0.0;    ///< s, of any task
  double frame = 0.0;    ///< s: solved, measured and written
  double copy = 0.0;     ///< s: a frame that is measured and written only
  double picture = 0.0;  ///< s, of each view
};
using Costs = std::map<std::string, Cost>;  ///< by ShotBake::costs_as

/// OUT/pilot.json, where costs are kept, so that the same jobs give the same tasks. Nothing where
/// it is not there; Error(kInput).
Costs read_costs(const Jobs& jobs);

/// Bakes a few frames of each kind that is not in OUT/pilot.json, and adds them. `overwrite`: also
/// over a file that Thew did not write. Error(kUsage) where one cannot be baked.
Costs measure_costs(const Jobs& jobs, const std::filesystem::path& program, bool overwrite);

}  // namespace thew::tools
