// SPDX-License-Identifier: Apache-2.0
//
// Pictures of a bake by views without its scene.
#include <gtest/gtest.h>

#include <algorithm>

#include "sim/framing.h"
#include "sim/scene/reader.h"
#include "tests/unit/tools/cli/command.h"
#include "tools/render/camera.h"
#include "tools/render/image.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class CommandViews : public OneMuscleCommand {};

// Of half the width or height of a picture of 64 x 48 pixels.
double farthest_of(const std::vector<Vec3>& points, const SceneView& view) {
  const Camera camera = make_camera(view, 64.0 / 48.0, {});
  double farthest = 0.0;
  for (const Vec3& p : points) {
    const Vec3 seen = camera.view_from_world * p;
    farthest = std::max({farthest, std::abs(seen.x() / seen.z()) / camera.tan_x,
                         std::abs(seen.y() / seen.z()) / camera.tan_y});
  }
  return farthest;
}

// A file of views alone shows each bake whole, whatever its size and place.
TEST_F(CommandViews, AViewWithoutARigFramesWhatIsDrawn) {
  options.frames = "1-3";
  bake_command(options);
  const BakeReader reader(options.out / "bake.h5");
  const std::string text =
      "[render]\nsize = [64, 48]\n[[render.view]]\nname = \"front\"\nshow = \"muscles\"\nfrom = "
      "[0.3, 0.2, 1]\n";
  const fs::path file = write("front.toml", text);
  const SceneRender render = read_render(file, {});
  for (const std::vector<int>& frames : {std::vector<int>{2}, {1, 2, 3}}) {
    const SceneView view = frame_views(reader, frames, render).at(0);
    EXPECT_LT((view.eye - view.target).normalized().cross(view.from.normalized()).norm(), 1e-9);
    double farthest = 0.0;
    for (const int frame : frames) {
      for (const std::vector<Vec3>& mesh : reader.read(frame - 1).positions) {
        farthest = std::max(farthest, farthest_of(mesh, view));
      }
    }
    EXPECT_NEAR(farthest, kFill, 1e-9);
  }
  CommandOptions draw = options;
  draw.input = options.out / "bake.h5";
  draw.out = folder / "drawn";
  draw.frames = "2";
  EXPECT_EQ(render_command(draw, file), ExitCode::kDone);
  EXPECT_TRUE(fs::exists(draw.out / "front.0002.png"));
  draw.out = folder / "followed";
  try {
    render_command(draw, write("follow.toml", text + "follow = \"hand\"\n"));
    ADD_FAILURE() << "followed a body that no bake has";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    EXPECT_NE(std::string(error.what()).find("give the bake's scene"), std::string::npos);
  }
}

// So the muscles of a whole figure are not a spot in its picture.
TEST_F(CommandViews, EachViewWithoutARigFramesWhatItShows) {
  options.input = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  options.frames = "1";
  bake_command(options);
  const BakeReader reader(options.out / "bake.h5");
  std::string text = "[render]\nsize = [64, 48]\n";
  for (const char* show : {"skin", "muscles", "weights"}) {
    text += std::string("[[render.view]]\nname = \"") + show + "\"\nfrom = [0.3, 0.2, 1]\n";
  }
  const std::vector<int> frames = {1};
  for (const SceneView& view :
       frame_views(reader, frames, read_render(write("views.toml", text), {}))) {
    double farthest = 0.0;
    const BakeFrame frame = reader.read(0);
    for (size_t m = 0; m < frame.positions.size(); ++m) {
      const bool is_skin = reader.info().meshes[m].kind == BakeMesh::Kind::kSkin;
      if (is_skin == (view.name == "skin")) {
        farthest = std::max(farthest, farthest_of(frame.positions[m], view));
      }
    }
    EXPECT_NEAR(farthest, kFill, 1e-9) << view.name;
  }
}

TEST_F(CommandViews, ATurntableGoesRoundOneFrame) {
  options.frames = "1-2";
  bake_command(options);
  CommandOptions turn = options;
  turn.input = options.out / "bake.h5";
  turn.out = folder / "turn";
  turn.frames = "2";
  const fs::path views =
      write("views.toml",
            "[render]\nsize = [64, 64]\n[[render.view]]\nname = \"front\"\nshow = "
            "\"muscles\"\neye = [0.1, -0.1, 1]\ntarget = [0, -0.1, 0]\n");
  EXPECT_EQ(render_command(turn, views, 4), ExitCode::kDone);
  std::vector<Image> images;
  for (const char* number : {"1", "2", "3", "4"}) {
    images.push_back(read_png(turn.out / ("front_turn.000" + std::string(number) + ".png")));
  }
  EXPECT_NE(images[0].rgb, images[2].rgb);
  // The first is the view itself, as it is drawn without turning.
  turn.out = folder / "straight";
  render_command(turn, views);
  EXPECT_EQ(read_png(turn.out / "front.0002.png").rgb, images[0].rgb);
  // A key that no scene is there for is not ignored.
  turn.overrides = {"render.size=[32, 32]"};
  EXPECT_THROW(render_command(turn, {}), Error);
  turn.overrides.clear();
  turn.frames = "1-2";
  try {
    render_command(turn, views, 4);
    ADD_FAILURE() << "turned about two frames";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
  }
}

}  // namespace
}  // namespace thew::tests
