// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rig/skeleton.h"

namespace thew::rig {

/// Joint values against time (s): one row per key, rad or m. Held constant outside its range.
struct Clip {
  enum class Interpolation { kLinear, kSmooth };  ///< smooth: monotone cubic, C1, no overshoot
  std::vector<std::string> joints;
  std::vector<double> times;                ///< strictly increasing
  std::vector<std::vector<double>> values;  ///< values[key][joint]
  Interpolation interpolation = Interpolation::kSmooth;
  std::string file;          ///< that it was read from, "" for none
  std::vector<int> rows;     ///< of the file: the line of each key
  bool angles_only = false;  ///< read from degrees as a whole: check_clip refuses prismatic joints
};

/// Columns of a table file, mapped to joints: column name -> joint name. Columns that are not
/// mapped are ignored only when listed with an empty joint name; others are an error.
using ColumnMap = std::map<std::string, std::string>;

/// OpenSim .mot/.sto (inDegrees honoured) and CSV with a header whose first column is `time`
/// (rad, or deg where the column's name ends in "_deg"). Throws Error(kInput) with file and line.
Clip read_mot(const std::filesystem::path& file, const ColumnMap& columns);
Clip read_csv(const std::filesystem::path& file, const ColumnMap& columns);

/// Keys outside a joint's range by at most 0.5 degree (or 0.5 mm) are clamped, with one line per
/// joint in `warnings`; more, an unknown joint, or a value that is not finite is Error(kInput).
/// `place` begins each message.
void check_clip(Clip& clip, const Skeleton& skeleton, const std::string& location,
                std::vector<std::string>& warnings);

/// Joint values at `time`, one per body of the skeleton (zero for joints that the clip lacks).
void sample_clip(const Clip& clip, const Skeleton& skeleton, double time,
                 std::vector<double>& joint_values);

}  // namespace thew::rig
