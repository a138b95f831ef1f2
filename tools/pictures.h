// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "sim/cache.h"
#include "sim/scene.h"
#include "tools/frame_writer.h"
#include "tools/renderer.h"

namespace thew {

/// Views for a bake whose scene is not at hand: skin, muscles and weights, from the front and the
/// side, so far away that all meshes of all frames are seen.
std::vector<SceneView> views_of(const BakeReader& bake);

/// The pictures of a bake, FOLDER/VIEW.####.png. Those of an earlier run are kept where bake and
/// views are the same (FOLDER/.drawn says of what they are).
class Pictures {
 public:
  /// `bake` names what is drawn: the solver's hash, or a packed bake's. Nothing is touched before
  /// the first picture is drawn. Without views nothing is ever drawn.
  Pictures(const std::filesystem::path& folder, const std::string& bake, int width, int height,
           const std::vector<SceneView>& views, const std::vector<BakeMesh>& meshes);

  /// Draws the views of a frame that are not there yet.
  void draw(const BakeFrame& frame);
  bool complete(const std::vector<int>& frames) const;
  /// Those of some frames, view by view.
  std::vector<std::filesystem::path> files(const std::vector<int>& frames) const;
  /// Waits for the last file, and takes away what a killed run left half written.
  void finish();
  /// FOLDER/VIEW.mp4 of each view, where ffmpeg is installed and there is more than one frame. Says
  /// what went wrong, "" for nothing.
  std::string movies(const std::vector<int>& frames, double fps) const;
  /// Thumbnails of all views of some frames, as one picture.
  Image sheet(const std::vector<int>& frames) const;
  double seconds() const { return seconds_; }

 private:
  void prepare();
  std::filesystem::path file_of(const SceneView& view, int frame) const;

  std::filesystem::path folder_;
  std::string drawn_;  ///< what .drawn holds for these pictures
  int width_, height_;
  std::vector<SceneView> views_;
  const std::vector<BakeMesh>& meshes_;
  std::unique_ptr<Renderer> renderer_;  ///< made when the first picture is drawn
  FrameWriter writer_;
  double seconds_ = 0.0;
};

}  // namespace thew
