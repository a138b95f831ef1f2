// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/peers/peer_runs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "tools/lab/paper/ball.h"

namespace thew::tools {
namespace {

double equator_of(const Points& x) {
  double most = 0.0;
  for (const Point& p : x) most = std::max(most, std::hypot(p[0], p[2]));
  return most;
}

double half_height(const Model& model, double time) {
  std::vector<double> joints;
  joints_at(model, time, joints);
  return kBallRadius - joints[find_body(model.skeleton, "top")];
}

}  // namespace

void note_volume(const Points& x, const Muscle& muscle, Outcome& out) {
  const double error =
      std::abs(enclosed_volume(x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
  out.stable = out.stable && error < 0.5;  // also where it is not a number
  out.volume_error = std::max(out.volume_error, error);
}

TriMesh geodesic_ball(int n) {
  const double g = 0.5 * (1.0 + std::sqrt(5.0));
  const std::vector<Vec3> corner = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                    {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                    {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  const std::vector<Triangle> faces = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                       {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                       {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                       {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  TriMesh mesh;
  std::map<std::array<long, 3>, int> known;  // faces share their rims
  const auto node = [&](const Triangle& f, int i, int j) {
    const Vec3 p = ((n - i - j) * corner[f[0]] + i * corner[f[1]] + j * corner[f[2]]).normalized() *
                   kBallRadius;
    const std::array<long, 3> key = {std::lround(p.x() * 1e9), std::lround(p.y() * 1e9),
                                     std::lround(p.z() * 1e9)};
    const auto [found, fresh] = known.try_emplace(key, static_cast<int>(mesh.vertices.size()));
    if (fresh) mesh.vertices.push_back(p);
    return found->second;
  };
  for (const Triangle& f : faces) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; i + j < n; ++j) {
        mesh.triangles.push_back({node(f, i, j), node(f, i + 1, j), node(f, i, j + 1)});
        if (i + j + 1 == n) continue;
        mesh.triangles.push_back({node(f, i + 1, j), node(f, i + 1, j + 1), node(f, i, j + 1)});
      }
    }
  }
  return mesh;
}

Outcome run_ours(const Model& model, const OnState& on_frame) {
  Outcome out;
  const Played played = play(model, settled_state(model), 0, [&](int frame, State& state) {
    for (int m = 0; m < state.count(); ++m) note_volume(state.muscles[m].x, model.muscles[m], out);
    if (on_frame) on_frame(frame, state);
  });
  out.milliseconds = played.milliseconds_a_frame(model);
  const StageSeconds& stages = played.stages;
  out.contact = stages.contact.cpu / (stages.rig.cpu + stages.contact.cpu + stages.muscles.cpu);
  return out;
}

Outcome run_our_ball(const Model& model) {
  Points held;
  Outcome out = run_ours(model, [&](int frame, State& state) {
    if (frame == kHalfHeight) held = state.muscles[0].x;
  });
  out.held = std::move(held);
  out.equator = equator_of(out.held);
  return out;
}

Outcome run_bullet_ball(const Model& model, const BulletSetting& setting) {
  Outcome out;
  const Muscle& ball = model.muscles[0];
  BulletBody body(ball.rest, ball.mass, ball.driven, setting);
  double seconds = 0.0;
  for (int f = model.first_frame + 1; f <= model.last_frame && out.stable; ++f) {
    const double begin = cpu_seconds();
    for (int s = 1; s <= setting.steps; ++s) {
      const double time = (f - 1 - model.first_frame + 1.0 * s / setting.steps) / model.fps;
      body.step(1.0 / (model.fps * setting.steps), half_height(model, time));
    }
    seconds += cpu_seconds() - begin;
    note_volume(body.positions(), ball, out);
    if (f == kHalfHeight) out.held = body.positions();
  }
  out.equator = equator_of(out.held);
  out.milliseconds = 1e3 * seconds / (model.last_frame - model.first_frame);
  return out;
}

std::string name_of(const BulletSetting& setting) {
  char text[80];
  std::snprintf(text, sizeof text, "Bullet, %d steps, kVC %g, kLST %g", setting.steps,
                setting.volume_stiffness, setting.link_stiffness);
  return text;
}

BestPeer most_accurate(int steps, const std::function<Outcome(const BulletSetting&)>& run) {
  BestPeer best;
  for (const double links : {0.01, 0.1, 1.0}) {
    bool held = false;  // too soft it collapses, too stiff it blows up
    for (const double stiffness : {1e4, 1e5, 1e6, 1e7, 3e7, 1e8, 2e8, 4e8, 8e8, 2e9}) {
      const BulletSetting setting{steps, stiffness, links};
      const Outcome outcome = run(setting);
      std::fprintf(stderr, "%s: %s%.2g, %.3g ms\n", name_of(setting).c_str(),
                   outcome.stable ? "" : "unstable ", outcome.volume_error, outcome.milliseconds);
      if (!outcome.stable && held) break;
      if (!outcome.stable) continue;
      held = true;
      if (outcome.volume_error < best.volume_error) best = {setting, outcome.volume_error};
    }
  }
  return best;
}

}  // namespace thew::tools
