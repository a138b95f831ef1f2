// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/measure.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/solver/muscle_step.h"
#include "tools/base/signals.h"

namespace thew::tools {
namespace {

constexpr int kMostSteps = 512, kMostImplicit = 16;  // a frame, that are tried
constexpr double kAtRest = 3.0;                      // sizes a second, of a node at the end

// Finite, and no farther off than three times what it was.
bool is_sound(const RivalBody& body) {
  double reach = 0.0;
  for (const Vec3& p : body.rest) reach = std::max(reach, p.norm());
  return std::all_of(body.x.begin(), body.x.end(),
                     [&](const Point& p) { return dot(p, p) < 9.0 * reach * reach; });
}

void note_frame(const RivalBody& body, double rest, Points& gradient, RelatedRun& run) {
  run.volume_error = std::max(run.volume_error, std::abs(volume_of(body) / rest - 1.0));
  volume_gradient(body.x, body.triangles, gradient);
  double rate = 0.0;
  for (size_t i = 0; i < body.x.size(); ++i) rate += dot(gradient[i], body.v[i]);
  run.volume_rate = std::max(run.volume_rate, std::abs(rate) / rest);
}

double fastest(const RivalBody& body, const Points& before, double seconds) {
  double most = 0.0;
  for (size_t i = 0; i < before.size(); ++i) {
    const Point d = body.x[i] - before[i];
    most = std::max(most, dot(d, d));
  }
  return std::sqrt(most) / seconds;
}

}  // namespace

RelatedRun run_rival(const RelatedScene& scene, const RelatedMethod& method,
                     const RelatedDial& dial, int steps, int frames, double patience) {
  RelatedRun run{method.name, dial.label, steps, "", 0.0, 0.0, 0.0, -1.0, {}};
  RivalBody body = body_of(scene, method.solid);
  const Stepper step = dial.make(body, kDrag);
  const double rest = volume_of(body), h = scene.frame_seconds() / steps;
  const int last = frames > 0 ? std::min(frames, scene.frames()) : scene.frames();
  double seconds = 0.0;
  Points gradient, before;
  for (int frame = 1; frame <= last; ++frame) {
    stop_if_interrupted();
    before = body.x;
    const double begin = cpu_seconds();
    for (int k = 1; k <= steps; ++k) {
      step(scene.around, (frame - 1) * scene.frame_seconds() + k * h, h, body);
    }
    seconds += cpu_seconds() - begin;
    if (!is_sound(body)) run.failure = "unstable";
    if (seconds > patience) run.failure = "given up";
    if (!run.failure.empty()) return run;
    note_frame(body, rest, gradient, run);
  }
  run.milliseconds = 1e3 * seconds / last;
  if (last < scene.frames()) return run;
  if (fastest(body, before, scene.frame_seconds()) > kAtRest * scene.size) {
    run.failure = "does not come to rest";
  }
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (body.surface[i] && !body.driven[i]) run.held.push_back(to_vec(body.x[i]));
  }
  return run;
}

RelatedRun run_thew(const RelatedScene& scene, const ThewSetting& setting) {
  RelatedRun run{setting.name, "", 1, "", 0.0, 0.0, 0.0, -1.0, {}};
  PaperAsk ask = setting.as_muscle ? *scene.as_muscle : scene.ours.ask;
  ask.overrides.push_back("solver.integrator=" + setting.integrator);
  ask.overrides.push_back("solver.volume=" + setting.volume);
  if (setting.iterations > 0) {
    ask.overrides.push_back("solver.iterations=" + std::to_string(setting.iterations));
    run.dial = std::to_string(setting.iterations) + " iterations";
  }
  const int last = scene.ours.model->last_frame;
  ask.keep = {last};
  try {
    const PaperRun found = run_scene(ask);
    const Muscle& muscle = found.model->muscles[0];
    const MuscleState& now = found.kept.at(last).muscles[0];
    run.milliseconds = 1e3 * found.seconds;
    run.volume_error = found.volume_error;
    if (setting.integrator == "explicit") {
      run.steps = explicit_substeps(*found.model, 0, scene.frame_seconds());
    }
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (!muscle.driven[i]) run.held.push_back(to_vec(now.x[i]));
    }
  } catch (const std::exception& error) {
    run.failure = error.what();
  }
  return run;
}

void judge(const RelatedScene& scene, const Truth& truth, RelatedRun& run) {
  if (!run.failure.empty() || run.held.empty()) return;
  std::vector<Vec3> nodes = run.held;
  if (!scene.held) {  // nothing holds it: its own drift is not counted
    const Vec3 centre = bounds_of(nodes).centre();
    for (Vec3& p : nodes) p -= centre;
  }
  run.distance = mean_distance(nodes, truth) / scene.size;
}

