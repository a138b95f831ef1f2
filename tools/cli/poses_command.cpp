// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
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
void bake_poses(const Model& model, const std::vector<int>& frames, const CommandOptions& options,
                const fs::path& folder) {
  CommandOptions of_bake = options;
  of_bake.out = folder;
  const BakeOutput output{true, "", options.command, options.directory};
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

// What of the scene a set is made of: its frames and, where joints move it, their values by frame.
struct Asked {
  std::vector<int> frames;
  std::vector<std::vector<double>> joints;
};

Asked set_scene(const PoseRanges& ranges, Scene& scene) {
  if (moves_all_bodies(scene)) return {take_frames(ranges, scene), {}};
  const rig::Skeleton skeleton = build_model(scene).skeleton;
  Asked asked{{}, sample_poses(ranges, skeleton, scene)};
  set_poses(asked.joints, skeleton, scene);
  for (int frame = 1; frame <= scene.last_frame; ++frame) asked.frames.push_back(frame);
  return asked;
}

void warn_of(const PoseSet& set, const char* name, size_t poses, const char* what) {
  const auto array = std::find_if(set.arrays.begin(), set.arrays.end(),
                                  [&](const NamedArray& one) { return one.name == name; });
  const auto count = std::count_if(array->values.begin(), array->values.end(),
                                   [](double value) { return value > 0.0; });
  if (count == 0) return;
  std::fprintf(stderr, "thew: warning: in %ld of %zu poses %s\n", static_cast<long>(count), poses,
               what);
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
  const Asked asked = set_scene(ranges, scene);
  const Model model = build_model(scene);
  claim({options.out}, options.overwrite);
  fs::path folder = options.out;
  folder.replace_extension(".bake");
  bake_poses(model, asked.frames, options, folder);
  const BakeReader reader(folder / "bake.h5");
  const PoseSet set = make_pose_set(model, asked.joints, reader);
  if (ending == ".h5") sim::write_array_file(options.out, set.texts, set.arrays);
  if (ending == ".npz") write_npz(set, options.out);
  if (ending == ".glb") export_glb(choose_shot(reader, {"skin"}, ""), options.out, {});
  const size_t poses = asked.frames.size();
  warn_of(set, "rungs", poses,
          "a muscle could not be solved and something stands in; leave out those whose `rungs` are "
          "not 0");
  warn_of(set, "swings", poses,
          "a pinched muscle finds no rest; `swings` says by how many m its nodes swing");
  if (options.json) {
    print_json({{"file", options.out.string()}, {"poses", poses}, {"bake", folder.string()}});
  } else {
    print(options.out.string() + ": " + std::to_string(poses) + " poses\n");
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
