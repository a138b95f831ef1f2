// SPDX-License-Identifier: Apache-2.0
//
// thew_bench SCENE: how fast the muscles are, and how right at that speed, as one JSON object. Times are
// CPU milliseconds of one thread, medians of interleaved runs; the figures that carry over between
// machines are the ratios.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <functional>
#include <nlohmann/json.hpp>

#include "sim/drive.h"
#include "sim/step.h"

namespace thew {
namespace {

constexpr int kRuns = 5;

double cpu_seconds() {
  timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

struct Run {
  double milliseconds = 0.0;  ///< CPU, a frame
  StageSeconds seconds;
  State state;                ///< at the last frame
};

Run simulate(const Model& model, int last) {
  Run run;
  Parallel one(1);
  run.state = initial_state(model);
  settle(model, one, run.state);
  const int first = model.scene.first_frame;
  const double begin = cpu_seconds();
  for (int f = first + 1; f <= last; ++f) {
    step_frame(model, (f - first) / model.scene.fps, one, run.state, run.seconds);
  }
  run.milliseconds = 1e3 * (cpu_seconds() - begin) / (last - first);
  return run;
}

Model model_with(const std::string& scene, std::vector<std::string> overrides) {
  overrides.push_back("skin.enabled=false");
  return build_model(read_scene(scene, overrides));
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

struct Distance {
  double largest = 0.0, rms = 0.0;  ///< mm
};
Distance distance(const State& a, const State& b, int only = -1) {
  Distance out;
  double sum = 0.0, count = 0.0;
  for (int m = 0; m < a.count(); ++m) {
    if (only >= 0 && m != only) continue;
    for (size_t i = 0; i < a.muscles[m].x.size(); ++i) {
      const double d = 1e3 * (to_vec(a.muscles[m].x[i]) - to_vec(b.muscles[m].x[i])).norm();
      out.largest = std::max(out.largest, d);
      sum += d * d;
      ++count;
    }
  }
  out.rms = std::sqrt(sum / std::max(count, 1.0));
  return out;
}

// Sag of the first muscle held horizontally: gravity across it against no gravity, no contact.
double sag(const std::string& scene) {
  const std::vector<std::string> still = {"contact.enabled=false"};
  std::vector<std::string> with = still, without = still;
  with.push_back("scene.gravity=[9.81, 0, 0]");
  without.push_back("scene.gravity=[0, 0, 0]");
  Model a = model_with(scene, with), b = model_with(scene, without);
  const int first = a.scene.first_frame;
  return distance(simulate(a, first + 1).state, simulate(b, first + 1).state, 0).largest;
}

int run(const std::string& scene) {
  nlohmann::ordered_json out;
  const Model model = model_with(scene, {});
  const int first = model.scene.first_frame, last = model.scene.last_frame;
  const Model none = model_with(scene, {"solver.volume=none"});
  const Model free = model_with(scene, {"contact.enabled=false"});
  std::vector<double> whole, without_volume, without_contact, rig, contact, muscles;
  for (int i = 0; i < kRuns; ++i) {
    const Run a = simulate(model, last);
    whole.push_back(a.milliseconds);
    without_volume.push_back(simulate(none, last).milliseconds);
    without_contact.push_back(simulate(free, last).milliseconds);
    const double per_frame = 1e3 / (last - first);
    rig.push_back(per_frame * a.seconds.rig);
    contact.push_back(per_frame * a.seconds.contact);
    muscles.push_back(per_frame * a.seconds.muscles);
  }
  out["scene"] = model.scene.name;
  out["muscles"] = model.muscles.size();
  out["frames"] = last - first + 1;
  out["cpu_ms_per_frame"] = median(whole);
  out["frames_per_cpu_second"] = 1e3 / median(whole);
  out["wall_ms_per_frame"] = {
      {"rig", median(rig)}, {"contact", median(contact)}, {"muscles", median(muscles)}};
  out["ratio_to_no_volume"] = median(whole) / median(without_volume);
  out["ratio_to_no_contact"] = median(whole) / median(without_contact);
  out["sag_mm"] = sag(scene);
  // Error against the same model, step and iterations refined, where the motion is fastest and at its end.
  const Model fine = model_with(scene, {"solver.substeps=8", "solver.iterations=40"});
  for (const double part : {0.25, 0.5}) {
    const int frame = first + static_cast<int>(part * (last - first));
    const Distance error = distance(simulate(model, frame).state, simulate(fine, frame).state);
    out["error_mm"].push_back({{"frame", frame}, {"max", error.largest}, {"rms", error.rms}});
  }
  std::printf("%s\n", out.dump(2).c_str());
  return 0;
}

}  // namespace
}  // namespace thew

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: thew_bench SCENE.toml\n");
    return 2;
  }
  try {
    return thew::run(argv[1]);
  } catch (const thew::Error& error) {
    std::fprintf(stderr, "thew_bench: %s\n", error.what());
    return static_cast<int>(error.code());
  }
}
