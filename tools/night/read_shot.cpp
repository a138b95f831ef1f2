// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fstream>
#include <numeric>

#include "sim/cache/cache_parts.h"
#include "tools/base/options.h"
#include "tools/night/shot.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBakeAgain = "bake it again, which writes it anew";

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

// A command line that works from anywhere.
std::string again(const JsonField& directory, const JsonField& command) {
  const std::string folder = directory.text();
  std::string called = command.text();
  if (folder.empty() || called.empty()) return called;
  const char* word = folder.c_str();
  return "cd " + command_text(1, &word) + " && " + called;
}

void read_report(NightShot& shot) {
  const JsonFile file = read_json_file(shot.folder / "report.json", kBakeAgain);
  const JsonField report(file);
  report["thew"].required().text();
  shot.scene = report["scene"].required().text();
  shot.hash = report["hash"].required().text();
  shot.frames = static_cast<int>(report["frames"].required().integers().size());
  shot.wanted_frames = shot.frames;
  shot.integrator = report["solver"]["integrator"].text();
  read_figures(report, shot);
  for (const JsonField& warning : report["warnings"].items()) {
    shot.warnings.push_back(warning.text());
  }
  const JsonField origin = report["origin"];
  shot.scene_hash = origin["scene_hash"].text();
  shot.date = origin["date"].text();
  shot.again = again(origin["directory"], origin["command"]);
  const bool met = std::all_of(shot.bounds.begin(), shot.bounds.end(),
                               [](const Report::Bound& bound) { return bound.met(); });
  shot.state = met ? ShotState::kDone : ShotState::kMissed;
}

// Completed frames of a bake that has not ended, or is still running.
void read_parts(NightShot& shot) {
  const fs::path parts = shot.folder / "bake.parts";
  shot.why = shot.has_report() ? "; the report is of a bake before it" : "";
  shot.state = ShotState::kUnfinished;
  shot.frames = static_cast<int>(sim::listed_frames(parts).size());
  const JsonFile file = read_json_file(parts / "bake.json", "bake it again");
  const JsonField about(file);
  shot.scene = about["scene"].text();
  shot.wanted_frames = std::max(shot.frames, about["frames"].integer());
  shot.again = again(about["directory"], about["command"]);
  if (!shot.again.empty() && shot.again.find(" --resume") == std::string::npos) {
    shot.again += " --resume";
  }
  shot.why = std::to_string(shot.frames) + " of " + std::to_string(shot.wanted_frames) +
             " frames are there: interrupted, or still running" + shot.why;
}

void read_failure(NightShot& shot) {
  const JsonFile file = read_json_file(shot.folder / "failure.json", "bake it again");
  const JsonField failure(file);
  shot.state = ShotState::kFailed;
  shot.why = failure["error"].required().text();
  shot.failed_frame = failure["frame"].integer();
  if (shot.scene.empty()) shot.scene = failure["scene"].text();
  const std::string called = again(failure["directory"], failure["command"]);
  if (!called.empty()) shot.again = called;
}

void read_folder(NightShot& shot) {
  const bool reported = is_there(shot.folder / "report.json");
  const bool partial = is_there(shot.folder / "bake.parts");
  const bool failed = is_there(shot.folder / "failure.json");
  if (reported) read_report(shot);
  if (partial) read_parts(shot);
  if (failed) read_failure(shot);
  if (reported || partial || failed) return;
  if (is_there(shot.folder / "bake.h5")) {
    shot.state = ShotState::kUnfinished;
    shot.why = "bake.h5 is there and report.json is not: bake it again, which writes it";
  } else {
    shot.why = is_there(shot.folder) ? "no bake is here" : "there is no such folder";
  }
}

}  // namespace

std::string counted(long number, const std::string& thing) {
  return std::to_string(number) + " " + thing + (number == 1 ? "" : "s");
}

