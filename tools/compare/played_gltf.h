// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// A mesh of a glTF file, one primitive of a node, as its first animation moves it: nodes, morph
/// targets, weights of joints.
struct PlayedMesh {
  std::string name;      ///< of its node, or else of its mesh
  std::string material;  ///< by name
  std::vector<std::uint32_t> indices;
  std::vector<double> uvs;                ///< the first set, two a vertex; empty: none
  std::vector<std::vector<Vec3>> frames;  ///< by time, m, in the world
};
struct PlayedGltf {
  std::vector<double> times;  ///< s, at which the animation has a key; one of 0 where there is none
  double fps = 0.0;           ///< as an export of ours says; 0: unknown
  std::vector<PlayedMesh> meshes;
};

/// Reads and plays the file in a child process. Error(kInput) as of read_gltf_source(), and where
/// it is more than the child may keep.
PlayedGltf play_gltf(const std::filesystem::path& file);

}  // namespace thew::tools
