// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/scene.h"

namespace thew {

/// How a scene's muscles are solved: the keys of [solver].
struct ChartSetting {
  std::string integrator, volume;
  int substeps = 1, iterations = 1;

  bool operator==(const ChartSetting&) const = default;
};
/// "local_global 1x3 exact": substeps x iterations; explicit ones take no iterations.
std::string setting_name(const ChartSetting& setting);

/// What a run of all frames cost and how far it was from the reference.
struct ChartPoint {
  ChartSetting setting;
  bool is_default = false;    ///< the scene's own
  bool on_front = false;      ///< none that is cheaper has a smaller largest error
  std::string failure;        ///< empty: it ran; the figures below are 0 where it did not
  double milliseconds = 0.0;  ///< CPU, a frame, one thread
  double largest_mm = 0.0, rms_mm = 0.0;  ///< over all nodes and frames
  double percent = 0.0;       ///< largest error over the diagonal of that muscle's rest box
  double volume_error = 0.0;  ///< |V/V0 - 1|, largest of frames and muscles
  double penetration_mm = 0.0;
};

struct Chart {
  std::string scene;
  int muscles = 0, nodes = 0, frames = 0;
  int timed_frames = 0, repetitions = 0;
  std::vector<ChartPoint> points;
  /// Coarser refined runs against the reference: their errors must fall. The last is the reference
  /// against itself. Not timed.
  std::vector<ChartPoint> references;
};

/// The table: the scene's own setting and all that are worth a point. `explicit_limit`: the most
/// substeps a frame that any of the muscles needs to be stable.
std::vector<ChartSetting> chart_settings(const Scene& scene, int explicit_limit);

struct ChartAsk {
  std::filesystem::path scene;
  int last = 0;     ///< frame; 0: the scene's own
  int threads = 1;  ///< settings run side by side; those timed never do
  int repetitions = 3;
  std::function<void(int done, int total)> on_step = [](int, int) {};
};
Chart run_chart(const ChartAsk& ask);

/// Indices of the points that no other beats in both numbers, by rising cost. Failed ones are none.
std::vector<std::size_t> pareto_front(const std::vector<ChartPoint>& points,
                                      double ChartPoint::*error);

}  // namespace thew
