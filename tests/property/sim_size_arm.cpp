// SPDX-License-Identifier: Apache-2.0
//
// Similar scenes move alike: the arm at half and at twice its size, with all lengths scaled and
// [scene] size set, against the arm. A factor that is a power of two causes no rounding.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 40;

std::string text_of(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file).rdbuf();
  return text.str();
}

std::string scaled(const std::string& numbers, double size) {
  std::istringstream in(numbers);
  std::string out;
  for (double value = 0.0; in >> value;) {
    char text[40];
    std::snprintf(text, sizeof text, " %.17g", size * value);
    out += text;
  }
  return out.substr(1);
}

void scale_obj(const fs::path& file, double size) {
  std::istringstream in(text_of(file));
  std::string out;
  for (std::string line; std::getline(in, line);) {
    out += (line.starts_with("v ") ? "v " + scaled(line.substr(2), size) : line) + "\n";
  }
  std::ofstream(file) << out;
}

void scale_urdf(const fs::path& file, double size) {
  std::string text = text_of(file), out;
  const std::regex place("<origin[^>]*xyz=\"([^\"]+)\"");
  std::smatch found;
  for (; std::regex_search(text, found, place); text = found.suffix()) {
    out += text.substr(0, found.position(1)) + scaled(found[1], size);
    out += text.substr(found.position(1) + found.length(1),
                       found.position(0) + found.length(0) - found.position(1) - found.length(1));
  }
  std::ofstream(file) << out << text;
}

// Stiffness per width goes as mass over time squared, bending as that times an area.
void scale_muscle(double size, SceneMuscle& muscle) {
  const double mass = size * size * size;
  for (ScenePathPoint& point : muscle.path) point.position *= size;
  for (SceneWrap& wrap : muscle.wraps) wrap.centre *= size, wrap.radius *= size;
  for (double* length :
       {&muscle.belly[0], &muscle.belly[1], &muscle.twist_from, &muscle.fibre_length}) {
    *length *= size;
  }
  muscle.f_max *= mass * size;
  muscle.material.stiffness *= mass;
  muscle.material.bending *= mass * size * size;
}

class SizedArm : public TempFolder {
 protected:
  Model model_of(double size) {
    const fs::path arm = folder / std::to_string(size);
    fs::copy(fs::path(THEW_SOURCE_DIR) / "assets/arm", arm, fs::copy_options::recursive);
    for (const auto& entry : fs::recursive_directory_iterator(arm)) {
      if (entry.path().extension() == ".obj") scale_obj(entry.path(), size);
    }
    scale_urdf(arm / "arm.urdf", size);
    char setting[40];
    std::snprintf(setting, sizeof setting, "scene.size=%g", size);
    const Scene unscaled = read_scene(arm / "arm.toml");
    Scene scene = read_scene(arm / "arm.toml", {setting});
    scene.gravity *= size;
    for (SceneMuscle& muscle : scene.muscles) {
      muscle.fibre_length = unscaled.muscles[&muscle - scene.muscles.data()].fibre_length;
      scale_muscle(size, muscle);
    }
    // The settings that the arm's scene gives are scaled too.
    scene.skin.settings = times(unscaled.skin.settings, size);
    scene.contact.settings = times(unscaled.contact.settings, size);
    for (auto& [name, thickness] : scene.contact.thickness) thickness *= size;
    return build_model(scene);
  }
};

TEST_F(SizedArm, MovesAsTheArmDoes) {
  struct Run {
    Model model;
    State state;
  };
  const std::vector<double> sizes = {1.0, 0.5, 2.0};
  std::vector<Run> runs;
  Parallel parallel(2);
  StageSeconds seconds;
  for (const double size : sizes) {
    Run& run = runs.emplace_back(Run{model_of(size), {}});
    run.state = initial_state(run.model);
    settle(run.model, parallel, run.state);
  }
  std::vector<double> muscles(sizes.size(), 0.0), skin(sizes.size(), 0.0);
  for (int f = 1; f < kFrames; ++f) {
    for (Run& run : runs) step_frame(run.model, f / 24.0, parallel, run.state, seconds);
    const State& arm = runs[0].state;
    for (size_t k = 1; k < sizes.size(); ++k) {
      const auto off = [&](const Points& x, const Points& of_arm) {
        double most = 0.0;
        for (size_t i = 0; i < x.size(); ++i) {
          most = std::max(most, norm(1.0 / sizes[k] * x[i] - of_arm[i]));
        }
        return most;
      };
      for (int m = 0; m < arm.count(); ++m) {
        muscles[k] = std::max(muscles[k], off(runs[k].state.muscles[m].x, arm.muscles[m].x));
      }
      skin[k] = std::max(skin[k], off(runs[k].state.skin.x, arm.skin.x));
    }
  }
  for (size_t k = 1; k < sizes.size(); ++k) {
    std::printf("size %g: muscles %.2g mm, skin %.2g mm off\n", sizes[k], 1e3 * muscles[k],
                1e3 * skin[k]);
    // Bellies that touch all along are parted by exact tests of crossing, which notice rounding;
    // the skin follows them.
    EXPECT_LT(muscles[k], 1e-4);
    EXPECT_LT(skin[k], 1e-4);
    const State& state = runs[k].state;
    const SkinModel& model = runs[k].model.skin;
    EXPECT_TRUE(crossing_triangles(model.surface, state.skin.bvh, state.skin.x, model.surface,
                                   state.skin.bvh, state.skin.x)
                    .empty());
  }
}

}  // namespace
}  // namespace thew::tests
