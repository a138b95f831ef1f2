// SPDX-License-Identifier: Apache-2.0
//
// The JSON of a night, read again, and what changed since.
#include <algorithm>
#include <map>

#include "tools/base/text.h"
#include "tools/night/night.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;
using Way = ShotChange::Way;

ordered_json seconds_as_json(const NightShot& shot, double sim::Seconds::*clock) {
  ordered_json out = {{"total", shot.total.*clock}};
  for (std::size_t i = 0; i < kStages.size(); ++i) out[kStages[i]] = shot.stages[i].*clock;
  return out;
}

ordered_json figures_as_json(const NightShot& shot) {
  ordered_json bounds = ordered_json::array(), worst = bounds, rungs = bounds, swings = bounds;
  for (const Report::Bound& one : shot.bounds) {
    bounds.push_back({{"quantity", one.quantity},
                      {"measured", one.measured},
                      {"limit", one.limit},
                      {"met", one.met()}});
  }
  for (const Report::Worst& one : shot.worst) {
    worst.push_back({{"quantity", one.quantity},
                     {"measured", one.measured},
                     {"frame", one.frame},
                     {"part", one.part}});
  }
  for (const Report::Rung& one : shot.rungs) {
    rungs.push_back({{"muscle", one.muscle},
                     {"frames", one.frames},
                     {"rung", one.rung},
                     {"because", one.because},
                     {"max_penetration_m", one.max_penetration_m}});
  }
  for (const Report::Swing& one : shot.swings) {
    swings.push_back({{"muscle", one.muscle}, {"frames", one.frames}, {"swing_m", one.swing_m}});
  }
  return {{"bounds", bounds},
          {"worst", worst},
          {"rungs", rungs},
          {"swings", swings},
          {"warnings", shot.warnings},
          {"seconds", seconds_as_json(shot, &sim::Seconds::wall)},
          {"cpu_seconds", seconds_as_json(shot, &sim::Seconds::cpu)}};
}

const char* way_word(Way way) {
  return way == Way::kWorse ? "worse" : way == Way::kBetter ? "better" : "other";
}

ordered_json shot_as_json(const NightShot& shot) {
  ordered_json changes = ordered_json::array();
  for (const ShotChange& one : shot.changes) {
    changes.push_back(
        {{"what", one.what}, {"was", one.was}, {"is", one.is}, {"way", way_word(one.way)}});
  }
  ordered_json out = {{"name", shot.name},
                      {"folder", shot.folder.string()},
                      {"state", kShotStates[static_cast<std::size_t>(shot.state)]},
                      {"why", what_is_wrong(shot)},
                      {"again", shot.again},
                      {"scene", shot.scene},
                      {"scene_hash", shot.scene_hash},
                      {"hash", shot.hash},
                      {"integrator", shot.integrator},
                      {"date", shot.date},
                      {"frames", shot.frames},
                      {"frames_wanted", shot.wanted_frames},
                      {"changes", changes}};
  if (shot.failed_frame != 0) out["failed_frame"] = shot.failed_frame;
  out.update(figures_as_json(shot));
  return out;
}

NightShot read_earlier(const JsonField& from) {
  NightShot shot;
  shot.name = from["name"].required().text();
  shot.folder = from["folder"].text();
  const std::string state = from["state"].required().text();
  shot.state = static_cast<ShotState>(std::find(kShotStates.begin(), kShotStates.end() - 1, state) -
                                      kShotStates.begin());
  shot.again = from["again"].text();
  shot.scene_hash = from["scene_hash"].text();
  shot.hash = from["hash"].text();
  shot.date = from["date"].text();
  shot.frames = from["frames"].integer();
  read_figures(from, shot);
  return shot;
}

void note(NightShot& shot, const std::string& what, const std::string& was, const std::string& is,
          Way way) {
  if (was != is) shot.changes.push_back({what, was, is, way});
}

Way way_of(double was, double is) { return is > was ? Way::kWorse : Way::kBetter; }

// Where a bound is crossed, or its figure moved by a tenth of it and of what it was.
void compare_bounds(const NightShot& was, NightShot& shot) {
  constexpr double kShare = 0.1;
  for (const Report::Bound& now : shot.bounds) {
    const Report::Bound* then = was.bound(now.quantity);
    if (!then) {
      note(shot, "bound on " + in_words(now.quantity), "none",
           quantity_text(now.quantity, now.limit), Way::kOther);
      continue;
    }
    const double moved = std::abs(now.measured - then->measured);
    if (now.met() != then->met() ||
        (moved > kShare * then->measured && moved > kShare * now.limit)) {
      note(shot, in_words(now.quantity), quantity_text(now.quantity, then->measured),
           quantity_text(now.quantity, now.measured), way_of(then->measured, now.measured));
    }
    note(shot, "bound on " + in_words(now.quantity), quantity_text(now.quantity, then->limit),
         quantity_text(now.quantity, now.limit), Way::kOther);
  }
}

