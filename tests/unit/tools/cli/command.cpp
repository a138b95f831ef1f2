// SPDX-License-Identifier: Apache-2.0
//
// The command as its users meet it: what a bake leaves behind, and how bad input ends.
#include "tests/unit/tools/cli/command.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "muscles/volume.h"
#include "sim/bake/measure.h"
#include "sim/cache/durable_file.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/cli/inspect_command.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Command : public OneMuscleCommand {
 protected:
  nlohmann::json report() const {
    std::ifstream in(options.out / "report.json");
    return nlohmann::json::parse(in);
  }
  // Copies the scene and changes its text.
  void edit(const std::string& from, const std::string& to) {
    fs::copy(fs::path(options.input).parent_path(), folder / "scene",
             fs::copy_options::recursive | fs::copy_options::overwrite_existing);
    std::ifstream in(folder / "scene/scene.toml");
    std::string text((std::istreambuf_iterator<char>(in)), {});
    const size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    options.input = write("scene/scene.toml", text.replace(at, from.size(), to));
  }
  void expect_error(ErrorCode code, const std::string& words) {
    try {
      bake_command(options);
      ADD_FAILURE() << "baked in spite of: " << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
    }
  }
};

TEST_F(Command, ABakeLeavesCacheAndReport) {
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_FALSE(fs::exists(options.out / "bake.parts"));
  EXPECT_TRUE(fs::exists(options.out / "report.html"));
  const nlohmann::json json = report();
  EXPECT_EQ(json["muscles"].size(), 1u);
  EXPECT_EQ(json["frames"].size(), 24u);

  // The volume again, from the file.
  const BakeReader reader(options.out / "bake.h5");
  const BakeMesh& mesh = reader.info().meshes.at(0);
  const double volume = enclosed_volume(to_points(mesh.rest.vertices), mesh.rest.triangles);
  for (int i = 0; i < 24; ++i) {
    const Points x = to_points(reader.read(i).positions.at(0));
    EXPECT_NEAR(enclosed_volume(x, mesh.rest.triangles) / volume, 1.0, 1e-12);
  }
}

TEST_F(Command, ThreadsAndRepetitionChangeNoByte) {
  bake_command(options);
  const std::string hash = report()["hash"];
  options.out = folder / "two";
  options.threads = 2;
  bake_command(options);
  EXPECT_EQ(report()["hash"], hash);
}

TEST_F(Command, AChosenStepOfFramesIsThatOfTheWholeBake) {
  bake_command(options);
  const BakeReader whole(options.out / "bake.h5");
  const BakeFrame ninth = whole.read(8);
  options.out = folder / "some";
  options.frames = "1-24x4";
  bake_command(options);
  const BakeReader some(options.out / "bake.h5");
  EXPECT_EQ(some.info().frames, (std::vector<int>{1, 5, 9, 13, 17, 21}));
  const BakeFrame same = some.read(2);
  for (size_t i = 0; i < ninth.positions[0].size(); ++i) {
    EXPECT_EQ(same.positions[0][i], ninth.positions[0][i]);
  }
}

TEST_F(Command, ASecondBakeWithResumeDoesNothing) {
  bake_command(options);
  const auto written = fs::last_write_time(options.out / "bake.h5");
  options.resume = true;
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_EQ(fs::last_write_time(options.out / "bake.h5"), written);
}

TEST_F(Command, AReportThatAKillTookIsMadeFromTheCache) {
  bake_command(options);
  const nlohmann::json before = report();
  fs::remove(options.out / "report.json");
  options.resume = true;
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  nlohmann::json after = report();
  for (const char* key : {"hash", "muscles", "bounds", "frames"})
    EXPECT_EQ(after[key], before[key]);
}

TEST_F(Command, MusclesThatOverlapAtRestAreWarnedOf) {
  options.input = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  options.frames = "1";
  options.overrides = {"muscle.side.path.0.3=0.016", "muscle.side.path.1.3=0.016"};
  bake_command(options);
  const std::string warnings = report()["warnings"].dump();
  EXPECT_NE(warnings.find("overlap at rest"), std::string::npos) << warnings;
}

TEST_F(Command, WhatATolerancesFirstChoiceMissedIsWarnedOfBesideTheModels) {
  options.input = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  options.frames = "1";
  options.overrides = {"scene.settle=0", "solver.tolerance={ position = \"2 mm\" }"};
  bake_command(options);
  const nlohmann::json raised = report()["solver"]["fidelity"]["raised"];
  const nlohmann::json warnings = report()["warnings"];
  ASSERT_EQ(raised.size(), 2u) << raised;
  ASSERT_EQ(warnings.size(), 3u) << warnings;
  EXPECT_NE(warnings[0].get<std::string>().find("overlap at rest"), std::string::npos) << warnings;
  for (size_t i = 0; i < raised.size(); ++i) {
    EXPECT_EQ(warnings[1 + i], "solver.tolerance: " + raised[i].get<std::string>());
  }
}

