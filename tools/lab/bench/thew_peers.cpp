// SPDX-License-Identifier: Apache-2.0
//
// thew_peers ARM.toml: Debian's Bullet soft body beside our muscles, on the same meshes, masses and
// motion in one run, as one JSON object (in a file too, where one is named). CPU milliseconds a
// frame of one thread, medians of interleaved runs. thew_peers --chart DIR: the ball's speed
// against its accuracy, ours, Bullet's and finite elements. thew_peers --bar DIR: one multiplier
// and zones, each with its own, beside finite elements.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/base/options.h"
#include "tools/base/temporary_folder.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/paper/shapes.h"
#include "tools/lab/peers/ball_chart.h"
#include "tools/lab/peers/bar_chart.h"
#include "tools/lab/peers/peer_runs.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kRuns = 3;  // of which times are the medians

// Targets of the held nodes by frame and muscle, from our own run.
using Targets = std::vector<std::vector<Points>>;

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
          const Point before = targets[f - 1][m][i];
          bodies[m]->hold(static_cast<int>(i), before + t * (targets[f][m][i] - before));
        }
        bodies[m]->step(1.0 / (model.fps * setting.steps));
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

BulletSetting most_accurate_of_all(const std::function<Outcome(const BulletSetting&)>& run) {
  BestPeer best;
  for (const int steps : {5, 10, 20}) {
    const BestPeer found = most_accurate(steps, run);
    if (found.volume_error < best.volume_error) best = found;
  }
  return best.setting;
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
  for (const char* stiffness :
       {"1000", "30"}) {  // Bullet has no such figure: its links are a share
    const std::string material = std::string("muscle.ball.material.stiffness=") + stiffness;
    for (const std::string integrator : {"explicit", "local_global"}) {
      if (integrator == "local_global" && parts > 10) continue;  // minutes, and no faster there
      const Model model =
          ours({material, "solver.integrator=" + integrator, "solver.iterations=1"});
      runs.emplace_back(integrator + ", " + stiffness + " N/m",
                        [model] { return run_our_ball(model); });
    }
  }
  const Model model = ours({});
  const auto peer = [&](const BulletSetting& setting) { return run_bullet_ball(model, setting); };
  const BulletSetting best = most_accurate_of_all(peer);
  Json out = {{"nodes", mesh.vertices.size()}};
  out.update(compare(
      best, [&] { return peer(best); }, runs));
  return out;
}

Json compare_arm(const std::string& scene) {
  const Model model =
      build_model(read_scene(scene, {"skin.enabled=false", "contact.enabled=false"}));
  Targets targets;
  const auto keep = [&](int frame, const State& state) {
    if (frame == model.first_frame) return;
    std::vector<Points>& rows = targets.emplace_back();
    for (const MuscleState& muscle : state.muscles) rows.push_back(muscle.target);
  };
  targets.emplace_back();
  for (const Muscle& muscle : model.muscles) {
    targets.back().push_back(to_points(muscle.rest.vertices));
  }
  run_ours(model, keep);
  const auto peer = [&](const BulletSetting& setting) {
    return run_bullet_arm(model, targets, setting);
  };
  const BulletSetting best = most_accurate_of_all(peer);
  return compare(best, [&] { return peer(best); },
                 {{"the scene's, without contact", [&] { return run_ours(model); }}});
}

int run(int argc, char** argv) {
  const std::string_view asked = argc > 1 ? argv[1] : "";
  const bool draws = asked == "--chart" || asked == "--bar";
  if (argc < 2 || argc > 3 || (draws && argc != 3)) {
    std::fprintf(stderr, "usage: thew_peers ARM.toml [OUT.json] | --chart DIR | --bar DIR\n");
    return 2;
  }
  if (asked == "--bar") {
    draw_bar_chart(argv[2]);
    return 0;
  }
  const TemporaryFolder temporary("peers");
  const fs::path& folder = temporary.path();
  for (const char* name : {"ball.toml", "ball_1766.obj", "press.urdf", "box.obj"}) {
    fs::copy_file(own_asset(std::string("paper/") + name), folder / name);
  }
  if (draws) {
    draw_ball_chart(folder, argv[2]);
    return 0;
  }
  Json out;
  for (const int parts : {10, 16, 22}) out["balls"].push_back(compare_ball(folder, parts));
  out["arm"] = compare_arm(argv[1]);
  std::printf("%s\n", out.dump(2).c_str());
  if (argc == 3) replace_durably(argv[2], out.dump(2) + "\n");
  return 0;
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  return thew::tools::run_or_tell("thew_peers", thew::tools::run, argc, argv);
}