// Machines differ, and what else they do: less than a quarter, or than 5 s, is not told.
void compare_cost(const NightShot& was, NightShot& shot) {
  constexpr double kShare = 1.25, kLeast = 5.0;
  if (was.frames == 0 || shot.frames == 0) return;
  const double then = was.total.cpu / was.frames, now = shot.total.cpu / shot.frames;
  if (std::abs(now - then) * shot.frames < kLeast) return;
  if (now < kShare * then && then < kShare * now) return;
  note(shot, "cost a frame", readable(then) + " s", readable(now) + " s", way_of(then, now));
}

void compare_shot(const NightShot& was, NightShot& shot) {
  if (was.state != shot.state) {
    const bool better = shot.state == ShotState::kDone || (shot.has_report() && !was.has_report());
    const bool worse = was.state == ShotState::kDone || (was.has_report() && !shot.has_report());
    note(shot, "state", state_text(was.state), state_text(shot.state),
         better  ? Way::kBetter
         : worse ? Way::kWorse
                 : Way::kOther);
  }
  if (!shot.has_report() && shot.again.empty()) shot.again = was.again;
  if (!was.has_report() || !shot.has_report()) return;
  compare_bounds(was, shot);
  note(shot, "rungs", counted(was.rung_frames(), "frame"), counted(shot.rung_frames(), "frame"),
       way_of(was.rung_frames(), shot.rung_frames()));
  note(shot, "frames", std::to_string(was.frames), std::to_string(shot.frames), Way::kOther);
  compare_cost(was, shot);
  note(shot, "scene", was.scene_hash, shot.scene_hash, Way::kOther);
  note(shot, "positions", was.hash, shot.hash, Way::kOther);
}

}  // namespace

Night read_night(const std::filesystem::path& file) {
  const JsonFile read = read_json_file(file, "give the JSON that an earlier thew report wrote");
  const JsonField root(read);
  if (root["format"].text() != kNightFormat) {
    throw Error(ErrorCode::kInput, file.string() + ": is not of thew report; " + read.next);
  }
  Night night;
  for (const JsonField& shot : root["shots"].required().items()) {
    night.shots.push_back(read_earlier(shot));
  }
  return night;
}

void compare_with(const Night& before, Night& night) {
  night.compared = true;
  night.against = before.days();
  std::map<std::string, const NightShot*> then;
  std::map<std::string, std::string> names;  // by folder, where other folders were named
  for (const NightShot& shot : before.shots) {
    then[shot.name] = &shot;
    names[shot.folder.string()] = shot.name;
  }
  for (NightShot& shot : night.shots) {
    auto found = then.find(shot.name);
    if (found == then.end()) found = then.find(names[shot.folder.string()]);
    if (found == then.end()) {
      shot.changes.push_back({"new", "", state_text(shot.state), Way::kOther});
      continue;
    }
    compare_shot(*found->second, shot);
    then.erase(found);
  }
  for (const auto& [name, unused] : then) night.gone.push_back(name);
}

ordered_json night_as_json(const Night& night) {
  ordered_json shots = ordered_json::array(), bakes = {{"all", night.shots.size()}};
  NightShot sum;
  for (const NightShot& shot : night.shots) {
    shots.push_back(shot_as_json(shot));
    sum.total += shot.total;
    for (std::size_t i = 0; i < kStages.size(); ++i) sum.stages[i] += shot.stages[i];
    sum.frames += shot.frames;
  }
  for (std::size_t i = 0; i < kShotStates.size(); ++i) {
    bakes[kShotStates[i]] = night.count(static_cast<ShotState>(i));
  }
  ordered_json out = {{"format", kNightFormat},
                      {"version", 1},
                      {"thew", sim::kVersion},
                      {"name", night.name},
                      {"bakes", bakes},
                      {"frames", sum.frames},
                      {"seconds", seconds_as_json(sum, &sim::Seconds::wall)},
                      {"cpu_seconds", seconds_as_json(sum, &sim::Seconds::cpu)}};
  if (night.compared) out["against"] = {{"days", night.against}, {"gone", night.gone}};
  out["shots"] = std::move(shots);
  return out;
}

}  // namespace thew::tools
