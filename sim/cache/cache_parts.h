// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "sim/cache/bake_frame.h"

namespace thew::sim {

// What lies in DIR/bake.parts while a bake runs: bake.json says of what scene, manifest.jsonl lists
// the parts, each a file for one frame. A part is plain little-endian numbers of 8 bytes, not HDF5,
// whose files do not survive a kill and whose library does not survive a full disk:
//   "thewpart" · version · frame · meshes M · metrics K · state S · M numbers of nodes N
//   · M times [N, 3] positions · [K] metrics · [S] state
// The manifest has its size and hash, so that a byte that changed is found.

inline constexpr const char* kManifest = "manifest.jsonl";
/// bake.h5 while it is being packed, among the parts.
inline constexpr const char* kPacked = "bake.h5.tmp";

/// Removes what is ours of a folder of parts, but for the names `kept`, and the folder once nothing
/// is left in it.
void remove_parts(const std::filesystem::path& folder, const std::set<std::string>& kept = {});
/// The frames that a manifest lists, whole or not, without a look at their parts.
std::vector<int> listed_frames(const std::filesystem::path& folder);

/// One line of manifest.jsonl.
struct Part {
  int frame = 0;
  std::string file;
  std::size_t bytes = 0;
  std::string hash;  ///< XXH3-128
};

std::string part_file(int frame);
std::string manifest_line(const Part& part);

std::string encode_part(const BakeFrame& frame);
/// Error(kOutput) unless size, hash and contents are those that were written.
BakeFrame read_part(const std::filesystem::path& folder, const Part& part, const BakeInfo& info);

/// bake.json: what has to be the same for a bake to go on.
std::string describe_scene(const BakeInfo& info);
/// Error(kUsage) that says what differs from the scene whose parts lie in `folder`; false when
/// there is no such scene.
bool is_scene_of(const std::filesystem::path& folder, const BakeInfo& info);
/// The longest run of parts from the first frame of `info` on, in which each is whole.
std::vector<Part> good_parts(const std::filesystem::path& folder, const BakeInfo& info);

}  // namespace thew::sim
