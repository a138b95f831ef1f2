// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/temporary_folder.h"
#include "tools/cli/commands.h"
#include "tools/render/pictures.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 640, kHeight = 360;

// Both bakes in the frame in which they are farthest apart, seen alike.
std::vector<ImageComparison> draw_worst_frame(const Comparison& comparison,
                                              const fs::path& folder) {
  const GeometryComparison& geometry = *comparison.geometry;
  if (geometry.frames.empty() || geometry.meshes.empty()) return {};
  const MeshDistance& worst = geometry.meshes.front();
  const int frame = worst.largest > 0.0 ? worst.frame : geometry.frames.front();
  std::vector<SceneView> views;
  for (const auto& [name, file] : {std::make_pair("expected", comparison.expected),
                                   std::make_pair("actual", comparison.actual)}) {
    const BakeReader reader(fs::is_directory(file) ? file / "bake.h5" : file);
    if (views.empty()) views = views_of(reader);
    const auto& frames = reader.info().frames;
    const auto at = std::lower_bound(frames.begin(), frames.end(), frame) - frames.begin();
    std::vector<BakeMesh> meshes = reader.info().meshes;
    for (BakeMesh& mesh : meshes) mesh.coordinates.clear();  // fibres, which goldens do not keep
    Pictures pictures(folder / name, name, kWidth, kHeight, views, meshes);
    pictures.draw(reader.read(static_cast<int>(at)));
    pictures.finish();
  }
  CompareOptions options;
  options.limits = comparison.limits;
  return compare(folder / "expected", folder / "actual", options).images;
}

std::string page_of(Comparison comparison) {
  const auto& geometry = comparison.geometry;
  if (!geometry || !geometry->of_bakes || comparison.same() || !comparison.images.empty()) {
    return comparison_as_html(comparison);
  }
  const TemporaryFolder folder("compare");
  comparison.images = draw_worst_frame(comparison, folder.path());
  return comparison_as_html(comparison);
}

}  // namespace

ExitCode compare_command(const fs::path& expected, const fs::path& actual,
                         const CommandOptions& options, CompareOptions how) {
  if (!options.frames.empty()) how.frames = parse_frames(options.frames);
  how.threads = thread_count(options.threads);
  how.progress = progress_style(options);
  if (!options.out.empty()) claim({options.out}, options.overwrite);
  const Comparison comparison = compare(expected, actual, how);
  if (!options.out.empty()) write_durably(options.out, page_of(comparison));
  print(options.json ? comparison_as_json(comparison) + "\n" : comparison_as_text(comparison));
  return comparison.same() ? ExitCode::kDone : ExitCode::kDifferent;
}

}  // namespace thew::tools
