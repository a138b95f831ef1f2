// SPDX-License-Identifier: Apache-2.0
//
// The finite elements beside the paper's ball: linear ones as in print, neo-Hookean ones as truth.
#include <algorithm>
#include <cmath>

#include "sim/drive.h"
#include "tools/paper_ball.h"
#include "tools/peers/fem_ball.h"

namespace thew {
namespace {

constexpr double kShear = 1000.0, kPenalty = 1e5;    // Pa
constexpr double kDensity = 1060.0, kDamping = 2.0;  // as the scene's

// Where the upper plane is, m.
double plane_at(const Model& model, int frame) {
  std::vector<double> joints;
  joints_at(model, (frame - model.scene.first_frame) / model.scene.fps, joints);
  return kBallRadius - joints[find_body(model.skeleton, "top")];
}

FemRun run_linear(const Model& model, int tetrahedra, double penalty, int last) {
  FemRun run;
  FemBody body =
      linear_ball(model.muscles[0].rest, tetrahedra,
                  {.shear = kShear, .lambda = kShear, .penalty = penalty, .density = kDensity});
  run.elements = body.count();
  const double rest = fem_volume(body);
  run.volume.push_back(1.0);
  for (int frame = model.scene.first_frame + 1; frame <= last && !run.failed; ++frame) {
    FemStep step;
    step.h = 1.0 / model.scene.fps;
    step.damping = kDamping;
    step.high = plane_at(model, frame);
    step.low = -step.high;
    step.firmness = 1e4;
    step.iterations = 8;
    step.tolerance = 1e-4;
    const double begin = cpu_seconds();
    const FemResult result = solve_step(body, step);
    run.seconds += (cpu_seconds() - begin) / (last - model.scene.first_frame);
    run.iterations = std::max(run.iterations, result.iterations);
    run.inverted = std::max(run.inverted, result.inverted);
    const double ratio = fem_volume(body) / rest;
    run.failed = !std::isfinite(ratio) || !result.converged;
    run.volume.push_back(ratio);
    run.volume_error = std::max(run.volume_error, std::abs(ratio - 1.0));
    if (frame == kHalfHeight || frame == kReleased) run.kept[frame] = body.x;
  }
  return run;
}

// Nearly incompressible and stable neo-Hookean, on finer and finer meshes.
void squeeze_truth(PaperReport& report, BallElements& out) {
  for (int n = 4; n <= (report.quick ? 5 : 7); ++n) {
    out.rest.push_back(
        octant_ball(kBallRadius, n, {.neo_hookean = true, .shear = kShear, .penalty = 1e6}));
    FemBody body = out.rest.back();
    const FemResult result = squeeze_octant(body, kBallRadius, 0.5 * kBallRadius, 16);
    out.converged = result.converged && out.converged;
    out.squeezed.push_back(std::move(body));
    report.done();
  }
}

}  // namespace

BallElements run_elements(const PaperTimes& times, PaperReport& report) {
  BallElements out;
  squeeze_truth(report, out);
  for (size_t row = 0; row < times.balls.size(); ++row) {
    const PrintedBall& printed = kPrintedBalls[row];
    const bool large = printed.triangles > 5000, drawn = printed.triangles == 1766;
    const int last = large          ? (report.quick ? 2 : 6)
                     : report.quick ? (drawn ? kHalfHeight : 12)
                                    : kReleased;
    const Model& model = *times.balls[row].scenes[0].model;
    out.linear.push_back(run_linear(model, printed.tetrahedra, kPenalty, last));
    report.done();
  }
  const Model& smallest = *times.balls[0].scenes[0].model;
  for (double penalty : {1e4, 1e5, 1e6, 1e7, 1e8, 1e9}) {
    if (report.quick && penalty > 1e5) break;
    out.raised.emplace_back(penalty, run_linear(smallest, kPrintedBalls[0].tetrahedra, penalty,
                                                report.quick ? 12 : kHalfHeight));
    report.done();
    if (out.raised.back().second.failed) break;
  }
  return out;
}

}  // namespace thew
