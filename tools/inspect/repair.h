// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

/// Does what cannot spoil a mesh: joins vertices that lie within a millionth of its extent where it
/// is open, drops triangles without area and those that are there twice, turns triangles to one
/// winding and closed parts outward, fills holes of at most eight edges, drops loose vertices. One
/// line for each thing done.
std::vector<std::string> repair(TriMesh& mesh);

/// Reads, repairs and writes an OBJ, never onto what it read; returns what was done. What is left
/// is for find_defects. `overwrite`: also a file that is not Thew's.
std::vector<std::string> repair_file(const std::filesystem::path& file,
                                     const std::filesystem::path& out, bool overwrite = false);

}  // namespace thew::tools
