// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "thew/scene.h"

namespace thew {

/// A scene in motion, frame by frame, without files. Each one is used by one thread at a time;
/// several do not disturb one another.
class Simulation {
 public:
  /// In the rest pose, before the first frame. The result does not depend on `threads`. A scene
  /// with a tolerance is planned first, which simulates parts of it. Error(kUsage) where that finds
  /// none.
  explicit Simulation(const Scene& scene, int threads = 1);
  ~Simulation();
  Simulation(Simulation&&) noexcept;
  Simulation& operator=(Simulation&&) noexcept;

  /// From the rest pose to the clip's first pose and to rest there: the first frame, as a bake has
  /// it. Does nothing the second time. Error(kSolver) where the solver cannot go on.
  void settle();
  /// To the next frame, after settle() where that was not called; returns its number. The clip is
  /// held beyond its end. With quasi_static each one is found by itself, from the rest pose on.
  /// Error(kSolver) names muscle, vertex and quantity; all stays as it was.
  int step();
  /// The same to a time in s, 0 at the first frame, in parts of a frame at most. Error(kUsage) for
  /// a time that is not later than now.
  void step_to(double time);

  /// s, 0 at the first frame; negative before it.
  double time() const;
  /// Of a mesh of SceneInfo::meshes now: m, x, y, z of each vertex in world space, in the order of
  /// its file or array. Error(kUsage) for another name, here and below.
  std::vector<double> positions(const std::string& mesh) const;
  /// Its triangles, which never change: three vertices each.
  std::vector<int> triangles(const std::string& mesh) const;
  /// By SceneInfo::joints: rad, or m for sliders.
  std::vector<double> joints() const;
  /// What a bake states of each frame, measured now: "volume_error/flexor" (relative),
  /// "length/flexor" (m), "contact_penetration" (m) and so on.
  std::map<std::string, double> measures();

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew
