// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/scene/scene.h"
#include "tools/render/image.h"

namespace thew::tools {

/// Draws meshes of a bake off-screen through OSMesa (GL 3.3). It knows caches, never the solver.
/// One thread at a time; the same input gives the same bytes on one machine and driver.
class Renderer {
 public:
  /// `meshes` live as long as they are drawn. Sizes 16..8192, otherwise Error(kUsage);
  /// Error(kOutput) where GL is not to be had.
  Renderer(int width, int height, const std::vector<BakeMesh>& meshes);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Other meshes and another size from here on; a new renderer would compile its shaders anew,
  /// which takes longer than most pictures.
  void show(int width, int height, const std::vector<BakeMesh>& meshes);
  /// The driver's name and version, as goldens record it.
  const std::string& driver() const;
  /// One view of one frame; positions by mesh. Error(kUsage) for a view that shows
  /// nothing known or looks nowhere.
  Image draw(const SceneView& view, const std::vector<std::vector<Vec3>>& positions);

 private:
  struct Data;
  std::unique_ptr<Data> data_;
};

}  // namespace thew::tools
