// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

TEST_F(SceneFile, ToleranceInAnyUnit) {
  for (const char* position :
       {"\"0.5 mm\"", "\"0.5mm\"", "\"500 um\"", "\"0.05 cm\"", "\"5e-4 m\"", "5e-4"}) {
    const auto tolerance =
        read_scene(scene("[solver]\ntolerance = { position = " + std::string(position) + " }\n"))
            .solver.tolerance;
    ASSERT_TRUE(tolerance) << position;
    EXPECT_NEAR(tolerance->position, 5e-4, 1e-18) << position;
    EXPECT_EQ(tolerance->volume, 1e-9);
  }
  const Scene both = read_scene(
      scene("[solver]\nvolume = \"exact\"\ntolerance = { position = 1, volume = 1e-12 }\n"));
  EXPECT_EQ(both.solver.tolerance->volume, 1e-12);
  EXPECT_TRUE(both.solver.tolerance->location.ends_with("arm.toml:15"));
  EXPECT_FALSE(read_scene(scene()).solver.tolerance);
}

TEST_F(SceneFile, WrongTolerances) {
  const struct {
    const char *more, *message;
  } cases[] = {
      {"tolerance = 1\n", ":14: solver.tolerance is 1; give a table"},
      {"tolerance = {}\n", ":14: [solver.tolerance] lacks the key \"position\"; add it"},
      {"tolerance = { position = 0 }\n", ":14: solver.tolerance.position is 0; give a number from"},
      {"tolerance = { position = nan }\n", ":14: solver.tolerance.position is no number; give"},
      {"tolerance = { position = \"0.5 inch\" }\n",
       ":14: solver.tolerance.position is \"0.5 inch\"; give a length from 1e-06 m to 1 m, as "
       "\"0.5 mm\""},
      {"tolerance = { position = \"mm\" }\n", ":14: solver.tolerance.position is \"mm\"; give a"},
      {"tolerance = { position = \"-1 mm\" }\n",
       ":14: solver.tolerance.position is \"-1 mm\"; give"},
      {"tolerance = { position = \"1 nm\" }\n", ":14: solver.tolerance.position is \"1 nm\"; give"},
      {"tolerance = { position = 1e-3, volume = 1e-17 }\n",
       ":14: solver.tolerance.volume is 1e-17; give a number from 1e-12"},
      {"tolerance = { position = 1e-3, volum = 1e-9 }\n",
       ":14: unknown key \"volum\" in [solver.tolerance]; did you mean \"volume\"?"},
      {"toleranc = { position = 1e-3 }\n",
       ":14: unknown key \"toleranc\" in [solver]; did you mean \"tolerance\"?"},
      {"substeps = 2\ntolerance = { position = 1e-3 }\n",
       ":14: solver.substeps is 2, but a tolerance "
       "chooses it for each muscle; remove it"},
      {"tolerance = { position = 1e-3 }\nintegrator = \"xpbd\"\n",
       ":15: solver.integrator is \"xpbd\", but a tolerance"},
      {"tolerance = { position = 1e-3 }\niterations = 2\n", ":15: solver.iterations is 2, but a"},
      {"tolerance = { position = 1e-3 }\nvolume = \"none\"\n",
       ":15: solver.volume is \"none\", which holds no tolerance; give \"exact\""},
  };
  for (const auto& [more, message] : cases) {
    EXPECT_STARTS(error_of("[solver]\n" + std::string(more)), message);
  }
  EXPECT_STARTS(error_of("[solver]\ntolerance = { position = 1e-3 }\n", {"solver.substeps=3"}),
                "--set solver.substeps: solver.substeps is 3, but a tolerance");
}

TEST(Tolerance, IsPartOfTheHash) {
  const auto hash = [](const Settings& overrides) {
    return build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml", overrides))
        .hash;
  };
  const std::string half = hash({"solver.tolerance={ position = \"0.5 mm\" }"});
  EXPECT_EQ(half, hash({"solver.tolerance={ position = 5e-4 }"}));
  EXPECT_NE(half, hash({"solver.tolerance={ position = 4e-4 }"}));
  EXPECT_NE(half, hash({"solver.tolerance={ position = 5e-4, volume = 1e-8 }"}));
  EXPECT_NE(half, hash({}));
}

}  // namespace
}  // namespace thew::tests
