// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "sim/cache/bake_frame.h"

namespace thew::sim {

// DIR/bake.parts while a bake runs: bake.json describes the scene, manifest.jsonl lists the parts,
// and each part is a file for one frame. A part is plain little-endian numbers of 8 bytes. It is
// not HDF5, since such a file is lost by a kill, and its library crashes on a full disk:
//   "thewpart" · version · frame · meshes M · bodies B · metrics K · state S · M numbers of nodes N
//   · M numbers of points of lines L · M times [N, 3] positions · M times [L, 3] lines
//   · [B, 12] bodies · [K] metrics · [S] state
// The state is a third shorter as runs: L · R · [L] numbers · the number that follows them R times,
// and so on until there are S.
// The manifest has the size and hash of each part, so that a changed byte is found.

inline constexpr const char* kManifest = "manifest.jsonl";
/// The name of bake.h5 in the folder of parts, while it is being packed.
inline constexpr const char* kPacked = "bake.h5.tmp";

/// Removes all files of a folder of parts that a bake has written, except those named `kept`.
/// Removes the folder too if it is then empty.
void remove_parts(const std::filesystem::path& folder, const std::set<std::string>& kept = {});
/// The frames that a manifest lists. Their parts are not read and may be damaged.
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

/// Into memory of the caller, which a bake uses for every frame.
void encode_part(const BakeFrame& frame, std::string& bytes);
/// Reads a part, on demand without its state. Error(kOutput) unless its size, hash and contents are
/// those that were written.
BakeFrame read_part(const std::filesystem::path& folder, const Part& part, const BakeInfo& info,
                    bool with_state = true);

/// The text of bake.json: what has to be the same for a bake to be resumed.
std::string describe_scene(const BakeInfo& info);
/// True if the parts in `folder` are of this scene, false if there is no bake.json that can be
/// read. Error(kUsage) that says what differs where they are of another scene.
bool is_scene_of(const std::filesystem::path& folder, const BakeInfo& info);
/// A part, and the folder of parts that it lies in.
struct PlacedPart {
  std::filesystem::path folder;
  Part part;
};
/// Where the frames of `info` are, in folders that hold a bake.parts; those that it lists are not
/// read yet. Errors as of join_chunks() in sim/bake/bake.h.
std::map<int, PlacedPart> parts_of_chunks(const std::vector<std::filesystem::path>& chunks,
                                          const BakeInfo& info);
/// The longest run of undamaged parts, from the first frame of `info` on.
std::vector<Part> good_parts(const std::filesystem::path& folder, const BakeInfo& info);

}  // namespace thew::sim
