// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sim/scene/model.h"
#include "sim/scene/scene.h"
#include "tools/lab/base/measures.h"

namespace thew::tools {

/// How a scene's muscles are solved: the keys of [solver].
struct ChartSetting {
  std::string integrator, volume;
  int substeps = 1, iterations = 1;

  bool operator==(const ChartSetting&) const = default;
};
/// "local_global 1x3 exact": substeps x iterations. Explicit ones take no iterations, quasi-static
/// ones no substeps and as many iterations as they need.
std::string setting_name(const ChartSetting& setting);

/// The scene's model, all muscles solved in this way.
Model solved_as(Scene scene, const ChartSetting& setting);

/// What the failure of a run begins with that was not begun, since it costs too much.
inline constexpr const char* kGivenUp = "given up: ";

/// What a run of all frames cost and how far it was from the reference.
struct ChartPoint {
  ChartSetting setting;
  std::string peer, label;    ///< where it is another's method: what it is, and which of them
  int colour = -1;            ///< of another's method; -1: by what it is
  bool is_default = false;    ///< the scene's own
  bool on_front = false;      ///< none that is cheaper has a smaller largest error
  std::string failure;        ///< empty: it ran; the figures below are 0 where it did not
  double milliseconds = 0.0;  ///< CPU, a frame, one thread
  double largest_mm = 0.0, rms_mm = 0.0;  ///< over all nodes and frames
  double own_mm = -1.0;       ///< largest from the same integrator's finest run; -1: it has none
  double percent = 0.0;       ///< largest error over the diagonal of that muscle's rest box
  double volume_error = 0.0;  ///< |V/V0 - 1|, largest of frames and muscles
  double penetration_mm = 0.0;
};
/// The setting's, or the peer's with its label.
std::string point_name(const ChartPoint& point);

/// An integrator against itself: each run halves the step of the one before it.
struct Refinement {
  std::string integrator, failure;     ///< failure: empty, or why there are no figures
  std::vector<ChartSetting> settings;  ///< from coarse to fine
  /// By setting but the last: mm to the next finer run, over all nodes and frames.
  std::vector<double> largest_mm, rms_mm;
  /// By setting but the last two: order of convergence, log2 of a difference over the next one.
  std::vector<double> order;
  double apart_mm = 0.0;  ///< of the finest run from the reference, largest
};

struct Chart {
  std::string scene;
  int muscles = 0, nodes = 0, frames = 0;
  int timed_frames = 0, repetitions = 0;
  std::vector<ChartPoint> points;
  ChartSetting reference;  ///< what errors are against: the finest of the first refinement
  std::vector<Refinement> refinements;
};

/// The steps by which each integrator is refined; the first is the reference's. `explicit_limit`:
/// the most parts of a frame that any of the muscles needs to be stable; `volume`: the scene's.
std::vector<Refinement> chart_refinements(int explicit_limit, const std::string& volume);

/// The table: the scene's own setting and all that are worth a point.
std::vector<ChartSetting> chart_settings(const Scene& scene);

struct ChartAsk {
  std::filesystem::path scene;
  int last = 0;     ///< frame; 0: the scene's own
  int threads = 1;  ///< settings run side by side; those timed never do
  int repetitions = 3;
  double longest_run = 40.0;  ///< s of CPU: what refines an integrator is given up beyond
  std::function<void(int done, int total)> on_step = [](int, int) {};
};
Chart run_chart(const ChartAsk& ask);

inline constexpr int kTimedFrames = 24;  ///< at most, the first ones: a run of all is not repeated

/// Times all points one after another, again and again, so that what disturbs one run disturbs all
/// alike, and sets the medians. `seconds_of` a point's run of the timed frames; of those without
/// failure alone. `on_run` follows each, timed or not.
void time_points(const std::function<double(std::size_t)>& seconds_of,
                 const std::function<void()>& on_run, Chart& chart);

using Frames = std::vector<std::vector<Points>>;  ///< nodes by frame and mesh
NodeDistance distance_of(const Frames& a, const Frames& b);

/// Indices of the points that no other beats in both numbers, by rising cost. Failed ones are none.
std::vector<std::size_t> pareto_front(const std::vector<ChartPoint>& points,
                                      double ChartPoint::*error);

}  // namespace thew::tools
