// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/lab/base/table.h"
#include "tools/lab/chart/run.h"

namespace thew::tools {

/// How a step of the skin is solved.
struct SkinSetting {
  int iterations = 1;
  int iterations_per_search = 1;  ///< for the flesh below, what comes through, and folds
  bool keeps_volume = false;

  bool operator==(const SkinSetting&) const = default;
};

/// The whole frame, muscles, contact and skin, by the setting of the skin. The muscles are solved
/// as the scene says. A point's errors are of the skin's vertices, its cost of the whole frame.
struct SkinChart {
  Chart chart;                        ///< no points: the scene has no skin
  std::vector<SkinSetting> settings;  ///< by point
  std::vector<double> flip;           ///< by point, of the worst picture; -1: none is drawn
  SkinSetting reference;              ///< what errors are against
  double known_mm = 0.0;  ///< largest distance of the reference from one of half its iterations
};

/// The scene's own setting first, then those worth a point: iterations, look-ups, and the volume
/// let go or held, which a character's own skin cannot.
std::vector<SkinSetting> skin_settings(const SkinSetting& own, bool is_layer);

/// "8 iterations, a search in 4, volume held".
std::string skin_setting_name(const SkinSetting& setting);

/// Runs them all. Pictures of the scene's first view of the skin are drawn in some frames, and
/// compared with the reference's by LDR-FLIP.
SkinChart run_skin_chart(const ChartAsk& ask);

Table points_of(const SkinChart& chart);
inline constexpr const char* kSkinError = "largest error of the skin, mm";  ///< its axis
/// Both as the end of the chart's page; "" without a skin.
std::string html_of(const SkinChart& chart);

}  // namespace thew::tools
