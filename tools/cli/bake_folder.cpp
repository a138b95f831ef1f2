// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/bake_folder.h"

#include <algorithm>
#include <cstdio>

#include "sim/cache/cache_parts.h"
#include "sim/cache/durable_file.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

std::string frames_text(const std::vector<int>& frames) {
  std::string text = std::to_string(frames.front());
  if (frames.size() > 1) text += " to " + std::to_string(frames.back());
  return std::to_string(frames.size()) + (frames.size() == 1 ? " frame, " : " frames, ") + text;
}

// "" where they are the same bake.
std::string difference(const BakeInfo& there, const BakeInfo& wanted) {
  if (there.scene_name != wanted.scene_name) {
    return "the scene was \"" + there.scene_name + "\" and is \"" + wanted.scene_name + "\"";
  }
  if (there.scene_hash != wanted.scene_hash) {
    return "what the solver reads of the scene has changed (scene_hash was " + there.scene_hash +
           " and is " + wanted.scene_hash + ")";
  }
  if (there.frames != wanted.frames) {
    return "there are " + frames_text(there.frames) + ", and asked for are " +
           frames_text(wanted.frames);
  }
  if (there.double_precision == wanted.double_precision) return "";
  return std::string("output.precision was ") + (there.double_precision ? "double" : "single");
}

enum class Cache { kNone, kSame, kOther };

Cache look_at_cache(const fs::path& cache, const BakeInfo& wanted, std::string& differs) {
  std::error_code error;
  if (!fs::exists(cache, error)) return Cache::kNone;
  try {
    const BakeReader reader(cache);
    differs = difference(reader.info(), wanted);
    if (!differs.empty()) return Cache::kOther;
    for (size_t i = 0; i < wanted.frames.size(); ++i) reader.read(static_cast<int>(i));
    return Cache::kSame;
  } catch (const Error& broken) {
    if (broken.code() != ErrorCode::kInput) throw;
    std::fprintf(stderr, "thew: warning: %s; it is baked anew\n", broken.what());
    return Cache::kNone;
  }
}

// Whether a bake of `wanted` comes by all the frames that are listed.
bool are_of(const std::vector<int>& listed, const BakeInfo& wanted) {
  return listed.size() <= wanted.frames.size() &&
         std::equal(listed.begin(), listed.end(), wanted.frames.begin());
}

// Completed frames that a bake of `wanted` does not come by.
bool holds_another(const fs::path& parts, const BakeInfo& wanted) {
  const std::vector<int> listed = listed_frames(parts);
  try {
    return !listed.empty() && !(is_scene_of(parts, wanted) && are_of(listed, wanted));
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUsage) throw;
    return true;
  }
}

[[noreturn]] void refuse(const CommandOptions& options, const std::string& what) {
  throw Error(options.resume ? ErrorCode::kUsage : ErrorCode::kOutput, what);
}

// kAnew where there is no completed frame.
BakeStart look_at_parts(const CommandOptions& options, const BakeInfo& wanted) {
  const fs::path parts = options.out / "bake.parts";
  const std::vector<int> listed = listed_frames(parts);
  if (listed.empty() && !options.resume) return BakeStart::kAnew;
  try {
    if (!is_scene_of(parts, wanted)) {
      if (!listed.empty()) {
        std::fprintf(stderr,
                     "thew: warning: %s: does not say of what scene its frames are; they are baked "
                     "anew\n",
                     (parts / "bake.json").c_str());
      }
      return BakeStart::kAnew;
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kUsage) throw;
    refuse(options, error.what());
  }
  if (!are_of(listed, wanted)) {
    refuse(options, parts.string() + ": there are " + frames_text(listed) +
                        ", completed, and asked for are " + frames_text(wanted.frames) +
                        "; bake anew with --overwrite, or give another --out");
  }
  return BakeStart::kGoOn;
}

}  // namespace

BakeStart look_into_folder(const CommandOptions& options, const BakeInfo& wanted) {
  create_folders(options.out);
  const FolderLock lock(options.out);
  const fs::path cache = options.out / "bake.h5", parts = options.out / "bake.parts";
  claim({options.out / "report.json", options.out / "report.html", options.out / "failure.json"},
        options.overwrite);
  if (options.overwrite) {
    claim({cache}, true);
    check_replaceable(parts, fs::file_type::directory);
    list_own(parts);
  }
  claim_bake(options.out);
  if (options.overwrite && !options.resume) return BakeStart::kAnew;
  std::string differs;
  const Cache there = look_at_cache(cache, wanted, differs);
  if (there == Cache::kSame) {
    // Left where a kill came between packing and removing them; or of a bake that was to replace
    // this one, and then they stay.
    if (!holds_another(parts, wanted)) remove_parts(parts);
    return BakeStart::kComplete;
  }
  const BakeStart start = look_at_parts(options, wanted);
  if (start == BakeStart::kAnew && there == Cache::kOther) {
    refuse(options, cache.string() + ": is complete and of another bake: " + differs +
                        "; bake anew with --overwrite, or give another --out");
  }
  if (start == BakeStart::kGoOn && !options.resume) {
    std::fprintf(stderr, "thew: %s: goes on from %zu completed frames; --overwrite bakes anew\n",
                 options.out.c_str(), listed_frames(parts).size());
  }
  return start;
}

bool has_report(const fs::path& folder, const std::string& pictures) {
  const auto listed = own_file(folder / "report.html");
  return fs::exists(folder / "report.json") && fs::exists(folder / "report.html") &&
         (pictures.empty() || (listed && listed->of == pictures));
}

void list_report(const fs::path& folder, const std::string& pictures) {
  OwnFile about = own_file(folder / "report.html").value_or(OwnFile{});
  about.of = pictures;
  list_own(folder / "report.html", about);
}

}  // namespace thew::tools
