// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew {

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

/// Writes the frames of one bake as they are completed, into DIR/bake.parts: each part is written
/// beside, synced, read back, renamed, and listed in manifest.jsonl. Holds a lock on DIR.
/// Any failure is Error(kOutput); a second bake into DIR is Error(kRetry).
class BakeWriter {
 public:
  BakeWriter(const std::filesystem::path& folder, const BakeInfo& info, bool resume);
  ~BakeWriter();
  BakeWriter(const BakeWriter&) = delete;
  BakeWriter& operator=(const BakeWriter&) = delete;

  /// Frames already there when resuming (verified by hash), in order; empty otherwise.
  const std::vector<int>& completed() const;
  /// A completed frame, as it was written (double precision).
  BakeFrame read_completed(int frame) const;
  void write(const BakeFrame& frame);
  /// Packs all parts into DIR/bake.h5 (beside, then renamed) and removes them. Returns the XXH3-128
  /// of all positions as little-endian float64, meshes by name, frame by frame, in hex.
  /// `on_frame` may throw to end it: the parts stay.
  std::string pack(const std::function<void()>& on_frame = {});

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Rounded to float32, as a cache keeps it unless it is of double precision.
double as_float(double value);

/// A packed bake; meshes and metrics in the order of their names. Refuses what is not of its format
/// before it allocates: Error(kInput).
class BakeReader {
 public:
  explicit BakeReader(const std::filesystem::path& file);
  ~BakeReader();
  BakeReader(const BakeReader&) = delete;
  BakeReader& operator=(const BakeReader&) = delete;

  const BakeInfo& info() const;
  /// `index` counts written frames from 0; state is empty.
  BakeFrame read(int index) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew
