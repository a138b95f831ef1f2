// SPDX-License-Identifier: Apache-2.0
#include "tools/night/night.h"

#include <algorithm>
#include <cstdlib>
#include <map>

#include "rig/text.h"
#include "rig/types.h"
#include "tools/base/text.h"

namespace thew::tools {

int Night::count(ShotState state) const {
  return static_cast<int>(std::count_if(
      shots.begin(), shots.end(), [&](const NightShot& shot) { return shot.state == state; }));
}

std::string Night::days() const {
  constexpr std::size_t kDay = 10;  // of 2026-11-25T08:00:00Z
  std::string first, last;
  for (const NightShot& shot : shots) {
    const std::string day = shot.date.substr(0, kDay);
    if (day.size() < kDay) continue;
    if (first.empty() || day < first) first = day;
    last = std::max(last, day);
  }
  return first == last ? first : first + " to " + last;
}

std::string state_text(ShotState state) {
  return in_words(kShotStates[static_cast<std::size_t>(state)]);
}

std::string what_is_wrong(const NightShot& shot) {
  if (shot.state != ShotState::kMissed) return shot.why;
  std::string text;
  for (const Report::Bound& bound : shot.bounds) {
    if (bound.met()) continue;
    const Report::Worst* worst = shot.worst_of(bound.quantity);
    text += (text.empty() ? "" : "; ") + in_words(bound.quantity) + " is " +
            quantity_text(bound.quantity, bound.measured) +
            (worst ? " in frame " + std::to_string(worst->frame) : "") + ", allowed " +
            quantity_text(bound.quantity, bound.limit);
  }
  return text;
}

std::vector<std::string> quantities_of(const Night& night) {
  static constexpr const char* kOrder[] = {"penetration", "poke_through", "volume_error",
                                           "substep_volume_error", "attachment_gap"};
  std::map<std::string, bool> seen;
  for (const NightShot& shot : night.shots) {
    for (const char* depth : {"penetration", "poke_through"}) {
      if (shot.worst_of(depth)) seen[depth];
    }
    for (const Report::Bound& one : shot.bounds) seen[one.quantity];
  }
  std::vector<std::string> names;
  for (const char* name : kOrder) {
    if (seen.erase(name) > 0) names.emplace_back(name);
  }
  for (const auto& [name, unused] : seen) names.push_back(name);
  return names;
}

std::string night_as_text(const Night& night) {
  std::string text = counted(static_cast<long>(night.shots.size()), "bake"), between = ": ";
  for (std::size_t i = 0; i < kShotStates.size(); ++i) {
    const auto state = static_cast<ShotState>(i);
    if (const int count = night.count(state)) {
      text += between + std::to_string(count) + " " + state_text(state);
      between = ", ";
    }
  }
  text += "\n";
  constexpr int kLines = 20;
  int bad = 0;
  for (const NightShot& shot : night.shots) {
    if (shot.state == ShotState::kDone || ++bad > kLines) continue;
    text += rig::printable(shot.name) + ": " + state_text(shot.state) + ": " +
            rig::printable(what_is_wrong(shot)) + "\n";
    if (!shot.has_report() && !shot.again.empty()) text += "  " + rig::printable(shot.again) + "\n";
  }
  if (bad > kLines) text += "and " + std::to_string(bad - kLines) + " more; --html has them all\n";
  return text;
}

std::vector<WorstFrame> worst_frames(const Night& night, std::size_t most) {
  std::vector<WorstFrame> all;
  for (const NightShot& shot : night.shots) {
    WorstFrame worst;
    worst.shot = &shot;
    const auto raise = [&](double rank, int frame, const std::string& part, std::string what) {
      if (rank > worst.rank) worst = {&shot, frame, rank, part, std::move(what)};
    };
    // Missed bounds come first, then failures, then what stood in for a solve or found no rest,
    // then how near a bound is, and last the depth (m) where nothing bounds it.
    constexpr double kMissed = 2e6, kFailed = 1e6, kRung = 1e3, kSwing = 10.0;
    if (shot.failed_frame != 0) {
      raise(kFailed, shot.failed_frame, "", "failed in frame " + std::to_string(shot.failed_frame));
    }
    for (const Report::Worst& one : shot.worst) {
      if (one.part.empty()) continue;
      const Report::Bound* bound = shot.bound(one.quantity);
      std::string what = in_words(one.quantity) + " " + quantity_text(one.quantity, one.measured);
      if (bound) what += " of " + quantity_text(one.quantity, bound->limit);
      what += ", frame " + std::to_string(one.frame) + ", " + in_words(one.part);
      const double ratio = bound && bound->limit > 0.0 ? one.measured / bound->limit
                           : bound                     ? 1e3
                           : one.quantity.find("error") == std::string::npos ? one.measured
                                                                             : 1e-9;
      raise(bound && !bound->met() ? kMissed + std::min(ratio, 1e5) : std::min(ratio, 1.0),
            one.frame, one.part, what);
    }
    for (const Report::Rung& rung : shot.rungs) {
      if (rung.frames.empty() || rung.rung == "substeps") continue;
      raise(kRung + static_cast<double>(rung.frames.size()), rung.frames[rung.frames.size() / 2],
            rung.muscle,
            in_words(rung.muscle) + " " + in_words(rung.rung) + ", frames " +
                frame_list(rung.frames, "–"));
    }
    for (const Report::Swing& swing : shot.swings) {
      const std::size_t at = swing.worst();
      raise(kSwing + swing.swing_m[at], swing.frames[at], swing.muscle,
            in_words(swing.muscle) + " swings by " + readable(1e3 * swing.swing_m[at]) +
                " mm, frame " + std::to_string(swing.frames[at]));
    }
    if (worst.rank > 0.0) all.push_back(std::move(worst));
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.rank > b.rank; });
  all.resize(std::min(all.size(), most));
  return all;
}

}  // namespace thew::tools
