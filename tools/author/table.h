// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "muscles/path.h"
#include "muscles/weights.h"
#include "rig/skeleton.h"

namespace thew::tools {

/// A measured section of a muscle, in the humerus' frame at rest.
struct TableSection {
  Vec3 centre;            ///< m
  double area = 0.0;      ///< of the muscle's largest
  double flatness = 1.0;  ///< its width by its thickness
  Vec3 along;             ///< the direction of its width, a unit vector
};

/// One muscle of the source table (assets/arm/muscles.csv): what is known of it, and how we shape
/// it.
struct TableMuscle {
  std::string name;
  MusclePath path;
  double f_max = 0.0;                     ///< N
  double fibre_length = 0.0;              ///< m
  double volume = 0.0;                    ///< m^3
  std::array<double, 2> belly{};          ///< m along the rest path
  double twist_from = 0.0;                ///< m along the rest path
  int around = 0, rings = 0;              ///< nodes a ring, rings
  std::vector<double> before, after;      ///< m, rings of the tendons: from origin, from insertion
  std::array<double, 2> tendon_radius{};  ///< m
  WeightProfile weights;                  ///< along the belly
  std::vector<TableSection> sections;     ///< from origin to insertion
};

/// The arm's bodies and joints; at rest all frames are parallel and the root is the scapula.
Skeleton arm_skeleton();
Pose rest_pose(const Skeleton& skeleton);

/// Reads the table; throws Error(kInput) with file and line. A `point` with a fourth number takes
/// that share of the turn of its body against the one that its joint hangs on. `weights` are a
/// preset's name or keys: u, weight, u, weight, ...
std::vector<TableMuscle> read_muscle_table(const std::filesystem::path& file,
                                           const Skeleton& skeleton);

}  // namespace thew::tools