bool is_bake(const fs::path& folder) {
  for (const char* name : {"bake.h5", "bake.parts", "failure.json"}) {
    if (is_there(folder / name)) return true;
  }
  std::ifstream file(folder / "report.json");
  std::string begin(64, ' ');  // where it is of a night, that stands first
  file.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return is_there(folder / "report.json") && begin.find(kNightFormat) == std::string::npos;
}

void read_figures(const JsonField& from, NightShot& shot) {
  for (const JsonField& one : from["bounds"].items()) {
    shot.bounds.push_back({one["quantity"].required().text(), one["measured"].required().number(),
                           one["limit"].required().number()});
  }
  for (const JsonField& one : from["worst"].items()) {
    shot.worst.push_back({one["quantity"].required().text(), one["measured"].required().number(),
                          one["frame"].integer(), one["part"].text()});
  }
  for (const JsonField& one : from["rungs"].items()) {
    shot.rungs.push_back({one["muscle"].text(), one["frames"].integers(), one["rung"].text(),
                          one["because"].text(), one["max_penetration_m"].number()});
  }
  for (const JsonField& one : from["swings"].items()) {
    Report::Swing swing{one["muscle"].text(), one["frames"].integers(), {}};
    for (const JsonField& value : one["swing_m"].items()) swing.swing_m.push_back(value.number());
    if (swing.frames.empty() || swing.swing_m.size() != swing.frames.size()) {
      one["swing_m"].refuse("not as long as its frames");
    }
    shot.swings.push_back(std::move(swing));
  }
  const JsonField wall = from["seconds"], cpu = from["cpu_seconds"];
  shot.total = {wall["total"].number(), cpu["total"].number()};
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    shot.stages[i] = {wall[kStages[i]].number(), cpu[kStages[i]].number()};
  }
}

NightShot read_shot(const fs::path& folder, const std::string& name) {
  NightShot shot;
  shot.name = name;
  shot.folder = folder;
  try {
    read_folder(shot);
  } catch (const Error& error) {
    shot.state = ShotState::kUnreadable;
    shot.why = error.what();
  }
  return shot;
}

NightShot read_chunks(const fs::path& folder, const std::vector<fs::path>& chunks,
                      const std::string& name) {
  NightShot shot;
  shot.name = name;
  shot.folder = folder;
  shot.state = ShotState::kUnfinished;
  shot.why = counted(static_cast<long>(chunks.size()), "chunk") + " not joined yet";
  for (const fs::path& chunk : chunks) {
    const NightShot part = read_shot(chunk, "");
    shot.frames += part.frames;
    shot.wanted_frames += part.wanted_frames;
    if (shot.scene.empty()) shot.scene = part.scene;
    const bool whole = part.state == ShotState::kUnfinished && part.frames == part.wanted_frames;
    if (whole || shot.state == ShotState::kFailed) continue;
    if (part.state == ShotState::kFailed) shot.state = part.state;
    shot.failed_frame = part.failed_frame;
    shot.why = chunk.filename().string() + " of " +
               counted(static_cast<long>(chunks.size()), "chunk") + ": " + part.why;
    shot.again = part.again;
  }
  return shot;
}

const Report::Bound* NightShot::bound(const std::string& quantity) const {
  const auto found = std::find_if(bounds.begin(), bounds.end(),
                                  [&](const auto& one) { return one.quantity == quantity; });
  return found == bounds.end() ? nullptr : &*found;
}

const Report::Worst* NightShot::worst_of(const std::string& quantity) const {
  const auto found = std::find_if(worst.begin(), worst.end(),
                                  [&](const auto& one) { return one.quantity == quantity; });
  return found == worst.end() ? nullptr : &*found;
}

int NightShot::rung_frames() const {
  return std::accumulate(rungs.begin(), rungs.end(), 0, [](int sum, const Report::Rung& rung) {
    return sum + (rung.rung == "substeps" ? 0 : static_cast<int>(rung.frames.size()));
  });
}

}  // namespace thew::tools