// The cache's float32 is off by more than the solver is: the bound holds for what is written, the
// report states both, and thew inspect finds the very figure in the file.
TEST_F(Command, ABoundIsOnWhatIsWritten) {
  options.overrides = {"output.precision=single", "bound.volume_error=1e-12"};
  EXPECT_EQ(bake_command(options), ExitCode::kDifferent);
  const nlohmann::json json = report(), muscle = json["muscles"][0];
  EXPECT_LE(muscle["max_volume_error"].get<double>(), 1e-13);
  const double written = muscle["max_volume_error_written"];
  EXPECT_GT(written, 1e-9);
  EXPECT_EQ(json["bounds"][0]["measured"], written);
  EXPECT_EQ(json["bounds"][0]["met"], false);
  const nlohmann::json found =
      nlohmann::json::parse(inspect(options.out / "bake.h5", true).text)["meshes"][0];
  EXPECT_EQ(found["max_volume_error_written"], written);
  options.overrides = {"output.precision=double", "bound.volume_error=1e-12"};
  options.out = folder / "double";
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_LE(report()["muscles"][0]["max_volume_error_written"].get<double>(), 1e-13);
}

// Of a bake without a metric that this version measures nothing is said, least of all 0.
TEST_F(Command, ABakeOfAnotherVersionIsRefusedByName) {
  bake_command(options);
  const BakeReader reader(options.out / "bake.h5");
  const Model model = build_model(read_scene(options.input));
  std::vector<std::string> names = reader.info().metric_names;
  std::vector<double> numbers = reader.read(3).metrics;
  EXPECT_GT(unflatten(model, names, numbers).muscles[0].length, 0.1);
  const auto lost = std::find(names.begin(), names.end(), "volume_error_written/flexor");
  ASSERT_NE(lost, names.end());
  numbers.erase(numbers.begin() + (lost - names.begin()));
  names.erase(lost);
  try {
    unflatten(model, names, numbers);
    ADD_FAILURE() << "read as 0";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_NE(std::string(error.what()).find("volume_error_written/flexor"), std::string::npos);
  }
}

// With pictures, a skin, settling and a report: no stage without a name, none counted twice.
TEST_F(Command, TheStagesMakeUpTheTotal) {
  const auto expect_whole_by = [&](const char* clock) {
    nlohmann::json seconds = report()[clock];
    const double total = seconds["total"];
    seconds.erase("total");
    double sum = 0.0;
    for (const auto& [stage, time] : seconds.items()) {
      EXPECT_GE(time.get<double>(), 0.0) << stage;
      sum += time.get<double>();
    }
    EXPECT_GE(sum, 0.98 * total) << seconds;
    EXPECT_LE(sum, 1.001 * total) << seconds;
  };
  const auto expect_whole = [&] {
    expect_whole_by("seconds");
    expect_whole_by("cpu_seconds");
  };
  options.input = THEW_SOURCE_DIR "/assets/arm/arm.toml";
  options.frames = "1-6";
  options.pictures = true;
  options.threads = 2;
  options.overrides = {"render.size=[160, 90]"};
  bake_command(options);
  expect_whole();
  EXPECT_GT(report()["seconds"]["settle"], 0.0);
  EXPECT_GT(report()["seconds"]["measure"], 0.0);
  EXPECT_NE(report()["origin"]["renderer"], "none");
  fs::remove(options.out / "report.json");
  options.resume = true;
  bake_command(options);
  expect_whole();
}

TEST_F(Command, TheReportSaysWhereItComesFromAndTheCacheDoesNot) {
  setenv("SOURCE_DATE_EPOCH", "1700000000", 1);
  options.command = "thew bake scene.toml --out 'a folder'";
  options.directory = "/a show";
  options.commit = "0123abc";
  bake_command(options);
  const nlohmann::json from = report()["origin"];
  EXPECT_EQ(from["scene"], options.input.lexically_normal().string());
  EXPECT_EQ(from["scene_hash"], BakeReader(options.out / "bake.h5").info().scene_hash);
  EXPECT_EQ(from["command"], options.command);
  EXPECT_EQ(from["directory"], "/a show");
  EXPECT_EQ(from["commit"], "0123abc");
  EXPECT_EQ(from["date"], "2023-11-14T22:13:20Z");
  EXPECT_NE(from["host"], "");
  EXPECT_EQ(from["renderer"], "none");
  const std::string bytes = read_whole_file(options.out / "bake.h5", std::size_t{1} << 26);
  unsetenv("SOURCE_DATE_EPOCH");
  options.command = options.commit = "other";
  options.out = folder / "elsewhere";
  bake_command(options);
  EXPECT_NE(report()["origin"]["date"], from["date"]);
  EXPECT_EQ(read_whole_file(options.out / "bake.h5", std::size_t{1} << 26), bytes);
}

