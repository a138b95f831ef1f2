// SPDX-License-Identifier: Apache-2.0
//
// thew_bench SCENE: how fast the muscles are, and how right at that speed, as one JSON object.
// Times are CPU milliseconds of one thread, medians of interleaved runs; the figures that carry
// over between machines are the ratios.
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
  State state;  ///< at the last frame
};

Run simulate(const Model& model) {
  const int last = model.scene.last_frame;
  Run run;
  Parallel one(1);
  State state = initial_state(model);
  settle(model, one, state);
  const int first = model.scene.first_frame;
  const double begin = cpu_seconds();
  for (int f = first + 1; f <= last; ++f) {
    step_frame(model, (f - first) / model.scene.fps, one, state, run.seconds);
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

/// Over nodes, and frames where it goes on.
struct Distance {
  double largest = 0.0, sum = 0.0, count = 0.0;  ///< mm, mm^2
  int frame = 0;                                 ///< of the largest
  double rms() const { return std::sqrt(sum / std::max(count, 1.0)); }
};
void add_distance(const State& a, const State& b, int frame, Distance& out) {
  for (int m = 0; m < a.count(); ++m) {
    for (size_t i = 0; i < a.muscles[m].x.size(); ++i) {
      const double d = 1e3 * (to_vec(a.muscles[m].x[i]) - to_vec(b.muscles[m].x[i])).norm();
      if (d > out.largest) out.largest = d, out.frame = frame;
      out.sum += d * d;
      ++out.count;
    }
  }
}

// Over all frames.
Distance distance(const Model& a, const Model& b) {
  Distance out;
  Parallel all(0);
  StageSeconds unused;
  State x = initial_state(a), y = initial_state(b);
  settle(a, all, x);
  settle(b, all, y);
  const int first = a.scene.first_frame;
  for (int f = first + 1; f <= a.scene.last_frame; ++f) {
    step_frame(a, (f - first) / a.scene.fps, all, x, unused);
    step_frame(b, (f - first) / b.scene.fps, all, y, unused);
    add_distance(x, y, f, out);
  }
  return out;
}

// Sag of the first muscle held horizontally: gravity across it against no gravity, no contact.
double sag(const std::string& scene) {
  const std::vector<std::string> still = {"contact.enabled=false"};
  std::vector<std::string> with = still, without = still;
  with.push_back("scene.gravity=[9.81, 0, 0]");
  without.push_back("scene.gravity=[0, 0, 0]");
  Model a = model_with(scene, with), b = model_with(scene, without);
  a.muscles.resize(1);
  b.muscles.resize(1);
  a.ignore.resize(1);
  b.ignore.resize(1);
  a.scene.last_frame = b.scene.last_frame = a.scene.first_frame + 1;
  return distance(a, b).largest;
}

int run(const std::string& scene) {
  nlohmann::ordered_json out;
  const Model model = model_with(scene, {});
  const int first = model.scene.first_frame, last = model.scene.last_frame;
  const Model none = model_with(scene, {"solver.volume=none"});
  const Model free = model_with(scene, {"contact.enabled=false"});
  std::vector<double> whole, without_volume, without_contact, rig, contact, muscles;
  for (int i = 0; i < kRuns; ++i) {
    const Run a = simulate(model);
    whole.push_back(a.milliseconds);
    without_volume.push_back(simulate(none).milliseconds);
    without_contact.push_back(simulate(free).milliseconds);
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
  // Against the same model, step and iterations refined: all nodes, all frames.
  const Distance error =
      distance(model, model_with(scene, {"solver.substeps=8", "solver.iterations=40"}));
  out["error_mm"] = {{"max", error.largest}, {"in_frame", error.frame}, {"rms", error.rms()}};
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
