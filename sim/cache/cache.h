// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "sim/cache/bake_frame.h"

namespace thew::sim {

/// Makes sure that DIR/bake.h5 and DIR/bake.parts are not there or were written by Thew: they are
/// listed (own_files.h), or their contents are a bake, by a version that kept no list.
/// Error(kOutput) otherwise.
void claim_bake(const std::filesystem::path& folder);
/// Writes the frames of one bake into DIR/bake.parts as they are completed. Each part is written
/// under a temporary name, synced, read back, renamed, and listed in manifest.jsonl. Holds a lock
/// on DIR. Any failure is Error(kOutput); a second bake into DIR is Error(kRetry).
class BakeWriter {
 public:
  BakeWriter(const std::filesystem::path& folder, const BakeInfo& info, bool resume);
  ~BakeWriter();
  BakeWriter(const BakeWriter&) = delete;
  BakeWriter& operator=(const BakeWriter&) = delete;

  /// Frames that were there already when resuming, verified by hash, ascending; empty otherwise.
  const std::vector<int>& completed() const;
  /// A completed frame, as it was written (double precision).
  BakeFrame read_completed(int frame) const;
  void write(const BakeFrame& frame);
  /// Packs all parts into DIR/bake.h5 (under a temporary name, then renamed) and removes them.
  /// Returns the XXH3-128 of all positions as little-endian float64, meshes by name, frame by
  /// frame, in hex. `on_frame` is called after each frame and may throw to end it; the parts then
  /// stay.
  std::string pack(const std::function<void()>& on_frame = {});

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

/// Rounded to float32, as a cache keeps it unless it is of double precision.
double as_float(double value);

/// Reads a packed bake. Meshes and metrics are in the order of their names. Sizes are checked
/// before memory is allocated. Error(kInput) for a file that is no bake of this version.
class BakeReader {
 public:
  explicit BakeReader(const std::filesystem::path& file);
  ~BakeReader();
  BakeReader(const BakeReader&) = delete;
  BakeReader& operator=(const BakeReader&) = delete;

  const BakeInfo& info() const;
  /// `index` counts written frames from 0; state is empty.
  BakeFrame read(int index) const;
  /// The positions of one mesh alone, by its place in info().meshes.
  std::vector<Vec3> read_mesh(int index, int mesh) const;
  /// The values of a metric in all frames, by its place in info().metric_names.
  const std::vector<double>& metric(int metric) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew::sim
