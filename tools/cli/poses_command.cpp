// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>

#include "rig/text.h"
#include "sim/bake/bake.h"
#include "sim/cache/durable_file.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/base/signals.h"
#include "tools/cli/bake_folder.h"
#include "tools/cli/commands.h"
#include "tools/export/formats.h"
#include "tools/poses/pose_set.h"
#include "tools/poses/ranges.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

// Bakes the poses as frames into a folder beside the file, from which another format is written
// without solving them again.
void bake_poses(const Model& model, const CommandOptions& options, const fs::path& folder) {
  CommandOptions of_bake = options;
  of_bake.out = folder;
  std::vector<int> frames;
  for (int frame = model.first_frame; frame <= model.last_frame; ++frame) frames.push_back(frame);
  const BakeOutput output{true, ""};
  const BakeStart start = look_into_folder(of_bake, bake_info(model, frames, output));
  if (start == BakeStart::kComplete) return;
  Progress progress(progress_style(options), "posing", static_cast<int>(frames.size()), stderr);
  int done = 0;
  bake(model,
       {folder, frames, thread_count(options.threads), start == BakeStart::kGoOn, output,
        interrupted},
       [&](const BakeFrame& frame) {
         progress.step(++done, frame.frame);
         return !interrupted();
       });
}

int count_rungs(const PoseSet& set) {
  int count = 0;
  for (const double rung : set.arrays.back().values) count += rung > 0.0;
  return count;
}

}  // namespace

ExitCode poses_command(const CommandOptions& options) {
  const std::string ending = options.out.extension().string();
  if (ending != ".h5" && ending != ".npz" && ending != ".glb") {
    throw Error(ErrorCode::kUsage, options.out.string() +
                                       ": no format of poses has this ending; give .h5, .npz or "
                                       ".glb");
  }
  const PoseRanges ranges = read_ranges(options.input);
  Scene scene = read_scene(ranges.scene, options.overrides);
  const rig::Skeleton skeleton = build_model(scene).skeleton;
  const std::vector<std::vector<double>> poses = sample_poses(ranges, skeleton, scene);
  set_poses(poses, skeleton, scene);
  const Model model = build_model(scene);
  claim({options.out}, options.overwrite);
  fs::path folder = options.out;
  folder.replace_extension(".bake");
  bake_poses(model, options, folder);
  const BakeReader reader(folder / "bake.h5");
  const PoseSet set = make_pose_set(model, poses, reader);
  if (ending == ".h5") sim::write_array_file(options.out, set.texts, set.arrays);
  if (ending == ".npz") write_npz(set, options.out);
  if (ending == ".glb") export_glb(choose_shot(reader, {"skin"}, ""), options.out, 0);
  if (const int rungs = count_rungs(set)) {
    std::fprintf(stderr,
                 "thew: warning: in %d of %zu poses a muscle could not be solved and something "
                 "stands in; leave out those whose `rungs` are not 0\n",
                 rungs, poses.size());
  }
  if (options.json) {
    print_json(
        {{"file", options.out.string()}, {"poses", poses.size()}, {"bake", folder.string()}});
  } else {
    print(options.out.string() + ": " + std::to_string(poses.size()) + " poses\n");
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
