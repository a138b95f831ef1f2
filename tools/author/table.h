// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "muscles/path.h"
#include "rig/skeleton.h"

namespace thew::tools {

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
  std::string weights = "even";           ///< preset profile along the belly
  double fullest = 0.5;  ///< where the belly's section is largest, 0..1 of the belly
  std::vector<std::pair<double, Vec3>> centres;  ///< m along the path, and where sections lie
  std::vector<std::pair<double, Vec3>> across;   ///< m along the path, and what sections lie across
  double flat = 1.0;                             ///< its section is longer by this factor ...
  Vec3 flat_along = Vec3::UnitY();               ///< ... in this direction
};

/// The arm's bodies and joints; at rest all frames are parallel and the root is the scapula.
Skeleton arm_skeleton();
Pose rest_pose(const Skeleton& skeleton);

/// Reads the table; throws Error(kInput) with file and line.
std::vector<TableMuscle> read_muscle_table(const std::filesystem::path& file,
                                           const Skeleton& skeleton);

}  // namespace thew::tools
