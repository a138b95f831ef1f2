// SPDX-License-Identifier: Apache-2.0
#include "sim/api/scene_data.h"
#include "thew/bake.h"

namespace thew {
namespace {

// Whether the file is the whole of this bake; Error(kUsage) where it is the whole of another.
bool is_complete(const std::filesystem::path& file, const sim::BakeInfo& wanted) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return false;
  try {
    const sim::BakeReader reader(file);
    const sim::BakeInfo& there = reader.info();
    if (there.scene_name == wanted.scene_name && there.scene_hash == wanted.scene_hash &&
        there.frames == wanted.frames && there.double_precision == wanted.double_precision) {
      return true;
    }
    throw Error(ErrorCode::kUsage,
                file.string() +
                    ": is complete and of another scene, other frames or another "
                    "precision; bake into another folder, or anew to replace it");
  } catch (const Error& broken) {
    if (broken.code() != ErrorCode::kInput) throw;
    return false;  // it is baked anew
  }
}

}  // namespace

std::filesystem::path bake(const Scene& scene, const std::filesystem::path& folder,
                           const BakeOptions& options) {
  const SceneData& data = SceneData::of(scene);
  sim::BakeOptions inner;
  inner.folder = folder;
  inner.frames = options.frames;
  for (int frame = data.model.first_frame; options.frames.empty() && frame <= data.model.last_frame;
       ++frame) {
    inner.frames.push_back(frame);
  }
  inner.threads = options.threads;
  inner.resume = options.resume;
  inner.output = {data.double_precision, data.text};
  std::filesystem::path file = folder / "bake.h5";
  if (options.resume && is_complete(file, sim::bake_info(data.model, inner.frames, inner.output))) {
    return file;
  }
  BakeProgress progress;
  progress.of = static_cast<int>(inner.frames.size());
  sim::bake(data.model, inner, [&](const sim::BakeFrame& frame) {
    progress.frame = frame.frame;
    ++progress.done;
    return !options.progress || options.progress(progress);
  });
  return file;
}

}  // namespace thew
