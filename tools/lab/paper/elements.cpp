// SPDX-License-Identifier: Apache-2.0
//
// The finite elements beside the paper's ball: linear ones as in print, neo-Hookean ones as truth.
#include <algorithm>
#include <cmath>

#include "sim/solver/drive.h"
#include "tools/lab/base/searched_mesh.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/ball.h"

namespace thew::tools {
namespace {

constexpr double kShear = 1000.0, kPenalty = 1e5;           // Pa
constexpr double kDensityOfFlesh = 1060.0, kDamping = 2.0;  // as the scene's

// Where the upper plane is, m.
double plane_at(const Model& model, int frame) {
  std::vector<double> joints;
  joints_at(model, (frame - model.first_frame) / model.fps, joints);
  return kBallRadius - joints[find_body(model.skeleton, "top")];
}

// On finer and finer meshes.
void squeeze_truth(PaperReport& report, BallElements& out) {
  for (int n = 4; n <= (report.quick ? 5 : kFinestTruth); ++n) {
    const FemResult result =
        squeeze_true_ball(n, out.rest.emplace_back(), out.squeezed.emplace_back());
    out.converged = result.converged && out.converged;
    report.done();
  }
}

}  // namespace

FemResult squeeze_true_ball(int n, FemBody& rest, FemBody& squeezed) {
  rest = octant_ball(kBallRadius, n, {.neo_hookean = true, .shear = kShear, .penalty = 1e6});
  squeezed = rest;
  return close_planes(kBallRadius, 0.5 * kBallRadius, 16, {}, squeezed);
}

Distance distance_to_octant(const std::vector<Vec3>& points, const FemBody& octant) {
  const SearchedMesh truth(octant_surface(octant));
  Distance out;
  for (const Vec3& point : points) {
    const Vec3 p = point.cwiseAbs();
    const double d = (truth.nearest(p, 1.0).point - p).norm() / kBallRadius;
    out.mean += d / points.size();
    out.largest = std::max(out.largest, d);
  }
  return out;
}

std::vector<Vec3> centred(const std::vector<Vec3>& nodes, size_t count) {
  const Vec3 centre = bounds_of(nodes, count).centre();
  std::vector<Vec3> out(nodes.begin(), nodes.begin() + count);
  for (Vec3& p : out) p -= centre;
  return out;
}

FemRun run_linear_ball(const Model& model, int tetrahedra, double penalty, int last) {
  FemRun run;
  FemBody body = linear_ball(
      model.muscles[0].rest, tetrahedra,
      {.shear = kShear, .lambda = kShear, .penalty = penalty, .density = kDensityOfFlesh});
  run.elements = body.count();
  const double rest = fem_volume(body);
  run.volume.push_back(1.0);
  for (int frame = model.first_frame + 1; frame <= last && !run.failed; ++frame) {
    FemStep step;
    step.h = 1.0 / model.fps;
    step.damping = kDamping;
    step.high = plane_at(model, frame);
    step.low = -step.high;
    step.firmness = 1e4;
    step.iterations = 8;
    step.tolerance = 1e-4;
    const double begin = cpu_seconds();
    const FemResult result = solve_step(body, step);
    run.seconds += (cpu_seconds() - begin) / (last - model.first_frame);
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
    out.linear.push_back(run_linear_ball(model, printed.tetrahedra, kPenalty, last));
    report.done();
  }
  const Model& smallest = *times.balls[0].scenes[0].model;
  for (double penalty : {1e4, 1e5, 1e6, 1e7, 1e8, 1e9}) {
    if (report.quick && penalty > 1e5) break;
    out.raised.emplace_back(penalty, run_linear_ball(smallest, kPrintedBalls[0].tetrahedra, penalty,
                                                     report.quick ? 12 : kHalfHeight));
    report.done();
    if (out.raised.back().second.failed) break;
  }
  return out;
}

}  // namespace thew::tools
