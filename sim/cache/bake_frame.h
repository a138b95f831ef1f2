// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "rig/mesh.h"

namespace thew::sim {

/// What is constant of one mesh of a bake.
struct BakeMesh {
  enum class Kind { kMuscle, kBone, kSkin, kProp };
  std::string name;
  Kind kind = Kind::kMuscle;
  TriMesh rest;
  std::vector<double> weights;                     ///< muscles only
  std::vector<std::array<double, 3>> coordinates;  ///< muscles: u along the path 0..1, angle about
                                                   ///< it (rad), 1 in the belly to 0 in the tendon
  std::size_t line = 0;  ///< points of BakeFrame::lines; 0 of all but muscles with a path
};

/// The world transform of a body, the first three rows of its matrix: x = linear x_local +
/// translation.
using BodyFrame = std::array<double, 12>;

/// The character whose own mesh is the skin of a bake, so that an exporter can put the skin back
/// onto it.
struct BakeCharacter {
  std::string file;             ///< relative to the scene's folder
  double scale = 1.0;           ///< that multiplied all lengths of the file
  std::vector<BodyFrame> rest;  ///< by body of the file, where the skin has its rest positions;
                                ///< empty: there is no character
};

struct BakeInfo {
  std::string scene_name, scene_hash;
  /// These two serve a message that says what differs when another scene is resumed. They are not
  /// packed into bake.h5.
  std::string scene_text;
  std::vector<std::pair<std::string, std::string>> part_hashes;
  /// Nor are these: what was called, and in which folder, to be called again.
  std::string command, directory;
  double fps = 24.0;
  bool double_precision = false;
  std::vector<int> frames;  ///< that are written, ascending
  std::vector<BakeMesh> meshes;
  BakeCharacter character;
  std::vector<std::string> metric_names;  ///< scalars per frame, "volume_error/biceps_long", …
  std::string hash;                       ///< of a packed bake, as pack() returned it
};

struct BakeFrame {
  int frame = 0;
  std::vector<std::vector<Vec3>> positions;  ///< by mesh, double
  /// By mesh, m: of a muscle its line of action as carried, from origin to insertion, at even
  /// shares of its path at rest. Empty: no mesh of the bake has one.
  std::vector<std::vector<Vec3>> lines = {};
  std::vector<BodyFrame> bodies;  ///< m, as BakeCharacter::rest
  std::vector<double> metrics;    ///< by BakeInfo::metric_names
  std::vector<double> state;      ///< pack_state() after this frame, in some of the parts of a bake
};

/// A frame's line of action of mesh m; empty where it has none.
inline const std::vector<Vec3>& line_of(const BakeFrame& frame, std::size_t m) {
  static const std::vector<Vec3> kNone;
  return m < frame.lines.size() ? frame.lines[m] : kNone;
}

}  // namespace thew::sim
