// SPDX-License-Identifier: Apache-2.0
//
// What --resume takes over, what it does again, and what it refuses.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

class Resume : public TempFolder {
 protected:
  Resume() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/pair", folder / "scene", fs::copy_options::recursive);
    options.input = folder / "scene/scene.toml";
    options.out = folder / "out";
    options.progress = "none";
    options.threads = 1;
    options.resume = true;
    options.pictures = false;
    options.frames = "1-6";
  }
  void edit(const std::string& from, const std::string& to) {
    std::string text = bytes_of(options.input);
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    write("scene/scene.toml", text.replace(at, from.size(), to));
  }
  BakeOutput output() const {
    return {read_scene(options.input).output.double_precision, bytes_of(options.input)};
  }
  Model model() const { return build_model(read_scene(options.input, options.overrides)); }
  // A bake that was interrupted after so many frames.
  void interrupt_after(int frames) {
    const auto stop = [&](const BakeFrame& frame) { return frame.frame < frames; };
    const BakeOptions to = {options.out, {1, 2, 3, 4, 5, 6}, 1, false, output()};
    EXPECT_THROW(bake(model(), to, stop), Error);
  }
  std::string refusal() {
    try {
      bake_command(options);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      return error.what();
    }
    return "not refused";
  }
  std::string whole() {
    CommandOptions other = options;
    other.out = folder / "whole";
    bake_command(other);
    return bytes_of(folder / "whole/bake.h5");
  }

  CommandOptions options;
};

TEST_F(Resume, SimulatesOnlyWhatFollowsABadPart) {
  const std::string expected = whole();
  const struct {
    const char* part;
    int good;
  } cases[] = {{"frame.0001.part", 0}, {"frame.0003.part", 2}, {"frame.0005.part", 4}};
  for (const auto& [part, good] : cases) {
    fs::remove_all(options.out);
    interrupt_after(5);
    std::string bytes = bytes_of(options.out / "bake.parts" / part);
    bytes[bytes.size() / 2] ^= 1;
    write(std::string("out/bake.parts/") + part, bytes);
    const BakeResult result = bake(model(), {options.out, {1, 2, 3, 4, 5, 6}, 1, true, output()},
                                   [](const BakeFrame&) { return true; });
    EXPECT_EQ(result.resumed_frames, good) << part;
    EXPECT_TRUE(bytes_of(options.out / "bake.h5") == expected) << part;
  }
}

TEST_F(Resume, AnotherSceneIsRefusedWithWhatDiffers) {
  interrupt_after(3);
  const std::string before = bytes_of(options.out / "bake.parts/manifest.jsonl");
  edit("[10, 60]", "[10, 61]");
  EXPECT_HAS(refusal(), "[10, 60], [16, 50]] }\" and is \"keys = { elbow = [[1, 0], [10, 61]");
  edit("[10, 61]", "[10, 60]");
  edit("rings = 11", "rings = 12");
  EXPECT_HAS(refusal(), "mesh \"front\" has changed");
  edit("rings = 12", "rings = 11");
  std::string mesh = bytes_of(folder / "scene/bone.obj");
  const size_t at = mesh.find("0.01000");
  write("scene/bone.obj", mesh.replace(at, 7, "0.01001"));
  EXPECT_HAS(refusal(), "mesh \"humerus\" has changed");
  write("scene/bone.obj", mesh.replace(at, 7, "0.01000"));
  for (const auto& [setting, part] : std::map<std::string, std::string>{
           {"solver.iterations=7", ", a setting of scene, solver, contact or skin has changed;"},
           {"rig.clip.interpolation=linear", ", the clip has changed;"},
           {"muscle.side.f_max=201", ", muscle \"side\" has changed;"}}) {
    options.overrides = {setting};
    EXPECT_HAS(refusal(), part);
  }
  EXPECT_EQ(bytes_of(options.out / "bake.parts/manifest.jsonl"), before);
}

TEST_F(Resume, AChangedMapIsRefusedByItsName) {
  const auto maps = [](const char* stiffness, const char* slide, const char* thickness) {
    const auto places = [](const char* value, const char* base) {
      return std::string("{ places = [[0.03, -0.2, 0.03, 0.1, ") + value + "]], base = " + base +
             " }";
    };
    return std::vector<std::string>{"muscle.side.material.stiffness=" + places(stiffness, "900"),
                                    "skin.slide=" + places(slide, "1"),
                                    "contact.thickness={ side = " + places(thickness, "0") + " }"};
  };
  options.overrides = maps("500", "0.5", "0.002");
  interrupt_after(3);
  options.overrides = maps("501", "0.5", "0.002");
  EXPECT_HAS(refusal(), "material.stiffness of muscle \"side\" has changed");
  options.overrides = maps("500", "0.6", "0.002");
  EXPECT_HAS(refusal(), ", skin.slide has changed");
  options.overrides = maps("500", "0.5", "0.001");
  EXPECT_HAS(refusal(), ", contact.thickness of \"side\", by node has changed");
}

