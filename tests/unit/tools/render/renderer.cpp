// SPDX-License-Identifier: Apache-2.0
#include "tools/render/renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "tests/unit/tools/render/ball.h"

namespace thew::tests {
namespace {

using Positions = std::vector<std::vector<Vec3>>;

constexpr int kWidth = 160, kHeight = 120;

std::vector<BakeMesh> small_scene() {
  return {ball("biceps", BakeMesh::Kind::kMuscle, Vec3(-0.03, 0, 0), 0.03, 4.0),
          ball("triceps", BakeMesh::Kind::kMuscle, Vec3(0.03, 0, 0), 0.03, 4.0),
          ball("bone", BakeMesh::Kind::kBone, Vec3(0, 0, -0.02), 0.012, 12.0),
          ball("skin", BakeMesh::Kind::kSkin, Vec3::Zero(), 0.08, 2.0)};
}

Positions rest_of(const std::vector<BakeMesh>& meshes) {
  Positions positions;
  for (const BakeMesh& mesh : meshes) positions.push_back(mesh.rest.vertices);
  return positions;
}

SceneView view_of(const char* show) {
  SceneView view;
  view.name = view.show = show;
  view.eye = Vec3(0.1, 0.15, 0.8);
  return view;
}

struct Pixel {
  int r, g, b;
  int warmth() const { return r - b; }  // the background has none
};

Pixel pixel(const Image& image, int x, int y) {
  const std::uint8_t* p = &image.rgb[3ul * (image.width * y + x)];
  return {p[0], p[1], p[2]};
}

int count(const Image& image, auto&& condition) {
  int number = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) number += condition(pixel(image, x, y));
  }
  return number;
}

std::optional<ErrorCode> code_of(auto&& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.code();
  }
  return std::nullopt;
}

TEST(Renderer, ABallsSilhouetteIsWhereProjectionSays) {
  const Vec3 centre(0.07, -0.03, 0.02);
  const double radius = 0.1;
  const std::vector<BakeMesh> meshes = {
      ball("ball", BakeMesh::Kind::kSkin, centre, radius, 1.0, 48, 31)};
  SceneView view = view_of("skin");
  view.target = Vec3(0.02, 0.01, 0);
  const Image image = Renderer(kWidth, kHeight, meshes).draw(view, rest_of(meshes));
  const Vec3 back = (view.eye - view.target).normalized();
  const Vec3 right = view.up.cross(back).normalized(), up = back.cross(right);
  const double scale = std::tan(0.5 * view.field_of_view * kDegree) / (0.5 * kHeight);
  int inside = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const Vec3 ray =
          (scale * (x + 0.5 - 0.5 * kWidth) * right + scale * (0.5 * kHeight - y - 0.5) * up - back)
              .normalized();
      const Vec3 to_centre = centre - view.eye;
      // Distance between ray and surface, in pixels at the ball; a pixel's corner is 0.71 away.
      const double outside =
          ((to_centre - to_centre.dot(ray) * ray).norm() - radius) / (scale * -to_centre.dot(back));
      const bool drawn = pixel(image, x, y).warmth() > 10;
      inside += outside < -1.0;
      if (std::abs(outside) > 1.0) {
        EXPECT_EQ(drawn, outside < 0) << "pixel " << x << ", " << y << ", outside by " << outside;
      }
    }
  }
  EXPECT_GT(inside, 1000);
}

TEST(Renderer, TheSameFrameGivesTheSameBytes) {
  const std::vector<BakeMesh> meshes = small_scene();
  const Positions positions = rest_of(meshes);
  Renderer one(kWidth, kHeight, meshes), other(kWidth, kHeight, meshes);
  for (const char* show : {"skin", "muscles", "weights"}) {
    const Image image = one.draw(view_of(show), positions);
    EXPECT_EQ(one.draw(view_of(show), positions).rgb, image.rgb) << show << ", drawn again";
    EXPECT_EQ(other.draw(view_of(show), positions).rgb, image.rgb) << show << ", drawn anew";
  }
}

