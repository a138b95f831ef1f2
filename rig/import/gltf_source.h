// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

/// Whether the file's ending is glTF's: gltf, glb or vrm.
bool names_gltf(const std::filesystem::path& file);

/// A glTF file with all that it refers to, for a program that writes it again with other shapes.
struct GltfSource {
  /// The document. Its views are all of one buffer, and do not overlap. Images have become
  /// views. Compression is gone: only files that hold the plain numbers too are read.
  std::string json;
  std::string bytes;  ///< of the buffer
  /// The positions, normals and first texture coordinates (u, v, 0; v down) of all primitives, by
  /// their accessor. Numbers of other accessors are left out.
  struct Vectors {
    int accessor = -1;
    std::vector<Vec3> values;
  };
  std::vector<Vectors> vectors;
  std::vector<std::string> warnings;
};

/// Reads it in a child process. Throws Error(kInput) with the file, the cause and what the user can
/// do.
GltfSource read_gltf_source(const std::filesystem::path& file);

}  // namespace thew::rig
