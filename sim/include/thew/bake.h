// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "thew/scene.h"

namespace thew {

/// Where a bake is.
struct BakeProgress {
  int frame = 0;  ///< that has been written
  int done = 0;   ///< how many have been
  int of = 0;     ///< how many are to be
};
struct BakeOptions {
  int threads = 1;  ///< the bytes do not depend on it
  /// Goes on from the frames that a bake of the same scene and frames has left here; a complete one
  /// is kept as it is, and one of another scene, complete or not, is Error(kUsage). False: what a
  /// bake has left here, complete or not, is replaced.
  bool resume = false;
  std::vector<int> frames = {};  ///< to be written, rising; empty: all of the scene
  /// After each written frame, those of an earlier bake included, in the thread that bakes. False
  /// ends the bake by Error(kRetry); its frames stay for `resume`. May throw, with the same effect.
  std::function<bool(const BakeProgress&)> progress = {};
};

/// Simulates the scene and writes each frame as it is completed, so that a kill loses one frame at
/// most. Returns the cache, FOLDER/bake.h5, which is complete where it stands. The folder is made.
/// The bytes are those of the command `thew bake`, from every compiler and processor.
/// Error: kSolver where the solver cannot go on (muscle, vertex, quantity, frame), kOutput for a
/// full disk or a file that is not Thew's, kRetry where another bake holds the folder, kUsage where
/// `resume` finds another scene's. Several may run in a process, each into a folder of its own.
std::filesystem::path bake(const Scene& scene, const std::filesystem::path& folder,
                           const BakeOptions& options = {});

}  // namespace thew
