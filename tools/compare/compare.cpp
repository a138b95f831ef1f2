// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/compare.h"

#include <algorithm>
#include <mutex>
#include <set>

#include "rig/import/gltf_source.h"
#include "rig/limits.h"
#include "rig/text.h"
#include "sim/solver/parallel.h"
#include "tools/base/signals.h"
#include "tools/render/frame_file.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBake = "bake.h5";

enum class Side { kBake, kExport, kImage, kFolder };

Side side_of(const fs::path& path) {
  std::error_code error;
  if (fs::is_directory(path, error)) return Side::kFolder;
  if (!fs::exists(path, error)) {
    throw Error(ErrorCode::kInput, path.string() + ": " +
                                       (error ? error.message() : "no such file or folder") +
                                       "; give a bake.h5, a glTF, a PNG or a folder with them");
  }
  if (path.extension() == ".h5") return Side::kBake;
  if (names_gltf(path)) return Side::kExport;
  if (path.extension() == ".png") return Side::kImage;
  throw Error(ErrorCode::kInput, path.string() +
                                     ": neither a bake nor a glTF nor a picture; give a bake.h5, "
                                     "a .glb, .gltf or .vrm, a PNG or a folder with them");
}

// PNGs in a folder and below it; the contact sheet shows nothing that the others do not.
std::set<std::string> pictures_in(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path& file = entry.path();
    if (!entry.is_regular_file() || file.extension() != ".png") continue;
    if (file.filename() != "contact_sheet.png") names.insert(fs::relative(file, folder).string());
  }
  return names;
}

void compare_image(ImageComparison& image, const Image* mask, const PixelLimits& limits) {
  stop_if_interrupted();
  if (image.expected.empty() || image.actual.empty()) {
    image.fault = image.actual.empty() ? "missing" : "not expected";
    return;
  }
  const Image a = read_png(image.expected), b = read_png(image.actual);
  image.expected_renderer = a.renderer;
  image.actual_renderer = b.renderer;
  if (a.width != b.width || a.height != b.height) {
    const auto size = [](const Image& i) {
      return std::to_string(i.width) + " x " + std::to_string(i.height);
    };
    image.fault = "is " + size(b) + " pixels, expected " + size(a);
    return;
  }
  image.measures = measure_pixels(a, b, mask, limits.threshold);
  image.fault = broken_limit(image.measures, limits);
}

std::vector<ImageComparison> pair_folders(const fs::path& expected, const fs::path& actual,
                                          const std::vector<int>& frames) {
  const std::set<std::string> old = pictures_in(expected), now = pictures_in(actual);
  std::set<std::string> names = old;
  names.insert(now.begin(), now.end());
  std::vector<ImageComparison> images;
  for (const std::string& name : names) {
    ImageComparison image;
    image.name = name;
    image.view = fs::path(name).replace_extension().string();
    if (const auto read = read_frame_name(name)) {
      image.view = read->view;
      image.frame = read->frame;
    }
    const bool wanted =
        frames.empty() ||
        (image.frame && std::binary_search(frames.begin(), frames.end(), *image.frame));
    if (!wanted) continue;
    if (old.contains(name)) image.expected = expected / name;
    if (now.contains(name)) image.actual = actual / name;
    images.push_back(image);
  }
  return images;
}

GeometryComparison compare_bakes(const fs::path& expected, const fs::path& actual,
                                 const CompareOptions& options) {
  return compare_geometry(BakeReader(expected), BakeReader(actual), options.frames,
                          options.distance);
}

// A limit that is no number would let everything pass.
void check_limit(const char* option, double value, double least, double most) {
  if (value >= least && value <= most) return;
  throw Error(ErrorCode::kUsage, std::string(option) + " is " + number_text(value) +
                                     "; give a number from " + number_text(least) + " to " +
                                     number_text(most));
}

void check_limits(const CompareOptions& options) {
  const PixelLimits& pixels = options.limits;
  check_limit("--distance", 1e3 * options.distance, 0.0, 1e3 * kMaxCoordinate);
  check_limit("--share", pixels.share, 0.0, 1.0);
  check_limit("--rmse", pixels.rmse.value_or(0.0), 0.0, 255.0);
  check_limit("--ssim", pixels.ssim.value_or(0.0), -1.0, 1.0);
  check_limit("--flip", pixels.flip.value_or(0.0), 0.0, 1.0);
}

}  // namespace

int Comparison::different_images() const {
  return static_cast<int>(std::count_if(images.begin(), images.end(),
                                        [](const auto& image) { return !image.fault.empty(); }));
}

Comparison compare(const fs::path& expected, const fs::path& actual,
                   const CompareOptions& options) {
  check_limits(options);
  Comparison result{expected, actual, options.mask, {}, options.limits, {}};
  const Side side = side_of(expected);
  if (side != side_of(actual)) {
    throw Error(ErrorCode::kUsage,
                expected.string() + " and " + actual.string() +
                    " are not of one kind; give two bakes, two exports, two PNGs "
                    "or two folders");
  }
  if (side == Side::kBake) {
    result.geometry = compare_bakes(expected, actual, options);
  } else if (side == Side::kExport) {
    result.geometry =
        compare_exports(play_gltf(expected), play_gltf(actual), options.frames, options.distance);
  } else if (side == Side::kImage) {
    result.images.push_back(
        {expected.filename().string(), "", {}, expected, actual, "", "", "", {}});
  } else {
    const bool old = fs::exists(expected / kBake), now = fs::exists(actual / kBake);
    if (old && !now) {
      throw Error(ErrorCode::kInput, actual.string() + ": holds no bake.h5, as " +
                                         expected.string() + " does; was its bake interrupted?");
    }
    if (old) result.geometry = compare_bakes(expected / kBake, actual / kBake, options);
    result.images = pair_folders(expected, actual, options.frames);
    if (!old && result.images.empty()) {
      throw Error(ErrorCode::kInput, expected.string() + ": holds neither a bake.h5 nor PNGs" +
                                         (options.frames.empty() ? "" : " of the chosen frames") +
                                         "; give a folder that does");
    }
  }
  std::optional<Image> mask;
  if (!options.mask.empty()) mask = read_png(options.mask);
  const int count = static_cast<int>(result.images.size());
  Progress progress(count > 1 ? options.progress : ProgressStyle::kNone, "comparing", count,
                    stderr);
  std::mutex telling;
  int done = 0;
  Parallel(options.threads).each(count, [&](int i) {
    ImageComparison& image = result.images[i];
    compare_image(image, mask ? &*mask : nullptr, options.limits);
    const std::scoped_lock lock(telling);
    progress.step(++done, image.frame);
  });
  return result;
}

}  // namespace thew::tools
