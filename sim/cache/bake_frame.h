// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "rig/mesh.h"

namespace thew::sim {

/// One mesh of a bake: what does not change.
struct BakeMesh {
  enum class Kind { kMuscle, kBone, kSkin };
  std::string name;
  Kind kind = Kind::kMuscle;
  TriMesh rest;
  std::vector<double> weights;                     ///< muscles only
  std::vector<std::array<double, 3>> coordinates;  ///< muscles: u along the path 0..1, angle about
                                                   ///< it (rad), 1 in the belly to 0 in the tendon
};

struct BakeInfo {
  std::string scene_name, scene_hash;
  /// To say what differs when another scene is resumed; not packed.
  std::string scene_text;
  std::vector<std::pair<std::string, std::string>> part_hashes;
  double fps = 24.0;
  bool double_precision = false;
  std::vector<int> frames;  ///< those to be written, in order
  std::vector<BakeMesh> meshes;
  std::vector<std::string> metric_names;  ///< scalars per frame, "volume_error/biceps_long", …
  std::string hash;                       ///< of a packed bake, as pack() returned it
};

struct BakeFrame {
  int frame = 0;
  std::vector<std::vector<Vec3>> positions;  ///< by mesh, double
  std::vector<double> metrics;               ///< by BakeInfo::metric_names
  std::vector<double> state;                 ///< what the solver needs to go on after this frame
};

}  // namespace thew::sim