// It clears, sends and casts only what the picture before did not leave as it is wanted.
TEST(Renderer, WhatWasDrawnBeforeIsNotSeen) {
  const std::vector<BakeMesh> meshes = small_scene();
  Renderer renderer(kWidth, kHeight, meshes);
  Positions positions = rest_of(meshes);
  const auto move = [&](std::size_t mesh, const Vec3& by) {
    for (Vec3& p : positions[mesh]) p += by;
  };
  const auto expect_as_anew = [&](const SceneView& view, const char* what) {
    EXPECT_EQ(renderer.draw(view, positions).rgb,
              Renderer(kWidth, kHeight, meshes).draw(view, positions).rgb)
        << what;
  };
  SceneView view = view_of("muscles"), cut = view_of("cutaway"), close = view_of("weights");
  cut.cut = {{1, 0, 0, 0}};
  close.eye = Vec3(0.05, 0.0, 0.03);  // among the muscles
  expect_as_anew(view, "first");
  move(0, Vec3(-0.1, 0.05, 0));
  expect_as_anew(view, "one muscle aside");
  expect_as_anew(view_of("weights"), "the same shadow");
  expect_as_anew(close, "over the whole picture");
  expect_as_anew(view_of("skin"), "another shadow");
  expect_as_anew(cut, "a window");
  cut.cut = {{-1, 0, 0, 0}};
  expect_as_anew(cut, "another window");
  move(0, Vec3(0.1, -0.05, 0));
  move(2, Vec3(0, 0, 0.06));
  view.eye.x() += 0.1;
  expect_as_anew(view, "bone before muscle, from another side");
  for (std::size_t m = 0; m < meshes.size(); ++m) move(m, Vec3(0.9, 0, 0));
  expect_as_anew(view, "out of sight");
}

// Far out, where a float is coarse.
TEST(Renderer, DrawsWhatACacheOfSinglePrecisionHolds) {
  const std::vector<BakeMesh> meshes = small_scene();
  SceneView view = view_of("muscles");
  const Vec3 far(1e4, 0.0, 0.0);
  view.eye += far;
  view.target += far;
  Positions positions = rest_of(meshes);
  for (auto& mesh : positions) {
    for (Vec3& p : mesh) p += far;
  }
  Renderer renderer(kWidth, kHeight, meshes);
  const Image image = renderer.draw(view, positions);
  for (auto& mesh : positions) {
    for (Vec3& p : mesh) {
      for (double& value : p) value = static_cast<float>(value);
    }
  }
  EXPECT_EQ(renderer.draw(view, positions).rgb, image.rgb);
}

// The ground is seen about what stands on it, wherever a camera has gone along to.
TEST(Renderer, TheGroundGoesAlongWithTheCamera) {
  const std::vector<BakeMesh> meshes = small_scene();
  SceneView view = view_of("skin");
  Positions positions = rest_of(meshes);
  Renderer renderer(kWidth, kHeight, meshes);
  const Image before = renderer.draw(view, positions);
  const Vec3 step(1.0, 0.0, -0.5);
  view.eye += step, view.target += step;
  for (auto& mesh : positions) {
    for (Vec3& p : mesh) p += step;
  }
  const auto change = [&] {
    const Image now = renderer.draw(view, positions);
    long sum = 0;
    for (std::size_t i = 0; i < now.rgb.size(); ++i) sum += std::abs(now.rgb[i] - before.rgb[i]);
    return sum;
  };
  const long left_behind = change();
  view.moved = step;
  EXPECT_LT(20 * change(), left_behind);
}

TEST(Renderer, ShowsOtherMeshesInAnotherSizeAsANewOneWould) {
  const std::vector<BakeMesh> meshes = small_scene();
  const std::vector<BakeMesh> one = {ball("ball", BakeMesh::Kind::kSkin, Vec3::Zero(), 0.05)};
  Renderer renderer(kWidth, kHeight, meshes);
  const Image image = renderer.draw(view_of("weights"), rest_of(meshes));
  renderer.show(kWidth / 2, kHeight, one);
  EXPECT_EQ(renderer.draw(view_of("skin"), rest_of(one)).rgb,
            Renderer(kWidth / 2, kHeight, one).draw(view_of("skin"), rest_of(one)).rgb);
  renderer.show(kWidth, kHeight, meshes);
  EXPECT_EQ(renderer.draw(view_of("weights"), rest_of(meshes)).rgb, image.rgb);
}

TEST(Renderer, TheOrderOfMeshesChangesNothing) {
  std::vector<BakeMesh> meshes = small_scene();
  const Image image = Renderer(kWidth, kHeight, meshes).draw(view_of("muscles"), rest_of(meshes));
  std::reverse(meshes.begin(), meshes.end());
  EXPECT_EQ(Renderer(kWidth, kHeight, meshes).draw(view_of("muscles"), rest_of(meshes)).rgb,
            image.rgb);
}