TEST_F(Resume, ACameraIsNoMatterToWhatWasSimulated) {
  interrupt_after(3);
  edit("eye = [0.3, -0.2, 1.6]", "eye = [1.3, -0.2, 1.6]");
  const BakeResult result = bake(model(), {options.out, {1, 2, 3, 4, 5, 6}, 1, true, output()},
                                 [](const BakeFrame&) { return true; });
  EXPECT_EQ(result.resumed_frames, 3);
  EXPECT_TRUE(bytes_of(options.out / "bake.h5") == whole());
}

TEST_F(Resume, ACameraDrawsACompleteBakeAgain) {
  options.pictures = true;
  options.frames = "1-2";
  ASSERT_EQ(bake_command(options), ExitCode::kDone);
  const auto written = fs::last_write_time(options.out / "bake.h5");
  const std::string picture = bytes_of(options.out / "frames/skin.0002.png");
  ASSERT_GT(picture.size(), 100u);
  edit("eye = [0.3, -0.2, 1.6]", "eye = [1.3, -0.2, 1.6]");
  ASSERT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_EQ(fs::last_write_time(options.out / "bake.h5"), written);
  EXPECT_NE(bytes_of(options.out / "frames/skin.0002.png"), picture);
}

TEST_F(Resume, ABoundThatIsNotMetStaysSo) {
  options.overrides = {"bound.volume_error=1e-30"};
  EXPECT_EQ(bake_command(options), ExitCode::kDifferent);
  EXPECT_EQ(bake_command(options), ExitCode::kDifferent);
  options.overrides.clear();
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
}

TEST_F(Resume, ABakeThatCannotBeReadIsMadeAnew) {
  const std::string expected = whole();
  bake_command(options);
  for (const std::string& bad : {expected.substr(0, expected.size() / 2), std::string("junk")}) {
    write("out/bake.h5", bad);
    EXPECT_EQ(bake_command(options), ExitCode::kDone);
    EXPECT_TRUE(bytes_of(options.out / "bake.h5") == expected);
  }
}

TEST_F(Resume, WhatAKillLeavesBesideACompleteBakeIsRemoved) {
  bake_command(options);
  write("out/bake.parts/frame.0001.part", "left");
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_FALSE(fs::exists(options.out / "bake.parts"));
}

TEST_F(Resume, TheHashIsOfAllThatTheSolverReads) {
  const std::string hash = model().hash;
  const auto hash_with = [&](const std::string& setting) {
    return build_model(read_scene(options.input, {setting})).hash;
  };
  for (const char* setting : {"scene.fps=25",
                              "scene.settle=1",
                              "scene.gravity=[0,-9.8,0]",
                              "scene.frames=2-16",
                              "rig.clip.interpolation=linear",
                              "muscle.front.belly=[0.06,0.23]",
                              "muscle.front.weights=even",
                              "muscle.front.f_max=201",
                              "muscle.front.fibre_length=0.11",
                              "muscle.front.activation=[[1,0],[9,1]]",
                              "muscle.front.activation={joint=\"elbow\", preset=\"flexor\"}",
                              "muscle.front.shape=weights",
                              "muscle.front.guide=251",
                              "muscle.front.damping=21",
                              "muscle.front.material.stiffness=901",
                              "muscle.front.material.anisotropy=3",
                              "muscle.front.material.shear=0.31",
                              "muscle.front.material.bending=1e-3",
                              "muscle.front.material.shape=0.6",
                              "muscle.front.material.density=1061",
                              "muscle.side.weights.zone.per_impulse=0.03",
                              "muscle.side.weights.zone.along_load=0.6",
                              "skin.thickness=0.004",
                              "skin.smoothing=0.3",
                              "skin.iterations=4",
                              "skin.fold_gap=2e-3",
                              "skin.reach=0.02",
                              "skin.volume=exact",
                              "skin.enabled=false",
                              "skin.fat=0.003",
                              "skin.slide=0.5",
                              "solver.integrator=explicit",
                              "solver.volume=linear",
                              "solver.substeps=2",
                              "solver.iterations=4",
                              "contact.enabled=false",
                              "contact.margin=0.01",
                              "contact.max_depth=0.02",
                              "contact.gap=1e-3",
                              "contact.ignore=[[\"front\",\"side\"]]"}) {
    EXPECT_NE(hash_with(setting), hash) << setting;
  }
  for (const char* setting : {"render.size=[200,100]", "bound.penetration=1e-3",
                              "muscle.front.colour=[0.1,0.2,0.3]", "output.precision=single"}) {
    EXPECT_EQ(hash_with(setting), hash) << setting;
  }
}

}  // namespace
}  // namespace thew::tests
