// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/study.h"

#include <future>
#include <mutex>

#include "tools/lab/paper/ball.h"

namespace thew::tools {
namespace {

constexpr const char* kFirst = "ball_1470";  // where each method's dial is chosen

std::vector<StudiedScene> all_scenes(const std::filesystem::path& folder, bool quick) {
  std::vector<StudiedScene> out;
  const auto add = [&](RelatedScene scene, bool whole = true) {
    out.push_back({std::move(scene), {}, {}, {}, whole});
  };
  const PrintedBall* const rows = kPrintedBalls;
  add(squeezed_ball(folder, rows[0].triangles, rows[0].tetrahedra, 3));
  add(flexed_muscle(folder, 3));
  if (quick) return out;
  add(pressed_ball(folder, 3));
  add(twisted_cube(folder, 3));
  add(squeezed_ball(folder, rows[1].triangles, rows[1].tetrahedra, 0), false);
  add(squeezed_ball(folder, rows[2].triangles, rows[2].tetrahedra, 0), false);
  return out;
}

// The method at the dial that was best where it was chosen; none: it was stable at none.
RelatedMethod at_best_dial(const RelatedMethod& method, const RelatedSweep& chosen) {
  RelatedMethod one = method;
  one.dials.clear();
  for (const RelatedDial& dial : method.dials) {
    if (chosen.best >= 0 && dial.label == chosen.runs[chosen.best].dial) one.dials = {dial};
  }
  return one;
}

bool is_for(const RelatedMethod& method, const RelatedScene& scene) {
  return method.of.empty() || method.of == scene.key;
}

void run_thew_in(StudiedScene& in, bool quick) {
  in.thew.push_back(run_thew(in.scene, {kThew, "explicit", "exact", 0, false}));
  in.thew.push_back(run_thew(in.scene, {kThewBare, "explicit", "none", 0, false}));
  in.thew.push_back(run_thew(in.scene, {kThewImplicit, "local_global", "exact", 3, false}));
  if (in.scene.as_muscle) {
    in.thew.push_back(run_thew(in.scene, {kThewMuscle, "local_global", "exact", 3, true}));
  }
  if (!quick) {
    in.thew.push_back(run_thew(in.scene, {kThewImplicit, "local_global", "exact", 20, false}));
  }
}

// Large bodies: no finer steps, and of what takes seconds a frame a few frames.
RelatedSweep sweep_once(const RelatedScene& scene, const RelatedMethod& method,
                        const Truth* truth) {
  if (!method.implicit || scene.surface.triangles.size() < 5000) {
    return sweep(scene, method, truth, {.finer = 1, .patience = 60.0});
  }
  RelatedSweep out;
  for (const RelatedDial& dial : method.dials) {
    out.runs.push_back(run_rival(scene, method, dial, 1, 3, 60.0));
    if (out.runs.back().failure.empty()) out.best = out.cheapest = 0;
  }
  return out;
}

}  // namespace

int Study::method(const std::string& name) const {
  for (size_t k = 0; k < methods.size(); ++k) {
    if (methods[k].name == name) return static_cast<int>(k);
  }
  return -1;
}

int Study::scene(const std::string& key) const {
  for (size_t k = 0; k < scenes.size(); ++k) {
    if (scenes[k].scene.key == key) return static_cast<int>(k);
  }
  return -1;
}

namespace {

const RelatedRun* run_at(const Study& study, const std::string& name, const std::string& key,
                         int RelatedSweep::*which) {
  const int m = study.method(name), s = study.scene(key);
  if (m < 0 || s < 0) return nullptr;
  const RelatedSweep& found = study.scenes[s].sweeps[m];
  return found.*which < 0 ? nullptr : &found.runs[found.*which];
}

}  // namespace

const RelatedRun* Study::best(const std::string& name, const std::string& key) const {
  return run_at(*this, name, key, &RelatedSweep::best);
}

const RelatedRun* Study::cheapest(const std::string& name, const std::string& key) const {
  return run_at(*this, name, key, &RelatedSweep::cheapest);
}

const RelatedRun* Study::thew(const std::string& name, const std::string& key) const {
  for (const RelatedRun& run : scenes[scene(key)].thew) {
    if (run.method == name && run.failure.empty()) return &run;
  }
  return nullptr;
}

int study_steps(bool quick) {
  const int methods = static_cast<int>(related_methods(quick).size());
  return (quick ? 2 : 6) * (methods + 1) + (quick ? 2 : 4) + 1;
}

Study run_study(const std::filesystem::path& folder, const std::filesystem::path& arm, bool quick,
                const std::function<void()>& done) {
  Study study{quick, related_methods(quick), all_scenes(folder, quick), {}, {}, {}};
  std::mutex mutex;
  const auto tell = [&] {
    const std::scoped_lock lock(mutex);
    done();
  };
  // The truths on a thread of their own: methods are timed by their thread's clock.
  std::vector<TruthScene> asked;
  for (const StudiedScene& in : study.scenes) asked.push_back(in.scene.truth);
  std::future<std::vector<Truth>> truths = std::async(std::launch::async, [&] {
    std::vector<Truth> out;
    for (const TruthScene& scene : asked) {
      out.push_back(scene.meshes > 0 ? find_truth(scene) : Truth{});
      if (scene.meshes > 0) tell();
    }
    return out;
  });
  for (StudiedScene& in : study.scenes) run_thew_in(in, quick), tell();
  for (size_t s = 0; s < study.scenes.size(); ++s) {
    StudiedScene& in = study.scenes[s];
    if (s == 0) {
      const std::vector<Truth> found = truths.get();
      for (size_t k = 0; k < found.size(); ++k) {  // balls of all sizes have one truth
        study.scenes[k].truth = study.scenes[k].whole ? found[k] : found[0];
      }
    }
    const Truth* const truth = in.truth.is_known() ? &in.truth : nullptr;
    for (size_t m = 0; m < study.methods.size(); ++m) {
      const RelatedMethod& method = study.methods[m];
      RelatedSweep& out = in.sweeps.emplace_back();
      if (is_for(method, in.scene)) {
        out = in.whole
                  ? sweep(in.scene, method, truth, {.patience = quick ? 8.0 : 20.0})
                  : sweep_once(in.scene,
                               at_best_dial(method, study.scenes[study.scene(kFirst)].sweeps[m]),
                               truth);
      }
      tell();
    }
    for (RelatedRun& run : in.thew) {
      if (truth) judge(in.scene, *truth, run);
    }
  }
  for (size_t m = 0; m < study.methods.size(); ++m) {
    const RelatedMethod& method = study.methods[m];
    const StudiedScene& in = study.scenes[study.scene(method.of.empty() ? kFirst : method.of)];
    const RelatedMethod one = at_best_dial(method, in.sweeps[m]);
    const bool runs = !one.dials.empty(), moves = runs && method.has_step;
    study.momentum.push_back(moves ? momentum_gained(in.scene, one, one.dials[0]) : -1.0);
    study.stiffening.push_back(runs ? stiffening(in.scene, one, one.dials[0]) : -1.0);
  }
  const std::vector<double> angles = {0.0, 45.0, 90.0, 130.0};
  study.arm = arm_sections(arm, quick ? std::vector{0.0, 90.0} : angles);
  tell();
  return study;
}

}  // namespace thew::tools
