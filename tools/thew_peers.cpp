// SPDX-License-Identifier: Apache-2.0
//
// thew_peers ARM.toml: Debian's Bullet soft body beside our muscles, on the same meshes, masses and
// motion in one run, as one JSON object. CPU milliseconds a frame of one thread, medians of
// interleaved runs.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "muscles/volume.h"
#include "sim/drive.h"
#include "sim/step.h"
#include "tools/commands.h"
#include "tools/options.h"
#include "tools/paper_run.h"
#include "tools/paper_shapes.h"
#include "tools/peers/bullet_body.h"

namespace thew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kRadius = 0.1;  // m, of the ball
constexpr int kRuns = 3;

/// Of one run of all frames.
struct Outcome {
  double milliseconds = 0.0, volume_error = 0.0;  ///< CPU, a frame; largest |V/V0 - 1| at frames
  double equator = 0.0;                           ///< of the ball held at half its height, m
  double contact = 0.0;                           ///< share of the time that finding contacts took
  bool stable = true;
};

void note_volume(const Rows& x, const Muscle& muscle, Outcome& out) {
  const double error =
      std::abs(enclosed_volume(x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
  out.stable = out.stable && error < 0.5;  // also where it is not a number
  out.volume_error = std::max(out.volume_error, error);
}

double equator_of(const Rows& x) {
  double most = 0.0;
  for (const Row& p : x) most = std::max(most, std::hypot(p[0], p[2]));
  return most;
}

// Icosahedron, each edge in n parts, on the sphere: 10 n^2 + 2 nodes.
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
    const Vec3 p =
        ((n - i - j) * corner[f[0]] + i * corner[f[1]] + j * corner[f[2]]).normalized() * kRadius;
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

using OnFrame = std::function<void(int frame, const State& state)>;

Outcome run_ours(const Model& model, const OnFrame& on_frame) {
  Outcome out;
  const Scene& scene = model.scene;
  Parallel one(1);
  StageSeconds stages;
  State state = initial_state(model);
  settle(model, one, state);
  double seconds = 0.0;
  for (int f = scene.first_frame + 1; f <= scene.last_frame; ++f) {
    const double begin = cpu_seconds();
    step_frame(model, (f - scene.first_frame) / scene.fps, one, state, stages);
    seconds += cpu_seconds() - begin;
    for (int m = 0; m < state.count(); ++m) note_volume(state.muscles[m].x, model.muscles[m], out);
    on_frame(f, state);
  }
  out.milliseconds = 1e3 * seconds / (scene.last_frame - scene.first_frame);
  out.contact = stages.contact / (stages.rig + stages.contact + stages.muscles);
  return out;
}

double half_height(const Model& model, double time) {
  std::vector<double> joints;
  joints_at(model, time, joints);
  return kRadius - joints[find_body(model.skeleton, "top")];
}

constexpr int kHeld = 46;  // frame of the ball's scene

Outcome run_bullet_ball(const Model& model, const BulletSetting& setting) {
  Outcome out;
  const Muscle& ball = model.muscles[0];
  BulletBody body(ball.rest, ball.mass, ball.driven, setting);
  const Scene& scene = model.scene;
  double seconds = 0.0;
  for (int f = scene.first_frame + 1; f <= scene.last_frame && out.stable; ++f) {
    const double begin = cpu_seconds();
    for (int s = 1; s <= setting.steps; ++s) {
      const double time = (f - 1 - scene.first_frame + 1.0 * s / setting.steps) / scene.fps;
      body.step(1.0 / (scene.fps * setting.steps), half_height(model, time));
    }
    seconds += cpu_seconds() - begin;
    note_volume(body.positions(), ball, out);
    if (f == kHeld) out.equator = equator_of(body.positions());
  }
  out.milliseconds = 1e3 * seconds / (scene.last_frame - scene.first_frame);
  return out;
}

// Targets of the held nodes by frame and muscle, from our own run.
using Targets = std::vector<std::vector<Rows>>;

Outcome run_bullet_arm(const Model& model, const Targets& targets, const BulletSetting& setting) {
  Outcome out;
  std::vector<std::unique_ptr<BulletBody>> bodies;
  for (const Muscle& muscle : model.muscles) {
    bodies.push_back(
        std::make_unique<BulletBody>(muscle.rest, muscle.mass, muscle.driven, setting));
  }
  double seconds = 0.0;
  for (size_t f = 1; f < targets.size() && out.stable; ++f) {
    const double begin = cpu_seconds();
    for (size_t m = 0; m < bodies.size(); ++m) {
      for (int s = 1; s <= setting.steps; ++s) {
        const double t = 1.0 * s / setting.steps;
        for (size_t i = 0; i < model.muscles[m].driven.size(); ++i) {
          if (!model.muscles[m].driven[i]) continue;
          const Row before = targets[f - 1][m][i];
          bodies[m]->hold(static_cast<int>(i), before + t * (targets[f][m][i] - before));
        }
        bodies[m]->step(1.0 / (model.scene.fps * setting.steps));
      }
    }
    seconds += cpu_seconds() - begin;
    for (size_t m = 0; m < bodies.size(); ++m) {
      note_volume(bodies[m]->positions(), model.muscles[m], out);
    }
  }
  out.milliseconds = 1e3 * seconds / (targets.size() - 1.0);
  return out;
}

Json json_of(const std::string& name, const Outcome& outcome) {
  Json out = {{"setting", name},
              {"cpu_ms_per_frame", outcome.milliseconds},
              {"volume_error", outcome.volume_error}};
  if (outcome.contact > 0.0) out["share_of_finding_contacts"] = outcome.contact;
  if (outcome.equator > 0.0) out["equator_mm_at_half_height"] = 1e3 * outcome.equator;
  return out;
}

std::string name_of(const BulletSetting& setting) {
  char text[80];
  std::snprintf(text, sizeof text, "Bullet, %d steps, kVC %g, kLST %g", setting.steps,
                setting.volume_stiffness, setting.link_stiffness);
  return text;
}

// Bullet's most accurate stable setting of a grid; stiffer than the first that is unstable is too.
template <typename Run>
BulletSetting most_accurate(const Run& run) {
  BulletSetting best;
  double least = 1e300;
  for (const int steps : {5, 10, 20}) {
    for (const double links : {0.01, 0.1, 1.0}) {
      for (const double stiffness : {1e7, 3e7, 1e8, 2e8, 4e8, 8e8, 2e9}) {
        const BulletSetting setting{steps, stiffness, links};
        const Outcome outcome = run(setting);
        std::fprintf(stderr, "%s: %s%.2g, %.3g ms\n", name_of(setting).c_str(),
                     outcome.stable ? "" : "unstable ", outcome.volume_error, outcome.milliseconds);
        if (!outcome.stable) break;
        if (!(outcome.volume_error < least)) continue;
        least = outcome.volume_error;
        best = setting;
      }
    }
  }
  return best;
}

// Interleaved; the medians.
void time_all(const std::vector<std::function<Outcome()>>& runs, std::vector<Outcome>& outcomes) {
  std::vector<std::vector<double>> times(runs.size());
  outcomes.resize(runs.size());
  for (int r = 0; r < kRuns; ++r) {
    for (size_t k = 0; k < runs.size(); ++k) {
      outcomes[k] = runs[k]();
      times[k].push_back(outcomes[k].milliseconds);
    }
  }
  for (size_t k = 0; k < runs.size(); ++k) outcomes[k].milliseconds = median(times[k]);
}

Json compare(const BulletSetting& peer, const std::function<Outcome()>& run_peer,
             const std::vector<std::pair<std::string, std::function<Outcome()>>>& ours) {
  std::vector<std::function<Outcome()>> runs = {run_peer};
  for (const auto& [name, run] : ours) runs.push_back(run);
  std::vector<Outcome> outcomes;
  time_all(runs, outcomes);
  Json out;
  out["peer"] = json_of(name_of(peer), outcomes[0]);
  for (size_t k = 0; k < ours.size(); ++k) {
    Json one = json_of(ours[k].first, outcomes[k + 1]);
    one["times_as_fast"] = outcomes[0].milliseconds / outcomes[k + 1].milliseconds;
    out["ours"].push_back(one);
  }
  return out;
}

Json compare_ball(const fs::path& folder, int parts) {
  TriMesh mesh = geodesic_ball(parts);
  write_obj(folder / "geodesic.obj", "ball", mesh);
  const auto ours = [&](const std::vector<std::string>& more) {
    std::vector<std::string> overrides = {"muscle.ball.mesh=geodesic.obj"};
    overrides.insert(overrides.end(), more.begin(), more.end());
    return build_model(read_scene(folder / "ball.toml", overrides));
  };
  std::vector<std::pair<std::string, std::function<Outcome()>>> runs;
  for (const char* young : {"1000", "30"}) {  // Bullet has no such figure: its links are a share
    const std::string material = std::string("muscle.ball.material.young=") + young;
    for (const std::string integrator : {"explicit", "local_global"}) {
      if (integrator == "local_global" && parts > 10) continue;  // minutes, and no faster there
      const Model model =
          ours({material, "solver.integrator=" + integrator, "solver.iterations=1"});
      runs.emplace_back(integrator + ", " + young + " N/m", [model] {
        double equator = 0.0;
        Outcome out = run_ours(model, [&](int f, const State& state) {
          if (f == kHeld) equator = equator_of(state.muscles[0].x);
        });
        out.equator = equator;
        return out;
      });
    }
  }
  const Model model = ours({});
  const auto peer = [&](const BulletSetting& setting) { return run_bullet_ball(model, setting); };
  const BulletSetting best = most_accurate(peer);
  Json out = {{"nodes", mesh.vertices.size()}};
  out.update(compare(
      best, [&] { return peer(best); }, runs));
  return out;
}

Json compare_arm(const std::string& scene) {
  const Model model =
      build_model(read_scene(scene, {"skin.enabled=false", "contact.enabled=false"}));
  Targets targets;
  const auto keep = [&](int, const State& state) {
    std::vector<Rows>& rows = targets.emplace_back();
    for (const MuscleState& muscle : state.muscles) rows.push_back(muscle.target);
  };
  targets.emplace_back();
  for (const Muscle& muscle : model.muscles) {
    Rows& rows = targets.back().emplace_back();
    for (const Vec3& p : muscle.rest.vertices) rows.push_back(to_row(p));
  }
  run_ours(model, keep);
  const auto peer = [&](const BulletSetting& setting) {
    return run_bullet_arm(model, targets, setting);
  };
  const BulletSetting best = most_accurate(peer);
  return compare(best, [&] { return peer(best); },
                 {{"the scene's, without contact",
                   [&] { return run_ours(model, [](int, const State&) {}); }}});
}

int run(const std::string& arm) {
  const TemporaryFolder temporary("peers");
  const fs::path& folder = temporary.path();
  for (const char* name : {"ball.toml", "press.urdf", "box.obj"}) {
    fs::copy_file(own_asset(std::string("paper/") + name), folder / name);
  }
  Json out;
  for (const int parts : {10, 16, 22}) out["balls"].push_back(compare_ball(folder, parts));
  out["arm"] = compare_arm(arm);
  std::printf("%s\n", out.dump(2).c_str());
  return 0;
}

}  // namespace
}  // namespace thew

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: thew_peers ARM.toml\n");
    return 2;
  }
  try {
    return thew::run(argv[1]);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "thew_peers: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