RelatedSweep sweep(const RelatedScene& scene, const RelatedMethod& method, const Truth* truth,
                   const SweepAsk& ask) {
  RelatedSweep out;
  const int most = method.implicit ? kMostImplicit : kMostSteps;
  for (const RelatedDial& dial : method.dials) {
    int steps = 1;
    RelatedRun run;
    for (;; steps *= 2) {
      run = run_rival(scene, method, dial, steps, 0, ask.patience);
      if (run.failure.empty() || run.failure == "given up" || steps >= most || !method.has_step) {
        break;
      }
    }
    if (truth) judge(scene, *truth, run);
    out.runs.push_back(run);
    if (!run.failure.empty()) continue;
    out.largest_step = std::max(out.largest_step, scene.frame_seconds() / steps);
    if (!method.has_step || ask.finer <= 1) continue;
    const int finer = method.implicit ? 2 : ask.finer;
    out.runs.push_back(run_rival(scene, method, dial, steps * finer, 0, ask.patience));
    if (truth) judge(scene, *truth, out.runs.back());
  }
  for (int k = 0; k < static_cast<int>(out.runs.size()); ++k) {
    const RelatedRun& run = out.runs[k];
    if (!run.failure.empty()) continue;
    if (out.best < 0 || run.distance < out.runs[out.best].distance) out.best = k;
    if (out.cheapest < 0 || run.milliseconds < out.runs[out.cheapest].milliseconds) {
      out.cheapest = k;
    }
  }
  return out;
}

double momentum_gained(const RelatedScene& scene, const RelatedMethod& method,
                       const RelatedDial& dial) {
  RivalBody body = body_of(scene, method.solid);
  std::fill(body.driven.begin(), body.driven.end(), 0);
  const Stepper step = dial.make(body, 0.0);
  const double size = scene.size;
  for (size_t i = 0; i < body.x.size(); ++i) {
    const Vec3& p = body.rest[i];
    body.x[i] = to_point(p + Vec3(-0.1 * p.x() + 0.2 * p.y() * p.y() / size, 0.1 * p.z(),
                                  0.15 * p.x() * p.y() / size));
  }
  const double h = 1e-4;
  double worst = 0.0;
  for (int k = 1; k <= 200; ++k) {
    step({}, k * h, h, body);
    if (k % 50) continue;
    double linear = 0.0, angular = 0.0;
    for (size_t i = 0; i < body.x.size(); ++i) {
      const double p = body.mass[i] * to_vec(body.v[i]).norm();
      linear += p;
      angular += p * to_vec(body.x[i]).norm();
    }
    const Momentum now = momentum_of(body);
    worst = std::max({worst, now.linear.norm() / linear, now.angular.norm() / angular});
  }
  return worst;
}

namespace {

constexpr double kStretch = 0.8;

Vec3 keeping_volume(double stretch) {
  const double side = 1.0 / std::sqrt(stretch);
  return {side, stretch, side};
}

// Virtual work of the forces at the stretched shape as it is stretched on, J.
double work_of(const RelatedScene& scene, bool solid,
               const std::function<Stepper(const RivalBody&, double)>& make) {
  RivalBody body = body_of(scene, solid);
  std::fill(body.driven.begin(), body.driven.end(), 0);
  const Stepper step = make(body, 0.0);
  const Vec3 stretch = keeping_volume(kStretch);
  const double h = 1e-5;
  for (size_t i = 0; i < body.x.size(); ++i) {
    body.x[i] = to_point(body.rest[i].cwiseProduct(stretch));
  }
  const Points before = body.x;
  step({}, h, h, body);
  double work = 0.0;
  for (size_t i = 0; i < body.x.size(); ++i) {
    const Vec3 force = body.mass[i] / (h * h) * to_vec(body.x[i] - before[i]);
    const double less = -0.5 * stretch.x() / kStretch;
    work += force.dot(body.rest[i].cwiseProduct(Vec3(less, 1.0, less)));
  }
  return work;
}

double work_of(const RelatedScene& scene, bool solid,
               const std::function<double(const RivalBody&, const Vec3&)>& energy) {
  const RivalBody body = body_of(scene, solid);
  const double d = 1e-4;
  return (energy(body, keeping_volume(kStretch - d)) - energy(body, keeping_volume(kStretch + d))) /
         (2.0 * d);
}

}  // namespace

double stiffening(const RelatedScene& scene, const RelatedMethod& method, const RelatedDial& dial) {
  if (dial.energy) {
    return work_of(scene, method.solid, dial.energy) /
           work_of(scene, method.solid, dial.bare_energy);
  }
  if (!dial.bare || !method.has_step) return -1.0;
  return work_of(scene, method.solid, dial.make) / work_of(scene, method.solid, dial.bare);
}

}  // namespace thew::tools
