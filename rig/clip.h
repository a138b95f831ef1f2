// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "rig/skeleton.h"

namespace thew::rig {

/// Joint values against time (s), in rad or m, one row for each key. Before the first and after the
/// last key the values stay constant.
struct Clip {
  enum class Interpolation {
    kLinear,
    kSmooth
  };  ///< kSmooth: monotone cubic (Fritsch and Butland 1984), C1, without overshoot
  std::vector<std::string> joints;
  std::vector<double> times;                ///< strictly increasing
  std::vector<std::vector<double>> values;  ///< values[key][joint]
  Interpolation interpolation = Interpolation::kSmooth;
  std::string file;       ///< from which the clip was read, "" if from none
  std::vector<int> rows;  ///< line of the file for each key
  /// All values were degrees in the file; check_clip then refuses prismatic joints.
  bool angles_only = false;
};

/// Maps the name of a column of a table to the name of a joint. A column that maps to "" is
/// ignored; a column that is missing from the map is an error.
using ColumnMap = std::map<std::string, std::string>;

/// Read an OpenSim .mot or .sto (degrees if its header says inDegrees=yes), or a CSV whose first
/// row names the columns and begins with `time` (rad and m; degrees where the name of the column
/// ends in "_deg"). Throw Error(kInput) with file and line.
Clip read_mot(const std::filesystem::path& file, const ColumnMap& columns);
Clip read_csv(const std::filesystem::path& file, const ColumnMap& columns);

/// Checks a clip against the joints of a skeleton. Keys outside a joint's range by at most 0.5
/// degree (or 0.5 mm) are clamped, with one line for each joint in `warnings`. A key farther
/// outside, an unknown joint, or a value that is not finite is Error(kInput); its message begins
/// with `location`.
void check_clip(Clip& clip, const Skeleton& skeleton, const std::string& location,
                std::vector<std::string>& warnings);

/// Joint values at `time`, one per body of the skeleton (zero for joints that the clip lacks).
void sample_clip(const Clip& clip, const Skeleton& skeleton, double time,
                 std::vector<double>& joint_values);

}  // namespace thew::rig
