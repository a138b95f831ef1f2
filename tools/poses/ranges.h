// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/skeleton.h"
#include "sim/scene/scene.h"

namespace thew::tools {

/// Which poses of a scene are wanted, as RANGES.toml says it. README.md has the keys.
struct PoseRanges {
  struct Joint {
    std::string name, location;
    std::array<double, 2> range = {0.0, 0.0};  ///< rad, or m where it slides
    int grid = 1;                              ///< values of it in the grid
  };
  std::filesystem::path scene;
  std::vector<Joint> joints;
  int random = 0;
  int seed = 1;
  std::string frames;  ///< of the scene's clip, as --frames has them; "" for none
  bool has_grid = false;
};

/// Error(kUsage) with file and line.
PoseRanges read_ranges(const std::filesystem::path& file);

/// The joints of the skeleton that move, as places of bodies, in its order.
std::vector<int> moving_joints(const rig::Skeleton& skeleton);

/// Values (rad or m) of moving_joints(), by pose: those of the grid, the last joint fastest; the
/// random ones, each joint evenly over its range; those of the clip. A joint that is given no range
/// is 0 in the first two. Error(kUsage) for a joint that the skeleton lacks, for a range beyond its
/// own, and where there is no pose.
std::vector<std::vector<double>> sample_poses(const PoseRanges& ranges,
                                              const rig::Skeleton& skeleton,
                                              const sim::Scene& scene);

/// Whether an animation moves all bodies of the scene, and not joints.
bool moves_all_bodies(const sim::Scene& scene);
/// Of such a scene the frames that are asked for; each is to be found by itself (quasi_static).
/// Error(kUsage) where joints are asked for, or no frame.
std::vector<int> take_frames(const PoseRanges& ranges, sim::Scene& scene);
/// Makes the poses the frames of the scene, 1 and on, each to be found by itself.
void set_poses(const std::vector<std::vector<double>>& poses, const rig::Skeleton& skeleton,
               sim::Scene& scene);

}  // namespace thew::tools
