// SPDX-License-Identifier: Apache-2.0
//
// Small changes of a scene, each found and named; noise of another processor is not.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <random>
#include <sstream>

#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"
#include "tools/render/gl_context.h"
#include "tools/render/pictures.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

using Settings = std::vector<std::string>;

class Sensitivity : public TempFolder {
 protected:
  Sensitivity() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/one_muscle", folder / "scene");
    scene = folder / "scene/scene.toml";
  }
  fs::path bake(const std::string& name, const Settings& settings = {},
                const std::string& frames = "") const {
    CommandOptions options;
    options.input = scene;
    options.out = folder / name;
    options.overrides = settings;
    options.frames = frames;
    options.progress = "none";
    options.threads = 1;
    options.pictures = false;
    EXPECT_EQ(bake_command(options), ExitCode::kDone);
    return options.out / "bake.h5";
  }
  std::string told(const fs::path& a, const fs::path& b) const {
    const Comparison comparison = compare(a, b, {});
    EXPECT_FALSE(comparison.same());
    return comparison_as_text(comparison);
  }

  fs::path scene;
};

TEST_F(Sensitivity, AStiffnessChangedByOnePercent) {
  const fs::path a = bake("a"), b = bake("b", {"muscle.flexor.material.stiffness=1010"});
  const std::string text = told(a, b);
  EXPECT_HAS(text, "scene or inputs differ as well");
  EXPECT_HAS(text, "  flexor moved 0.000");
  EXPECT_HAS(text, " mm in frame ");
  // Also by goldens, which are float32.
  const std::string rounded =
      told(bake("c", {"output.precision=single", "bound.0.volume_error=1e-6"}), b);
  EXPECT_HAS(rounded, "  flexor moved 0.000");
}

TEST_F(Sensitivity, OneWeightMoved) {
  const fs::path a = bake("a");
  const BakeReader reader(a);
  const std::vector<double>& weights = reader.info().meshes[0].weights;
  const auto write_weights = [&](const std::string& name, double change) {
    std::ostringstream text;
    text.precision(17);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      text << weights[i] + (i == 60 ? change : 0.0) << "\n";
    }
    write("scene/" + name, text.str());
    return "muscle.flexor.weights={ file = \"" + name + "\" }";
  };
  const std::string text =
      told(bake("b", {write_weights("b.txt", 0.0)}), bake("c", {write_weights("c.txt", 0.1)}));
  EXPECT_HAS(text, "flexor: the weight of vertex 60 is ");
  EXPECT_HAS(text, "  flexor moved ");

  // The page shows both where they are farthest apart, though there are no pictures of them.
  CommandOptions options;
  options.out = folder / "page.html";
  testing::internal::CaptureStdout();
  EXPECT_EQ(compare_command(folder / "b/bake.h5", folder / "c/bake.h5", options, {}),
            ExitCode::kDifferent);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), text);
  std::ifstream in(options.out);
  const std::string page((std::istreambuf_iterator<char>(in)), {});
  EXPECT_HAS(page, "<h2>weights.00");
  EXPECT_HAS(page, "class=\"difference\"");
}

TEST_F(Sensitivity, AMissingFrame) {
  EXPECT_HAS(told(bake("a"), bake("b", {}, "1-16,18-24")), "  frame 17 is missing\n");
}

class Camera : public Sensitivity {
 protected:
  static constexpr int kWidth = 320, kHeight = 180;

  Camera() { choose_driver("softpipe"); }

  // Draws frame 12, the camera moved to the right by so many pixels at its target.
  Image draw(const BakeReader& reader, double pixels) const {
    SceneView view = views_of(reader).front();
    const Vec3 sight = view.target - view.eye;
    // tan 15 degrees; up to the half height
    const double pixel = 2.0 * 0.2679492 * sight.norm() / kHeight;
    const Vec3 nudge = pixels * pixel * sight.cross(view.up).normalized();
    view.eye += nudge;
    view.target += nudge;
    return Renderer(kWidth, kHeight, reader.info().meshes).draw(view, reader.read(11).positions);
  }
};

TEST_F(Camera, ANudgeOfHalfAPixel) {
  const BakeReader reader(bake("a"));
  const Image still = draw(reader, 0.0), again = draw(reader, 0.0), moved = draw(reader, 0.5);
  EXPECT_TRUE(still.renderer.starts_with("softpipe, ")) << still.renderer;
  EXPECT_EQ(still.rgb, again.rgb);
  write_png(folder / "still.png", still);
  write_png(folder / "moved.png", moved);
  const std::string text = told(folder / "still.png", folder / "moved.png");
  EXPECT_HAS(text, " % of the pixels changed, 0.1 % allowed");
  const Comparison comparison = compare(folder / "still.png", folder / "moved.png", {});
  EXPECT_HAS(text, ", as if shifted by (-0.5");
  EXPECT_NEAR(comparison.images[0].measures.shift_x, -0.5, 0.1);
  EXPECT_NEAR(comparison.images[0].measures.shift_y, 0.0, 0.1);
}

TEST_F(Camera, TheDriverIsTheOneChosenOrNone) {
  const BakeReader reader(bake("a"));
  draw(reader, 0.0);
  choose_driver("llvmpipe");  // too late
  try {
    draw(reader, 0.0);
    ADD_FAILURE() << "drawn by another driver";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kOutput);
    EXPECT_HAS(std::string(error.what()), "asked for llvmpipe, Mesa gives softpipe");
  }
}

TEST_F(Camera, NoiseOfAnotherProcessorIsNoAlarm) {
  const BakeReader reader(bake("a"));
  const Image clean = draw(reader, 0.0);
  Image noisy = clean;
  std::mt19937 random(7);
  for (int pixel = 0; pixel + 1000 <= kWidth * kHeight; pixel += 1000) {
    std::uint8_t& value = noisy.rgb[3ul * (pixel + random() % 1000) + random() % 3];
    value = static_cast<std::uint8_t>(value < 128 ? value + 3 : value - 3);
  }
  write_png(folder / "a/x.0001.png", clean);
  fs::create_directories(folder / "b");
  write_png(folder / "b/x.0001.png", noisy);
  fs::remove(folder / "a/bake.h5");
  const Comparison comparison = compare(folder / "a", folder / "b", {});
  EXPECT_TRUE(comparison.same()) << comparison_as_text(comparison);
  EXPECT_EQ(comparison.images[0].measures.largest, 3);
}

}  // namespace
}  // namespace thew::tests
