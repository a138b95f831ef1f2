// SPDX-License-Identifier: Apache-2.0
#include "tools/render/turntable.h"

#include <algorithm>
#include <cstdio>

#include "rig/math.h"
#include "sim/cache/durable_file.h"
#include "sim/framing.h"
#include "tools/base/signals.h"
#include "tools/render/frame_file.h"
#include "tools/render/movie.h"
#include "tools/render/renderer.h"
#include "tools/render/worker.h"

namespace thew::tools {

std::string draw_turntable(const BakeReader& bake, int frame, const SceneRender& render, int count,
                           const std::filesystem::path& folder, bool overwrite, ProgressStyle style,
                           std::vector<std::filesystem::path>& files) {
  const std::vector<int>& frames = bake.info().frames;
  const auto place = std::lower_bound(frames.begin(), frames.end(), frame) - frames.begin();
  const BakeFrame baked = bake.read(static_cast<int>(place));
  std::vector<std::vector<MoviePicture>> movies;
  std::vector<std::filesystem::path> claimed;
  for (const SceneView& view : render.views) {
    std::vector<MoviePicture>& pictures = movies.emplace_back();
    for (int i = 0; i < count; ++i) {
      pictures.push_back({frame_file(folder, view.name + "_turn", i + 1), 1});
      files.push_back(pictures.back().file);
    }
    claimed.push_back(folder / (view.name + "_turn.mp4"));
  }
  claimed.insert(claimed.end(), files.begin(), files.end());
  create_folders(folder);
  claim(claimed, overwrite);
  Renderer renderer(render.width, render.height, bake.info().meshes);
  Worker writer(8);
  Progress progress(style, "turning", count * static_cast<int>(render.views.size()), stderr);
  int done = 0;
  for (size_t v = 0; v < movies.size(); ++v) {
    SceneView view = view_at(render.views[v], frame);
    const Vec3 from = view.eye - view.target, axis = view.up.normalized();
    for (int i = 0; i < count; ++i) {
      view.eye = view.target + rotation_about(axis, 2.0 * kPi * i / count) * from;
      writer.add([file = movies[v][i].file, image = renderer.draw(view, baked.positions)] {
        write_png(file, image);
      });
      progress.step(++done, i + 1);
      stop_if_interrupted();
    }
  }
  writer.finish();
  std::string wrong;
  for (size_t v = 0; v < movies.size() && wrong.empty(); ++v) {
    wrong = write_movie(folder / (render.views[v].name + "_turn.mp4"), movies[v], bake.info().fps);
  }
  return wrong;
}

}  // namespace thew::tools
