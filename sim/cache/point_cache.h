// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "rig/mesh_motion.h"

namespace thew::sim {

/// Whether the ending is that of a point cache: PC2 or MDD.
bool names_point_cache(const std::filesystem::path& file);

/// Reads the positions of `points` points from a PC2, whose samples are so many frames apart, or an
/// MDD, which gives seconds. Error(kInput) with the sample and the point for what is no place, and
/// for a file of another size than its header says.
MeshSamples read_point_cache(const std::filesystem::path& file, std::size_t points, double fps);

}  // namespace thew::sim
