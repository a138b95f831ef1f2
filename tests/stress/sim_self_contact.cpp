// SPDX-License-Identifier: Apache-2.0
//
// A body that meets itself: a horseshoe whose arms are pressed together.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

struct Motion {
  Model model;
  State state;
  Parallel parallel{1};
  int crossings = 0, own = 0, pressing = 0;  // of all frames: pairs, contacts with itself
  double volume_error = 0.0;

  Motion(const std::string& scene, const std::vector<std::string>& overrides)
      : model(build_model(read_scene(THEW_SOURCE_DIR "/" + scene, overrides))),
        state(initial_state(model)) {}
  void go_to(int last) {
    StageSeconds seconds;
    const Muscle& muscle = model.muscles[0];
    const Surface& surface = model.surfaces[0].surface;
    const MuscleState& now = state.muscles[0];
    const int first = 1 + static_cast<int>(std::lround(state.time * model.fps));
    for (int f = first; f < last; ++f) {
      step_frame(model, f / model.fps, parallel, state, seconds);
      for (size_t c = 0; c < now.contacts.size(); ++c) {
        own += now.contacts[c].other == 0;
        pressing += now.contacts[c].other == 0 && now.normal_multiplier[c] > 0.0;
      }
      const double volume = enclosed_volume(now.x, muscle.rest.triangles);
      volume_error = std::max(volume_error, std::abs(volume / muscle.rest_volume - 1.0));
      const Bvh tree = build_bvh(surface, now.x);
      crossings +=
          static_cast<int>(crossing_triangles(surface, tree, now.x, surface, tree, now.x).size());
    }
  }
};

const std::string kHorseshoe = "tests/scenes/horseshoe/scene.toml";

TEST(SelfContact, ArmsPressedTogetherDoNotCross) {
  Motion motion(kHorseshoe, {});
  motion.go_to(12);
  EXPECT_EQ(motion.own, 0);  // the arms are apart yet
  motion.go_to(37);
  EXPECT_GT(motion.pressing, 100);
  EXPECT_EQ(motion.crossings, 0);
  EXPECT_LE(motion.volume_error, 1e-12);
}

TEST(SelfContact, UnaskedForTheyGoThroughEachOther) {
  Motion motion(kHorseshoe, {"contact.self=[]"});
  motion.go_to(37);
  EXPECT_EQ(motion.own, 0);
  EXPECT_GT(motion.crossings, 100);
}

// The opposite wall of a body that is squeezed thin is not taken for a self-contact.
TEST(SelfContact, NotThroughTheBodysOwnFlesh) {
  Motion motion("assets/paper/ball.toml",
                {"muscle.ball.mesh=ball_1470.obj", "contact.self=[\"ball\"]",
                 "solver.integrator=local_global", "solver.iterations=40",
                 "rig.clip.keys={top=[[1,0],[31,0.09],[46,0.09]],bottom=[[1,0],[31,0.09],[46,"
                 "0.09]]}"});
  motion.go_to(36);
  EXPECT_EQ(motion.own, 0);
  EXPECT_LE(motion.volume_error, 1e-12);
}

TEST(SelfContact, GoesOnFromAKeptStateToTheBit) {
  Motion whole(kHorseshoe, {}), resumed(kHorseshoe, {});
  whole.go_to(30);
  unpack_state(whole.model, pack_state(whole.state), resumed.state);
  for (Motion* motion : {&whole, &resumed}) motion->go_to(33);
  EXPECT_EQ(pack_state(resumed.state), pack_state(whole.state));
}

}  // namespace
}  // namespace thew::tests