TEST_F(Command, ADryRunWritesNothing) {
  options.dry_run = true;
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  EXPECT_FALSE(fs::exists(options.out));
}

TEST_F(Command, ABoundThatIsNotMetFailsTheBake) {
  options.overrides = {"solver.volume=none", "bound.volume_error=1e-9"};
  EXPECT_EQ(bake_command(options), ExitCode::kDifferent);
  EXPECT_GT(report()["muscles"][0]["max_volume_error"].get<double>(), 1e-4);
}

// Of each quantity the largest over frames and muscles, as the cache has it, and where it was.
TEST_F(Command, TheReportSaysWhereEachQuantityIsWorst) {
  bake_command(options);
  const BakeReader reader(options.out / "bake.h5");
  const auto& names = reader.info().metric_names;
  const nlohmann::json worst = report()["worst"];
  std::set<int> frames;
  const char* metrics[] = {"volume_error_written", "substep_volume_error", "attachment_gap"};
  for (size_t k = 0; k < 3; ++k) {
    const auto at = std::find(names.begin(), names.end(), std::string(metrics[k]) + "/flexor");
    double most = 0.0;
    int frame = 1;
    for (int i = 0; i < 24; ++i) {
      const double value = reader.read(i).metrics.at(at - names.begin());
      if (value > most) most = value, frame = reader.info().frames[i];
    }
    EXPECT_EQ(worst[k]["measured"], most) << metrics[k];
    EXPECT_EQ(worst[k]["frame"], frame) << metrics[k];
    frames.insert(frame);
  }
  EXPECT_EQ(worst[0]["quantity"], "volume_error");
  EXPECT_EQ(worst[0]["part"], "flexor");
  EXPECT_GT(*frames.rbegin(), 1);
  EXPECT_EQ(worst[4]["quantity"], "poke_through");  // it has no skin
  EXPECT_EQ(worst[4]["measured"], 0.0);
  EXPECT_EQ(worst[4]["part"], "");
  options.input = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  options.out = folder / "skinned";
  options.frames = "1-2";
  bake_command(options);
  EXPECT_EQ(report()["worst"][4]["part"], "skin");
  EXPECT_GT(report()["worst"][4]["measured"], 5e-3);
  EXPECT_EQ(report()["worst"][4]["measured"], report()["skin"]["max_poke_through_m"]);
}

TEST_F(Command, BothIntegratorsHoldTheVolume) {
  options.overrides = {"solver.integrator=explicit"};
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  const nlohmann::json muscle = report()["muscles"][0];
  EXPECT_LE(muscle["max_volume_error"].get<double>(), 1e-12);
  EXPECT_LE(muscle["max_substep_volume_error"].get<double>(), 1e-5);
}

TEST_F(Command, AJointThatTheRigLacks) {
  edit("elbow = [", "elbw = [");
  expect_error(ErrorCode::kInput, "elbow");
}

TEST_F(Command, AClipBeyondTheJointsRange) {
  edit("[24, 60]", "[24, 600]");
  expect_error(ErrorCode::kInput, "elbow");
}

TEST_F(Command, ABodyThatTheRigLacks) {
  edit("[\"ulna\", 0.03", "[\"ulma\", 0.03");
  expect_error(ErrorCode::kUsage, "did you mean \"ulna\"");
}

TEST_F(Command, AllWeightsZero) {
  edit("weights = \"left\"", "weights = { profile = [[0, 0], [1, 0]] }");
  expect_error(ErrorCode::kUsage, "weights");
}

TEST_F(Command, AnUnknownKey) {
  edit("belly =", "bely =");
  expect_error(ErrorCode::kUsage, "did you mean \"belly\"");
}

TEST_F(Command, ATwistBeyondThePath) {
  edit("weights = \"left\"", "weights = \"left\"\ntwist_from = 9");
  expect_error(ErrorCode::kUsage, "twist_from lies beyond the path");
}

TEST_F(Command, AMeshWithOneTriangleMissing) {
  edit(
      "[muscle.profile]\naround = 12\nrings = 11\nradius = [[0, 0.004], [0.2, 0.006], [0.5, "
      "0.018], "
      "[0.8, 0.006], [1, 0.004]]",
      "mesh = \"open.obj\"");
  write("scene/open.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  expect_error(ErrorCode::kInput, "open");
}

TEST_F(Command, AnOutputThatCannotBeWritten) {
  write("file", "");
  options.out = folder / "file" / "out";
  expect_error(ErrorCode::kOutput, "file");
}

}  // namespace
}  // namespace thew::tests