TEST(Renderer, EachViewShowsWhatItSays) {
  const std::vector<BakeMesh> meshes = small_scene();
  Renderer renderer(kWidth, kHeight, meshes);
  const auto is_red = [](Pixel p) { return p.r > 70 && p.g * 2 < p.r; };
  const auto is_ink = [](Pixel p) { return std::max({p.r, p.g, p.b}) < 90; };
  const Image skin = renderer.draw(view_of("skin"), rest_of(meshes));
  const Image muscles = renderer.draw(view_of("muscles"), rest_of(meshes));
  const Image weights = renderer.draw(view_of("weights"), rest_of(meshes));
  EXPECT_EQ(count(skin, is_red), 0) << "muscle shows through the skin";
  EXPECT_GT(count(muscles, is_red), 300);
  EXPECT_NE(weights.rgb, muscles.rgb);
  std::vector<BakeMesh> without = meshes;  // zero, so that their colour is that of the tendons
  for (BakeMesh& mesh : without) std::fill(mesh.weights.begin(), mesh.weights.end(), 0.0);
  const Image bare = Renderer(kWidth, kHeight, without).draw(view_of("weights"), rest_of(without));
  EXPECT_GT(count(weights, is_ink), count(bare, is_ink) + 50) << "no segments along the normals";
  // The target lies behind both: between the muscles there is bone, which is pale and warm.
  EXPECT_GT(
      count(muscles, [](Pixel p) { return p.r > 120 && p.g * 5 > p.r * 4 && p.warmth() > 14; }),
      20);
}

// Half of the skin open: there muscles are seen and its cut edge is fat; the other half is skin.
TEST(Renderer, ACutawayShowsMusclesInItsWindowAlone) {
  const std::vector<BakeMesh> meshes = small_scene();
  Renderer renderer(kWidth, kHeight, meshes);
  SceneView view = view_of("cutaway");
  view.eye = Vec3(0, 0, 0.8);
  const auto red_half = [](const Image& image, bool right) {
    int n = 0;
    for (int y = 0; y < kHeight; ++y) {
      for (int x = right ? kWidth / 2 + 2 : 0; x < (right ? kWidth : kWidth / 2 - 2); ++x) {
        const Pixel p = pixel(image, x, y);
        n += p.r > 70 && p.g * 2 < p.r;
      }
    }
    return n;
  };
  view.cut = {{1, 0, 0, 0}, {0, 0, 1, 0}};  // right of the middle, on our side
  const Image right = renderer.draw(view, rest_of(meshes));
  EXPECT_GT(red_half(right, true), 100);
  EXPECT_EQ(red_half(right, false), 0);
  view.cut = {{0, 0, 1, 10}};  // open nowhere
  EXPECT_EQ(count(renderer.draw(view, rest_of(meshes)),
                  [](Pixel p) { return p.r > 70 && p.g * 2 < p.r; }),
            0);
  // The window is of the rest pose: it goes along with the skin.
  view.cut = {{0, 0, 1, 0}};
  const Image here = renderer.draw(view, rest_of(meshes));
  Positions moved = rest_of(meshes);
  for (std::vector<Vec3>& positions : moved) {
    for (Vec3& p : positions) p.z() -= 0.05;
  }
  const auto is_red = [](Pixel p) { return p.r > 70 && p.g * 2 < p.r; };
  EXPECT_GT(count(renderer.draw(view, moved), is_red), count(here, is_red) / 2);
}

TEST(Renderer, LightComesFromWhereTheViewSays) {
  const std::vector<BakeMesh> meshes = {ball("ball", BakeMesh::Kind::kBone, Vec3::Zero(), 0.05)};
  Renderer renderer(kWidth, kHeight, meshes);
  SceneView view = view_of("muscles");
  view.eye = Vec3(0, 0, 0.4);
  const auto brightness = [&](const Vec3& light, bool right) {
    view.light = light;
    const Image image = renderer.draw(view, rest_of(meshes));
    double sum = 0.0;
    for (int x = 0; x < kWidth / 2; ++x) {
      const Pixel p = pixel(image, right ? kWidth - 1 - x : x, kHeight / 2);
      sum += p.warmth() > 10 ? p.g : 0;
    }
    return sum;
  };
  EXPECT_GT(brightness(Vec3(1, 0, 0.1), true), 1.5 * brightness(Vec3(1, 0, 0.1), false));
  EXPECT_GT(brightness(Vec3(-1, 0, 0.1), false), 1.5 * brightness(Vec3(-1, 0, 0.1), true));
}

