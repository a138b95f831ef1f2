// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/cache/own_files.h"
#include "sim/scene/scene.h"
#include "tools/render/renderer.h"
#include "tools/render/worker.h"

namespace thew::tools {

/// Views for a bake whose scene is not at hand: skin, muscles and weights, from the front and the
/// side, as near as shows all meshes of all frames.
std::vector<SceneView> views_of(const BakeReader& bake);

/// What draws: pictures of another version are drawn again.
std::string program_version();

/// The pictures of a bake, FOLDER/VIEW.####.png, listed in FOLDER (sim/cache/own_files.h) as of
/// "SET KEY". KEY: the meshes and the frame's positions, the view, the size, the program; a picture
/// of the same key whose bytes are those listed is kept, all others are drawn. SET: the bake with
/// view, size and program; pictures of the views that are of another one are removed.
/// They are drawn on one thread, which owns the GL context, and encoded on another, beside the
/// caller. What a frame finds and leaves is known after finish().
class Pictures {
 public:
  /// `bake` names what is drawn: the solver's hash, or a packed bake's. Nothing is touched before
  /// claim() or the first picture. Without views nothing is ever drawn. Views as of frame_views().
  Pictures(const std::filesystem::path& folder, const std::string& bake, int width, int height,
           const std::vector<SceneView>& views, const std::vector<BakeMesh>& meshes,
           const std::string& program = program_version());

  /// Error(kOutput) where something is in the way of these frames' pictures: sim/cache/own_files.h.
  void claim(const std::vector<int>& frames, bool overwrite) const;
  /// Keeps what is there of a frame and says which views are missing. Before any draw().
  std::vector<SceneView> keep(const BakeFrame& frame);
  /// Whether nothing was missing of any frame.
  bool complete() const { return complete_; }
  /// Has those drawn, and waits while kQueuedFrames are to be. Throws what a frame before failed
  /// of.
  void draw(const BakeFrame& frame);
  /// Those of some frames, view by view.
  std::vector<std::filesystem::path> files(const std::vector<int>& frames) const;
  /// Waits for the last file, and removes pictures of another bake, unless others draw in the
  /// folder too. Without it what was asked for is still drawn.
  void finish(bool alone = true);
  /// FOLDER/VIEW.mp4 of each view, where ffmpeg is installed and there is more than one frame; kept
  /// where it is of these very pictures. Says what went wrong, "" for nothing.
  std::string movies(const std::vector<int>& frames, double fps) const;
  /// Thumbnails of all views of some frames, as one picture.
  Image sheet(const std::vector<int>& frames) const;
  /// The frames of its thumbnails, row by row.
  std::vector<int> sheet_frames(const std::vector<int>& frames) const;
  int sheet_columns(const std::vector<int>& frames) const;
  std::filesystem::path sheet_file() const;
  /// Of all pictures that were drawn or kept; "" without views.
  std::string key() const;

  static constexpr std::size_t kQueuedFrames = 2, kQueuedImages = 8;

 private:
  void draw_missing(const BakeFrame& frame);
  std::filesystem::path file_of(const SceneView& view, int frame) const;
  std::filesystem::path movie_file(const SceneView& view) const;

  std::filesystem::path folder_;
  int width_, height_;
  std::vector<SceneView> views_;
  const std::vector<BakeMesh>& meshes_;
  std::string meshes_hash_;
  std::string program_;
  std::map<std::string, std::string> sets_;  ///< by view
  std::map<std::string, OwnFile> seen_;      ///< what the folder listed at first
  std::map<std::string, std::string> of_;    ///< by file, what was drawn or kept
  bool complete_ = true;
  std::unique_ptr<Renderer> renderer_;  ///< the drawing thread's, from the first picture on
  Worker writer_{kQueuedImages};
  Worker drawer_{kQueuedFrames};  ///< last, and so the first to end: it uses all of the others
};

}  // namespace thew::tools
