// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/lab/related/methods.h"
#include "tools/lab/related/scenes.h"

namespace thew::tools {

/// A method in a scene at one dial and step.
struct RelatedRun {
  std::string method, dial;
  int steps = 1;              ///< a frame
  std::string failure;        ///< empty: it is stable, and the figures below hold
  double milliseconds = 0.0;  ///< CPU, a frame, one thread
  double volume_error = 0.0;  ///< |V/V0 - 1|, largest of all frames
  double volume_rate = 0.0;   ///< |dV/dx . v| / V0, 1/s, largest of all frames: what v asks for
  double distance = -1.0;     ///< mean, from the truth, share of the size; -1: no truth
  std::vector<Vec3> held;     ///< nodes of the surface in the last frame
};
/// Up to `frames` frames (0: all), given up where it takes longer than `patience` (s, CPU).
RelatedRun run_rival(const RelatedScene& scene, const RelatedMethod& method,
                     const RelatedDial& dial, int steps, int frames, double patience);
/// Thew itself, with the scene's own settings but for these; no iterations: the scene's.
struct ThewSetting {
  std::string name, integrator, volume;
  int iterations = 0;
  bool as_muscle = false;  ///< with its path
};
RelatedRun run_thew(const RelatedScene& scene, const ThewSetting& setting);
void judge(const RelatedScene& scene, const Truth& truth, RelatedRun& run);

/// All that is run of a method in a scene: at each dial the fewest steps that are stable (1, 2, 4
/// ...) and some times as many.
struct RelatedSweep {
  std::vector<RelatedRun> runs;
  /// Index of the run nearest to the truth, and of the cheapest; -1: none is stable.
  int best = -1, cheapest = -1;
  double largest_step = 0.0;  ///< s, that is stable at any dial
};
struct SweepAsk {
  int finer = 4;           ///< times the fewest steps
  double patience = 20.0;  ///< s a run
};
RelatedSweep sweep(const RelatedScene& scene, const RelatedMethod& method, const Truth* truth,
                   const SweepAsk& ask);

/// Of a free body let go from a crooked shape for a tenth of a second: what momentum it has gained
/// over the sum of the nodes' sizes of it, linear and angular, the larger.
double momentum_gained(const RelatedScene& scene, const RelatedMethod& method,
                       const RelatedDial& dial);
/// The force against a stretch that keeps the volume (to 0.8 along y), over that without what holds
/// the volume: 1 where the material stays what it was. -1: the method has no such part.
double stiffening(const RelatedScene& scene, const RelatedMethod& method, const RelatedDial& dial);

}  // namespace thew::tools
