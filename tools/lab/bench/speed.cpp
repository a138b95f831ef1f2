// SPDX-License-Identifier: Apache-2.0
#include "muscles/volume.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"
#include "tools/lab/bench/benches.h"

namespace thew::tools {

using Json = nlohmann::ordered_json;

namespace {

double milliseconds_of(const Model& model) {
  return play(model, settled_state(model)).milliseconds_a_frame(model);
}

Model model_with(const std::string& scene, std::vector<std::string> overrides) {
  overrides.push_back("skin.enabled=false");
  return build_model(read_scene(scene, overrides));
}

// Over all frames but the first; `frame`: that of the largest.
NodeDistance distance(const Model& a, const Model& b, int& frame) {
  NodeDistance out;
  Parallel all(0);
  StageSeconds unused;
  State x = initial_state(a), y = initial_state(b);
  settle(a, all, x);
  settle(b, all, y);
  const int first = a.first_frame;
  for (int f = first + 1; f <= a.last_frame; ++f) {
    step_frame(a, (f - first) / a.fps, all, x, unused);
    step_frame(b, (f - first) / b.fps, all, y, unused);
    const double before = out.largest;
    for (int m = 0; m < x.count(); ++m) add_distance(x.muscles[m].x, y.muscles[m].x, out);
    if (out.largest > before) frame = f;
  }
  return out;
}

// mm, sag of the first muscle held horizontally: gravity across it against no gravity, no contact.
double sag(const std::string& scene) {
  const auto first_muscle = [&](const char* gravity) {
    Model model = model_with(scene, {"contact.enabled=false", gravity});
    model.last_frame = model.first_frame + 1;
    return play(model, settled_state(model)).state.muscles[0].x;
  };
  return 1e3 * largest_distance(first_muscle("scene.gravity=[9.81, 0, 0]"),
                                first_muscle("scene.gravity=[0, 0, 0]"));
}

}  // namespace

Json speed_of(const std::string& scene, int repetitions) {
  Json out;
  const Model model = model_with(scene, {});
  const int first = model.first_frame, last = model.last_frame;
  const Model none = model_with(scene, {"solver.volume=none"});
  const Model free = model_with(scene, {"contact.enabled=false"});
  const Model rough = model_with(scene, {"contact.friction=0.3"});
  std::string names;
  for (const Muscle& muscle : model.muscles) names += "\"" + muscle.name + "\",";
  const Model folding = model_with(scene, {"contact.self=[" + names + "]"});
  std::vector<double> whole, without_volume, without_contact, with_friction, with_self;
  std::vector<double> rig, contact, muscles;
  for (int i = 0; i < repetitions; ++i) {
    const Played a = play(model, settled_state(model));
    whole.push_back(a.milliseconds_a_frame(model));
    without_volume.push_back(milliseconds_of(none));
    without_contact.push_back(milliseconds_of(free));
    with_friction.push_back(milliseconds_of(rough));
    with_self.push_back(milliseconds_of(folding));
    const double per_frame = 1e3 / (last - first);
    rig.push_back(per_frame * a.stages.rig.cpu);
    contact.push_back(per_frame * a.stages.contact.cpu);
    muscles.push_back(per_frame * a.stages.muscles.cpu);
  }
  out["scene"] = model.name;
  out["muscles"] = model.muscles.size();
  out["frames"] = last - first + 1;
  out["cpu_ms_per_frame"] = median(whole);
  out["frames_per_cpu_second"] = 1e3 / median(whole);
  out["wall_ms_per_frame"] = {
      {"rig", median(rig)}, {"contact", median(contact)}, {"muscles", median(muscles)}};
  out["ratio_to_no_volume"] = median(whole) / median(without_volume);
  out["ratio_to_no_contact"] = median(whole) / median(without_contact);
  out["ratio_of_friction"] = median(with_friction) / median(whole);
  out["ratio_of_self_contact"] = median(with_self) / median(whole);
  out["sag_mm"] = sag(scene);
  // Against the same model, step and iterations refined: all nodes, all frames.
  int frame = 0;
  const NodeDistance error =
      distance(model, model_with(scene, {"solver.substeps=8", "solver.iterations=40"}), frame);
  out["error_mm"] = {{"max", error.largest}, {"in_frame", frame}, {"rms", error.rms()}};
  return out;
}

// The skin alone, over the last state of the muscles: what a frame costs more than one without.
Json skin_price(const std::string& scene, int repetitions) {
  const auto frame = [&](const char* setting) {
    const Model model = build_model(read_scene(scene, {setting}));
    Played run = play(model, settled_state(model));
    return std::pair(run.milliseconds_a_frame(model), std::move(run.state.skin.x));
  };
  const Model model = build_model(read_scene(scene, {}));
  if (!model.has_skin) throw Error(ErrorCode::kInput, scene + ": has no skin layer");
  std::vector<double> none, free, kept;
  double error = 0.0;
  for (int i = 0; i < repetitions; ++i) {
    none.push_back(frame("skin.enabled=false").first);
    free.push_back(frame("skin.volume=none").first);
    const auto [milliseconds, x] = frame("skin.volume=exact");
    kept.push_back(milliseconds);
    const double volume = enclosed_volume(x, model.skin.surface.triangles);
    error = std::abs(volume - model.skin.volume) / model.skin.volume;
  }
  const double layer = median(free) - median(none), full = median(kept) - median(none);
  return {{"scene", model.name},
          {"nodes", model.skin.rest.size()},
          {"cpu_ms_per_frame", layer},
          {"cpu_ms_per_frame_with_its_volume", full},
          {"ratio_of_volume", full / layer},
          {"volume_error", error}};
}

}  // namespace thew::tools
