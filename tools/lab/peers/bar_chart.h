// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/lab/base/table.h"
#include "tools/lab/elements/fem_bar.h"

namespace thew::tools {

/// A quarter of the bar, neo-Hookean, nearly incompressible: at rest, and squeezed.
struct TrueBar {
  FemBody rest, squeezed;
  FemResult result;
};
/// n elements from the axis to the surface; of fewer than 3 only the first figure is right.
TrueBar squeeze_true_bar(const BarShape& shape, int n);

/// A run of `bar.toml` at its last frame, and how far it is from the true one.
struct BarRun {
  double milliseconds = 0.0;                    ///< CPU, a frame; the median of `repetitions`
  double volume_error = 0.0, zone_error = 0.0;  ///< at any frame; at the last
  double free_half = 0.0;                       ///< V/V0 - 1 of its half x > 0
  double mean = 0.0, largest = 0.0;             ///< m, of the nodes that are not held
  double squeezed_mean = 0.0, free_mean = 0.0;  ///< m, of those of either half
  int nodes = 0, frames = 0;
  int zone_fallbacks = 0;  ///< in the last frame
};
std::vector<BarRun> run_bars(const std::filesystem::path& scene,
                             const std::vector<std::vector<std::string>>& overrides,
                             int repetitions, const TrueBar& truth);

/// m^3 within the surface of the half x > 0 at rest, of the bar or of a quarter of it: its rim
/// closed by a cone to the axis, amid the rim.
double free_half(const TriMesh& rest, const std::vector<Vec3>& x);

/// Both bars of `assets/paper` by one multiplier and by zones. Writes two_bellies.svg, spindle.svg
/// (cost against the mean distance from the neo-Hookean one) and bar.csv into the folder, and
/// pictures where rsvg-convert is installed. The rows of bar.csv.
Table draw_bar_chart(const std::filesystem::path& out);

}  // namespace thew::tools
