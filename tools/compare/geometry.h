// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "tools/compare/played_gltf.h"

namespace thew::tools {

/// How far one mesh of two bakes is apart, node by node, in the frames that both have.
struct MeshDistance {
  std::string name;
  double largest = 0.0;          ///< m
  int frame = 0, node = 0;       ///< where the largest is
  double rms = 0.0;              ///< m, over all nodes and frames
  std::vector<double> by_frame;  ///< m, the largest
};

struct GeometryComparison {
  bool same_hash = false;            ///< of all positions in double precision, as the caches say
  bool exact = false;                ///< and nothing that was read differs by a bit
  bool rounded = false;              ///< one cache is of float32: the other was rounded alike
  bool of_bakes = true;              ///< else of exports, which know no hash and no scene
  bool same_scene = false;           ///< the solver was given the same
  double tolerance = 0.0;            ///< m, beyond which a node has moved
  std::vector<int> frames;           ///< compared
  std::vector<std::string> faults;   ///< all that is no distance: frames, meshes, topology, weights
  std::vector<MeshDistance> meshes;  ///< compared ones, those that moved most first

  bool same() const {
    return faults.empty() && (meshes.empty() || meshes.front().largest <= tolerance);
  }
};

/// m. More than the last digit of a float32 below a metre, so that a change in the order of sums
/// may pass; a stiffness changed by 1 % moves a muscle by more.
inline constexpr double kDistanceTolerance = 1e-7;

/// `frames`: those to be compared; empty: all.
GeometryComparison compare_geometry(const BakeReader& expected, const BakeReader& actual,
                                    const std::vector<int>& frames,
                                    double tolerance = kDistanceTolerance);

/// The same of two characters' exports as glTF, each as its first animation plays it: meshes by
/// their place in the file, their names, materials, texture coordinates and times too. A frame's
/// number is its time in frames where the file says how many a second has, else its place.
GeometryComparison compare_exports(const PlayedGltf& expected, const PlayedGltf& actual,
                                   const std::vector<int>& frames,
                                   double tolerance = kDistanceTolerance);

}  // namespace thew::tools
