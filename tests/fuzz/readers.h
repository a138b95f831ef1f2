// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>

#include "rig/clip.h"
#include "rig/import/character_import.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/skeleton.h"
#include "sim/cache/cache.h"
#include "sim/cache/cache_parts.h"
#include "sim/cache/hash.h"
#include "sim/cache/point_cache.h"
#include "sim/scene/reader.h"
#include "sim/scene/scene.h"

namespace thew::tests {

namespace fs = std::filesystem;

inline void put_bytes(const fs::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary | std::ios::trunc)
      .write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

/// What anyone may hand to Thew, each as a file of the folder, which has what a scene names.
enum class Reader { kScene, kClip, kUrdf, kMesh, kCache, kPoints, kAttribute };
inline constexpr const char* kReaders[] = {"scene", "clip",   "urdf",     "mesh",
                                           "cache", "points", "attribute"};

inline void prepare_folder(const fs::path& folder) {
  fs::remove_all(folder);
  fs::create_directories(folder);
  for (const char* scene : {"every_key", "pair"}) {
    fs::copy(fs::path(THEW_SOURCE_DIR "/tests/scenes") / scene, folder,
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
  }
}

inline void read_clip(const fs::path& folder, std::string_view bytes) {
  Skeleton skeleton;
  skeleton.body_names = {"root", "ulna"};
  skeleton.joint_names = {"", "elbow"};
  skeleton.joint_types = {Skeleton::JointType::kFixed, Skeleton::JointType::kRevolute};
  skeleton.lower = {0.0, 0.0};
  skeleton.upper = {0.0, 2.5};
  const bool is_csv = bytes.substr(0, 8).find("time") != bytes.npos;
  const fs::path file = folder / (is_csv ? "clip.csv" : "clip.mot");
  put_bytes(file, bytes);
  const ColumnMap columns = {{"elbow", "elbow"}, {"wrist", ""}};
  Clip clip = is_csv ? read_csv(file, columns) : read_mot(file, columns);
  std::vector<std::string> warnings;
  check_clip(clip, skeleton, "clip", warnings);
  std::vector<double> values;
  for (const double time : {-1.0, 0.0, 0.5, 1e9}) sample_clip(clip, skeleton, time, values);
}

/// Writes bytes whose first line is the file's ending; nothing where that is none.
inline fs::path put_with_ending(const fs::path& folder, std::string_view bytes) {
  const size_t end = std::min(bytes.find('\n'), bytes.size());
  const std::string ending(bytes.substr(0, std::min<size_t>(end, 5)));
  if (ending.find('/') != ending.npos || ending.find('\0') != ending.npos) return {};
  const fs::path file = folder / ("mesh." + ending);
  put_bytes(file, bytes.substr(std::min(end + 1, bytes.size())));
  return file;
}

inline void read_mesh(const fs::path& folder, std::string_view bytes) {
  const fs::path file = put_with_ending(folder, bytes);
  if (file.empty()) return;
  const ImportedMesh mesh = import_mesh(file);
  fs::remove(file);
  find_defects(mesh.mesh);
}

/// A PLY or glTF with an attribute, of a character where it has a skin.
inline void read_attribute(const fs::path& folder, std::string_view bytes) {
  const fs::path file = put_with_ending(folder, bytes);
  if (file.empty()) return;
  if (bytes.find("\"skins\"") == bytes.npos) {
    import_attribute(file, file.extension() == ".ply" ? "fat" : "_THEW_FAT");
  } else {
    const Character character = import_character(file);
    import_attribute(file, "_THEW_FAT", -1, character);
    import_attribute(file, "COLOR_0", 2, character);
  }
  fs::remove(file);
}

/// The bake of which the parts and the bake.h5 of the corpus are.
inline BakeInfo corpus_info() {
  BakeInfo info;
  info.scene_name = "corpus";
  info.scene_hash = "0123456789abcdef";
  info.frames = {1, 2};
  const TriMesh mesh{{Vec3(0, 0, 0), Vec3(1.0 / 3, 0, 0), Vec3(0, 1.0 / 7, 0), Vec3(0, 0, 0.1)},
                     {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  info.meshes = {{"biceps", BakeMesh::Kind::kMuscle, mesh, {0, 1, 1, 0}, {}},
                 {"ulna", BakeMesh::Kind::kBone, mesh, {}, {}}};
  info.metric_names = {"volume_error/biceps", "penetration"};
  return info;
}

/// A manifest, a bake.json, a part or a bake.h5, by its first byte.
inline void read_cache(const fs::path& folder, std::string_view bytes) {
  const BakeInfo info = corpus_info();
  if (bytes.starts_with("{\"frame")) {
    put_bytes(folder / "manifest.jsonl", bytes);
    good_parts(folder, info);
  } else if (bytes.starts_with("{")) {
    put_bytes(folder / "bake.json", bytes);
    is_scene_of(folder, info);
  } else if (bytes.starts_with("thew")) {
    const Part part{1, part_file(1), bytes.size(), hash_of(bytes)};
    put_bytes(folder / part.file, bytes);
    read_part(folder, part, info);
  } else {
    put_bytes(folder / "bake.h5", bytes);
    const BakeReader reader(folder / "bake.h5");
    for (size_t i = 0; i < reader.info().frames.size() && i < 100; ++i) {
      reader.read(static_cast<int>(i));
    }
  }
}

/// A PC2 or an MDD of two points, by its first byte.
inline void read_points(const fs::path& folder, std::string_view bytes) {
  const fs::path file = folder / (bytes.starts_with('P') ? "points.pc2" : "points.mdd");
  put_bytes(file, bytes);
  const MeshSamples samples = read_point_cache(file, 2, 24.0);
  const MeshMotion motion = motion_of(samples.positions[0], samples, 0.0);
  for (const double time : {-1.0, 0.01, 1e9}) pose_at(motion, time);
}

/// True where the bytes were accepted, false where they were refused by an Error; whatever else
/// happens is a finding.
inline bool accepts(Reader reader, const fs::path& folder, std::string_view bytes) {
  try {
    switch (reader) {
      case Reader::kScene:
        put_bytes(folder / "scene.toml", bytes);
        read_scene(folder / "scene.toml");
        break;
      case Reader::kClip:
        read_clip(folder, bytes);
        break;
      case Reader::kUrdf:
        put_bytes(folder / "rig.urdf", bytes);
        import_urdf(folder / "rig.urdf", folder);
        break;
      case Reader::kMesh:
        read_mesh(folder, bytes);
        break;
      case Reader::kCache:
        read_cache(folder, bytes);
        break;
      case Reader::kPoints:
        read_points(folder, bytes);
        break;
      case Reader::kAttribute:
        read_attribute(folder, bytes);
        break;
    }
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace thew::tests
