// SPDX-License-Identifier: Apache-2.0
// Each number of a scene is replaced by values that a typing error or a script may produce. The
// scene is refused with file and line, or baked. THEW_EVERY=1 tries all pairs, the default a share
// of them.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "tests/unit/rig/temp.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScene = R"([scene]
name = "numbers"
fps = 24
frames = "1-2"
settle = 0.05
gravity = [0.5, -9.81, 0]
[rig]
file = "rig.urdf"
[rig.clip]
unit = "deg"
keys = { elbow = [[1, 0], [3, 20]] }
[[muscle]]
name = "front"
path = [["humerus", 0.03, -0.03, 0], ["ulna", 0.03, -0.05, 0]]
wrap = [{ segment = 0, body = "ulna", centre = [0, -0.01, 0], axis = [0, 0, 1], radius = 0.016, turn = -1 }]
belly = [0.06, 0.24]
twist_from = 0.2
weights = { profile = [[0, 2], [0.5, 1], [1, 0]] }
guide = 100
damping = 10
f_max = 200
fibre_length = 0.12
activation = [[1, 0], [3, 1]]
material = { stiffness = 900, anisotropy = 8, shear = 0.3, bending = 2e-4, density = 1050, shape = 1 }
colour = [0.1, 0.2, 0.3]
zones = 3
profile = { around = 10, rings = 9, radius = [[0, 0.004], [0.5, 0.018], [1, 0.005]] }
[[muscle]]
name = "side"
path = [["humerus", 0.03, -0.03, 0.03], ["ulna", 0.03, -0.05, 0.03]]
weights = { zone = { smallest_radius = 0.03, largest_radius = 0.12, per_impulse = 0.02, along_load = 0.5 } }
profile = { around = 10, rings = 9, radius = [[0, 0.004], [0.5, 0.018], [1, 0.005]] }
[skin]
mesh = "skin.obj"
thickness = 0.003
smoothing = 0.25
iterations = 7
fold_gap = 1e-3
reach = 0.03
[solver]
substeps = 2
iterations = 3
[contact]
margin = 0.004
max_depth = 0.03
gap = 1e-4
spacing = 0.007
thickness = { front = 0.001 }
[[render.view]]
name = "front"
eye = [0, 0, 2]
target = [0, -0.3, 0]
up = [0, 1, 0]
field_of_view = 40
light = [0, 1, 1]
cut = [[0, 0, 1, 0.02]]
[[bound]]
volume_error = 1e-1
penetration = 5e-1
poke_through = 1e-1
attachment_gap = 1e-1
[[muscle]]
name = "soft"
mesh = "skin.obj"
transform = { scale = 0.3, axis = [0, 1, 0], angle = 10, move = [0.3, 0, 0] }
fixed = [{ body = "ulna", low = [-1, -1, 0], high = [1, 0.5, 1] }]
)";

constexpr const char* kValues[] = {"0",    "-1",  "1e-300", "1e300", "1e10", "-1e10",   "nan",
                                   "-nan", "inf", "-inf",   "1e-12", "3e9",  "\"text\""};

struct Span {
  size_t begin, end;
};

// Finds the numbers that are values, not those within names or quotes.
std::vector<Span> numbers_of(const std::string& text) {
  std::vector<Span> spans;
  bool quoted = false;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '"') quoted = !quoted;
    const bool begins = i > 0 && std::string(" [").find(text[i - 1]) != std::string::npos &&
                        std::string("-0123456789").find(text[i]) != std::string::npos;
    if (quoted || !begins) continue;
    const size_t end = text.find_first_not_of("-+.0123456789e", i);
    spans.push_back({i, end});
    i = end - 1;
  }
  return spans;
}

// Whether a message prints a number that is not finite.
bool names_no_number(const std::string& message) {
  for (const char* word : {" nan", "-nan", "(nan", " inf ", "-inf", "(inf", " inf,", " inf;"}) {
    if (message.find(word) != std::string::npos) return true;
  }
  return false;
}

class SceneNumbers : public TempFolder {};

TEST_F(SceneNumbers, EachIsRefusedOrBaked) {
  const char* every = std::getenv("THEW_EVERY");
  const size_t step = every ? std::strtoul(every, nullptr, 10) : 11;
  const std::string text = kScene;
  const std::vector<Span> spans = numbers_of(text);
  ASSERT_GT(spans.size(), 100u);
  for (const char* file : {"rig.urdf", "skin.obj", "bone.obj"}) {
    fs::copy(fs::path(THEW_SOURCE_DIR "/tests/scenes/pair") / file, folder / file);
  }
  const std::vector<std::vector<std::string>> solvers = {
      {},
      {"solver.integrator=xpbd"},
      {"solver.integrator=explicit"},
      {"solver.integrator=quasi_static"},
      {"solver.volume=zonal"},
      {"solver.volume=penalty", "solver.integrator=xpbd"},
      {"solver.volume=linear"},
      {"solver.volume=printed", "solver.integrator=explicit"},
      {"solver.volume=none"}};
  size_t pair = 0, refused = 0, baked = 0;
  for (const Span& span : spans) {
    for (const char* value : kValues) {
      if (pair++ % step != 0) continue;
      const std::string changed = text.substr(0, span.begin) + value + text.substr(span.end);
      const fs::path file = write("scene.toml", changed);
      const std::string what = value + (" for " + text.substr(span.begin, span.end - span.begin)) +
                               " at " + std::to_string(span.begin);
      const auto begin = std::chrono::steady_clock::now();
      try {
        const Scene scene = read_scene(file, solvers[pair % solvers.size()]);
        const Model model = build_model(scene);
        fs::remove_all(folder / "out");
        BakeOptions options;
        options.folder = folder / "out";
        options.frames = {scene.first_frame};
        bake(model, options, [](const BakeFrame&) { return true; });
        ++baked;
      } catch (const Error& error) {
        ++refused;
        EXPECT_FALSE(names_no_number(error.what())) << what << ": " << error.what();
        EXPECT_TRUE(error.code() == ErrorCode::kUsage || error.code() == ErrorCode::kInput ||
                    error.code() == ErrorCode::kSolver)
            << what << ": " << error.what();
        if (error.code() == ErrorCode::kUsage) {
          EXPECT_NE(std::string(error.what()).find("scene.toml:"), std::string::npos)
              << what << ": " << error.what();
        }
      } catch (const std::exception& error) {
        ADD_FAILURE() << what << ": " << error.what();
      }
      const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
      EXPECT_LT(seconds.count(), 20.0) << what;
    }
  }
  std::printf("%zu numbers: %zu refused, %zu baked\n", spans.size(), refused, baked);
  EXPECT_GT(refused, 0u);
  EXPECT_GT(baked, 0u);
}

}  // namespace
}  // namespace thew::tests
