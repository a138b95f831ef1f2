// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <future>
#include <map>
#include <vector>

#include "tools/lab/elements/fem.h"
#include "tools/lab/paper/report.h"

namespace thew::tools {

constexpr double kBallRadius = 0.1;              // m, of the scene
constexpr int kHalfHeight = 46, kReleased = 76;  // its frames

/// A row of table 1.
struct PrintedBall {
  int triangles, tetrahedra;
  double volume_preserving, conventional, fem;  ///< s a frame
};
constexpr PrintedBall kPrintedBalls[] = {{1470, 2691, 0.0016, 0.0013, 0.22},
                                         {1766, 3528, 0.0039, 0.0036, 0.63},
                                         {9800, 52633, 0.013, 0.0094, 2.59}};

/// Mass-spring runs of one ball: the scenes, and CPU seconds a frame of each.
struct TimedBall {
  enum { kNone, kLinear, kExact, kAlways, kImplicitNone, kImplicit, kFreeNone, kFreeExact };
  std::vector<PaperScene> scenes;
  std::vector<double> seconds;
};
struct PaperTimes {
  std::vector<TimedBall> balls;  ///< by row of table 1
  std::vector<double> cube;      ///< twisted: conventional, exact at frames, exact always
};
PaperTimes time_balls(PaperReport& report);

/// A ball of linear elements with the paper's penalty, squeezed as the scene's.
struct FemRun {
  double seconds = 0.0, volume_error = 0.0;  ///< CPU, a frame; largest |V/V0 - 1|
  int elements = 0, iterations = 0, inverted = 0;
  bool failed = false;
  std::vector<double> volume;             ///< V/V0 by frame
  std::map<int, std::vector<Vec3>> kept;  ///< nodes by frame
};
FemRun run_linear_ball(const Model& model, int tetrahedra, double penalty, int last);

/// An eighth of the ball, n elements along each edge, neo-Hookean, nearly incompressible: at rest
/// and held at half its height.
FemResult squeeze_true_ball(int n, FemBody& rest, FemBody& squeezed);
constexpr int kFinestTruth = 7;  ///< n

struct Distance {
  double mean = 0.0, largest = 0.0;  ///< shares of the radius
};
/// Of points of the first octant, or mirrored there, to the octant's surface.
Distance distance_to_octant(const std::vector<Vec3>& points, const FemBody& octant);
/// The surface's `count` nodes, in the middle: the ball's own drift is not counted.
std::vector<Vec3> centred(const std::vector<Vec3>& nodes, size_t count);

/// The yardsticks of the ball.
struct BallElements {
  /// An eighth of it, neo-Hookean, coarse to fine: at rest, and at half its height.
  std::vector<FemBody> rest, squeezed;
  bool converged = true;
  std::vector<FemRun> linear;                     ///< by row of table 1
  std::vector<std::pair<double, FemRun>> raised;  ///< by penalty, Pa, until it fails
};
/// Calls nothing of the report but done(), so it may run on a thread of its own.
BallElements run_elements(const PaperTimes& times, PaperReport& report);

/// Table 1, figures 7 and 8.
void paper_ball(const PaperTimes& times, std::future<BallElements>& elements, PaperReport& report);

}  // namespace thew::tools
