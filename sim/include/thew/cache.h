// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "thew/mesh.h"

namespace thew {

/// One mesh of a bake: what does not change.
struct BakedMesh {
  enum class Kind { kMuscle, kBone, kSkin, kProp };
  std::string name;
  Kind kind = Kind::kMuscle;
  Mesh rest;                    ///< in the rest pose, a bone in its body's frame; the file's order
  std::vector<double> weights;  ///< of a muscle, by vertex: of the volume correction, mean 1
};
/// What a bake holds.
struct BakeContents {
  std::string scene;  ///< its name
  std::string hash;   ///< of all positions in double precision, 32 hex digits
  double fps = 24.0;
  std::vector<int> frames;            ///< numbers, rising
  std::vector<BakedMesh> meshes;      ///< by name
  std::vector<std::string> measures;  ///< names of what is stated of each frame
};

/// A baked scene, bake.h5, opened. One thread at a time uses it.
class Bake {
 public:
  /// Error(kInput) for what is not a cache of this version. Foreign bytes are parsed in a process
  /// of its own (import.h), which lives as long as this.
  explicit Bake(const std::filesystem::path& file);
  ~Bake();
  Bake(Bake&&) noexcept;
  Bake& operator=(Bake&&) noexcept;

  const BakeContents& contents() const;
  /// m, x, y, z of each vertex in world space, in the order of `rest`: one mesh in one frame, by
  /// its number; no other mesh is read. Error(kUsage) where there is no such mesh or frame.
  std::vector<double> positions(const std::string& mesh, int frame) const;
  /// By frame: the values of a measure such as "volume_error/flexor" (relative) or "length/flexor"
  /// (m). Error(kUsage) where there is none of the name.
  std::vector<double> measure(const std::string& name) const;

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew
