// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "tools/night/json_fields.h"
#include "tools/report/report.h"

namespace thew::tools {

/// The stages of Report::Seconds but the total, in the order in which pages show them.
inline constexpr std::array<const char*, 10> kStages = {
    "setup", "settle", "rig", "muscles", "contact", "skin", "measure", "write", "render", "report"};

enum class ShotState { kDone, kMissed, kUnfinished, kFailed, kUnreadable, kMissing };
/// As JSON says it.
inline constexpr std::array<const char*, 6> kShotStates = {"done",   "bound_missed", "unfinished",
                                                           "failed", "unreadable",   "missing"};

/// What a document of many bakes begins with.
inline constexpr const char* kNightFormat = "thew-night";

/// What changed since an earlier run.
struct ShotChange {
  enum class Way { kWorse, kBetter, kOther };
  std::string what, was, is;
  Way way = Way::kOther;
};

/// One bake of many: what its folder holds, in short.
struct NightShot {
  std::string name;              ///< its folder's path below that of all; what runs are matched by
  std::filesystem::path folder;  ///< absolute
  ShotState state = ShotState::kMissing;
  std::string why;    ///< it has no report that counts; "" where it has
  std::string again;  ///< the command that bakes it, "" where nothing says it
  int failed_frame = 0;
  int frames = 0, wanted_frames = 0;  ///< completed; to be baked

  // Of report.json.
  std::string scene, scene_hash, hash, date, integrator;
  std::vector<Report::Bound> bounds;
  std::vector<Report::Worst> worst;
  std::vector<Report::Rung> rungs;
  std::vector<Report::Swing> swings;
  std::vector<std::string> warnings;
  sim::Seconds total;
  std::array<sim::Seconds, kStages.size()> stages;

  std::vector<ShotChange> changes;

  bool has_report() const { return state == ShotState::kDone || state == ShotState::kMissed; }
  const Report::Bound* bound(const std::string& quantity) const;
  const Report::Worst* worst_of(const std::string& quantity) const;
  /// Frames of muscles in which something stood in; one that took smaller steps was solved.
  int rung_frames() const;
};

/// The bakes in and below some folders, by name, each once. A folder that is named and holds none
/// is a shot that is missing; what cannot be read is one that says so. Nothing is thrown for what a
/// folder holds.
std::vector<NightShot> find_shots(const std::vector<std::filesystem::path>& folders);

/// The folder that all these lie in, by which the shots in them are named.
std::filesystem::path common_folder(const std::vector<std::filesystem::path>& folders);

bool is_bake(const std::filesystem::path& folder);
NightShot read_shot(const std::filesystem::path& folder, const std::string& name);
/// A bake that is to be joined from these chunks and is not yet.
NightShot read_chunks(const std::filesystem::path& folder,
                      const std::vector<std::filesystem::path>& chunks, const std::string& name);
/// "12 bakes", "1 frame"
std::string counted(long number, const std::string& thing);

/// Bounds, rungs and seconds, which report.json and the JSON of a night have alike.
void read_figures(const JsonField& from, NightShot& shot);

}  // namespace thew::tools