TEST(Renderer, ABallThrowsItsShadowOnTheGround) {
  const std::vector<BakeMesh> meshes = {ball("ball", BakeMesh::Kind::kSkin, Vec3::Zero(), 0.05)};
  SceneView view = view_of("skin");
  view.eye = Vec3(0, 0.5, 0.7);
  const auto is_dark_grey = [](Pixel p) { return p.r < 205 && std::abs(p.warmth()) < 6; };
  const Image with = Renderer(kWidth, kHeight, meshes).draw(view, rest_of(meshes));
  const Image without = Renderer(kWidth, kHeight, {}).draw(view, {});
  EXPECT_EQ(count(without, is_dark_grey), 0);
  EXPECT_GT(count(with, is_dark_grey), 100);
}

TEST(Renderer, TheGroundStaysWhereItIsWhenTheMeshMoves) {
  const std::vector<BakeMesh> meshes = {ball("ball", BakeMesh::Kind::kSkin, Vec3::Zero(), 0.05)};
  Renderer renderer(kWidth, kHeight, meshes);
  SceneView view = view_of("skin");
  view.eye = Vec3(0, 0.5, 0.7);
  Positions positions = rest_of(meshes);
  const Image rest = renderer.draw(view, positions);
  for (Vec3& p : positions[0]) p += Vec3(0, 0.05, 0);
  const Image raised = renderer.draw(view, positions);
  EXPECT_NE(raised.rgb, rest.rgb);
  // The lower left is ground that the light, which comes from the left, leaves without a shadow.
  for (int y = kHeight * 3 / 4; y < kHeight; ++y) {
    for (int x = 0; x < kWidth / 4; ++x) {
      EXPECT_EQ(pixel(raised, x, y).g, pixel(rest, x, y).g) << x << ", " << y;
    }
  }
}

TEST(Renderer, NoMeshesGiveALightGreyPicture) {
  const std::vector<BakeMesh> none;
  Renderer renderer(kWidth, kHeight, none);
  const Image image = renderer.draw(view_of("skin"), {});
  ASSERT_EQ(image.rgb.size(), 3ul * kWidth * kHeight);
  EXPECT_EQ(count(image, [](Pixel p) { return p.r < 200 || std::abs(p.warmth()) > 4; }), 0);
  EXPECT_EQ(renderer.draw(view_of("muscles"), {}).rgb, image.rgb);
  EXPECT_EQ(renderer.draw(view_of("weights"), {}).rgb, image.rgb);
}

TEST(Renderer, MusclesWithoutCoordinatesOrWeightsAreDrawn) {
  std::vector<BakeMesh> meshes = small_scene();
  for (BakeMesh& mesh : meshes) mesh.coordinates.clear(), mesh.weights.clear();
  Renderer renderer(kWidth, kHeight, meshes);
  const auto is_red = [](Pixel p) { return p.r > 70 && p.g * 2 < p.r; };
  EXPECT_GT(count(renderer.draw(view_of("muscles"), rest_of(meshes)), is_red), 300);
  EXPECT_EQ(count(renderer.draw(view_of("weights"), rest_of(meshes)), is_red), 0);
}

TEST(Renderer, RefusesSizesAndViewsThatCannotBe) {
  const std::vector<BakeMesh> none;
  for (const auto& size : {std::array{15, 100}, {100, 15}, {8193, 100}, {100, 8193}, {-1, 0}}) {
    EXPECT_EQ(code_of([&] { Renderer renderer(size[0], size[1], none); }), ErrorCode::kUsage)
        << size[0] << " " << size[1];
  }
  Renderer smallest(16, 16, none);
  EXPECT_EQ(smallest.draw(view_of("skin"), {}).rgb.size(), 3ul * 16 * 16);
  EXPECT_FALSE(smallest.driver().empty());
  SceneView at_itself = view_of("skin"), along_up = view_of("skin"), narrow = view_of("skin");
  at_itself.target = at_itself.eye;
  along_up.eye = along_up.target + Vec3(0, 1, 0);
  narrow.field_of_view = 0.0;
  for (const SceneView& view : {view_of("bones"), at_itself, along_up, narrow}) {
    EXPECT_EQ(code_of([&] { smallest.draw(view, {}); }), ErrorCode::kUsage) << view.name;
  }
}

TEST(Renderer, ADriverThatIsNotThereIsAnOutputError) {
  const char* before = std::getenv("GALLIUM_DRIVER");
  const std::string kept = before ? before : "";
  setenv("GALLIUM_DRIVER", "nonsense", 1);
  EXPECT_EQ(code_of([] { Renderer renderer(16, 16, {}); }), ErrorCode::kOutput);
  before ? setenv("GALLIUM_DRIVER", kept.c_str(), 1) : unsetenv("GALLIUM_DRIVER");
}

}  // namespace
}  // namespace thew::tests
