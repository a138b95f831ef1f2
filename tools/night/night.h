// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "tools/night/shot.h"

namespace thew::tools {

/// All bakes of a run, and what changed since an earlier one.
struct Night {
  std::string name;  ///< of the folder that all lie in
  std::vector<NightShot> shots;
  bool compared = false;
  std::string against;            ///< the days of the bakes of the earlier run
  std::vector<std::string> gone;  ///< bakes of the earlier run that this one has not

  int count(ShotState state) const;
  bool is_good() const { return count(ShotState::kDone) == static_cast<int>(shots.size()); }
  std::string days() const;  ///< "2026-11-24 to 2026-11-25", "" where no bake says its date
};

/// The JSON of an earlier run, as far as it is compared. Error(kInput).
Night read_night(const std::filesystem::path& file);
/// Notes what differs in each bake from that of the same name in `before`. A bake that failed and
/// does not say by which command it is baked is given the one that it had then.
void compare_with(const Night& before, Night& night);

nlohmann::ordered_json night_as_json(const Night& night);
/// A line for all, and one for each bake that is not good.
std::string night_as_text(const Night& night);
/// One file that needs no other. Links lead from `folder`, where the page will lie, to the reports.
std::string night_as_html(const Night& night, const std::filesystem::path& folder);

/// The quantities that any scene bounds, and the depths that any bake states, in the order of the
/// columns.
std::vector<std::string> quantities_of(const Night& night);
/// What one state is called, and what is wrong with such a bake: "failed: ...".
std::string state_text(ShotState state);
std::string what_is_wrong(const NightShot& shot);

/// The worst frame of a bake, for a picture of it.
struct WorstFrame {
  const NightShot* shot = nullptr;
  int frame = 0;
  double rank = 0.0;  ///< the higher the worse
  std::string part, what;
};
/// Of all bakes the worst frames first, one a bake, at most so many.
std::vector<WorstFrame> worst_frames(const Night& night, std::size_t most);
/// Its picture as HTML, embedded and small; "" where there is none.
std::string thumbnail(const WorstFrame& worst);

}  // namespace thew::tools
