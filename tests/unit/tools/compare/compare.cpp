// SPDX-License-Identifier: Apache-2.0
//
// What `thew compare` says of bakes and folders that differ in one thing each.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "tests/unit/rig/temp.h"
#include "tests/unit/sim/cache_bake.h"
#include "tools/base/text.h"
#include "tools/cli/commands.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Compare : public TempFolder {
 protected:
  // Bakes `info` into a folder of that name.
  template <typename Change>
  fs::path bake(const std::string& name, const BakeInfo& info, Change change) const {
    BakeWriter writer(folder / name, info, false);
    for (const int number : info.frames) {
      BakeFrame frame = small_frame(info, number);
      change(frame);
      writer.write(frame);
    }
    writer.pack();
    return folder / name;
  }
  fs::path bake(const std::string& name, const BakeInfo& info) const {
    return bake(name, info, [](BakeFrame&) {});
  }
  std::string told(const fs::path& a, const fs::path& b, const CompareOptions& options = {}) const {
    const Comparison comparison = compare(a, b, options);
    return (comparison.same() ? "same " : "different ") + comparison_as_text(comparison);
  }
  void picture(const std::string& name, int level, const std::string& renderer = "painter 1",
               int width = 32) const {
    fs::create_directories((folder / name).parent_path());
    write_png(folder / name,
              {width, 16, std::vector<std::uint8_t>(3ul * width * 16, level), renderer});
  }

  const BakeInfo info = small_info(true);
};

TEST_F(Compare, ABakeIsItselfAndItsFloat32) {
  const fs::path a = bake("a", info);
  EXPECT_HAS(told(a, a), "same geometry: the same to the bit, 4 frames");
  const fs::path rounded = bake("f", small_info(false));
  const std::string within =
      "same geometry: the same within 0.0001 mm, 4 frames (largest distance ";
  EXPECT_HAS(told(a, rounded), within + "0 mm, both rounded to float32)");
  // Against float32 the other side is rounded alike: even 9 km away, and with no tolerance.
  const auto far_away = [](BakeFrame& frame) {
    for (auto& mesh : frame.positions) {
      for (Vec3& p : mesh) p.x() += 9e3;
    }
  };
  CompareOptions exact;
  exact.distance = 0.0;
  EXPECT_HAS(told(bake("b", info, far_away), bake("c", small_info(false), far_away), exact),
             "same geometry: the same within 0 mm, 4 frames (largest distance 0 mm, both rounded");
}

// What is within the tolerance is not yet the same: not by one bit of a position, nor a rest shape
// or a weight beside positions that are.
TEST_F(Compare, TheSameToTheBitIsSaidOfNothingElse) {
  const fs::path a = bake("a", info);
  const fs::path nearly = bake("b", info, [](BakeFrame& frame) {
    double& y = frame.positions[1][3].y();
    if (frame.frame == 2) y = std::nextafter(y, 1.0);
  });
  EXPECT_HAS(told(a, nearly), "same geometry: the same within 0.0001 mm, 4 frames (largest dist");
  EXPECT_EQ(told(a, nearly).find("bit"), std::string::npos);
  BakeInfo other = info;
  other.meshes[0].rest.vertices[0].x() += 1e-12;
  EXPECT_FALSE(compare(a, bake("c", other), {}).geometry->exact);
  other = info;
  ASSERT_FALSE(other.meshes[1].weights.empty());
  other.meshes[1].weights[0] += 1e-9;
  EXPECT_FALSE(compare(a, bake("d", other), {}).geometry->exact);
  EXPECT_TRUE(compare(a, bake("e", info), {}).geometry->exact);
}

TEST_F(Compare, ALimitThatIsNoNumberIsRefused) {
  const fs::path a = bake("a", info);
  const double none = std::nan("");
  for (const double value : {none, -1.0, 1e300, HUGE_VAL, -HUGE_VAL}) {
    for (const int which : {0, 1, 2, 3, 4}) {
      CompareOptions options;
      if (which == 0) options.distance = value;
      if (which == 1) options.limits.share = value;
      if (which == 2) options.limits.rmse = value;
      if (which == 3) options.limits.ssim = value == -1.0 ? none : value;
      if (which == 4) options.limits.flip = value;
      try {
        compare(a, a, options);
        ADD_FAILURE() << which << " took " << value;
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kUsage) << error.what();
        EXPECT_HAS(std::string(error.what()), "; give a number from ");
      }
    }
  }
}

TEST_F(Compare, AVertexThatMovedIsNamedWithFrameAndMillimetres) {
  const fs::path a = bake("a", info);
  const fs::path b = bake("b", info, [](BakeFrame& frame) {
    if (frame.frame == 2) frame.positions[1][3] += Vec3(0, 0.00012, 0);
  });
  EXPECT_HAS(told(a, b), "different geometry differs, though scene and inputs are the same");
  EXPECT_HAS(told(a, b), "biceps moved 0.12 mm in frame 2 (vertex 3; ");
  EXPECT_HAS(told(a, b), "1 of 4 frames");
  const GeometryComparison geometry = *compare(a, b, {}).geometry;
  ASSERT_EQ(geometry.meshes.front().by_frame.size(), 4u);
  EXPECT_NEAR(geometry.meshes.front().by_frame[2], 0.00012, 1e-12);
  EXPECT_NEAR(geometry.meshes.front().rms, 0.00012 / 4.0, 1e-12);  // of 4 nodes in 4 frames
  EXPECT_EQ(geometry.meshes.front().by_frame[1], 0.0);

  CompareOptions lax;
  lax.distance = 0.001;
  EXPECT_HAS(told(a, b, lax), "same geometry: the same within 1 mm");
  CompareOptions others;
  others.frames = {-2, 0, 4};
  EXPECT_HAS(told(a, b, others), "same geometry");
}

TEST_F(Compare, FramesThatAreMissingOrNew) {
  BakeInfo some = info;
  some.frames = {-2, 0, 4};
  const fs::path a = bake("a", info), b = bake("b", some);
  EXPECT_HAS(told(a, b), "different");
  EXPECT_HAS(told(a, b), "frame 2 is missing");
  EXPECT_HAS(told(b, a), "frame 2 is not expected");
  EXPECT_EQ(frame_list({-3, -2, 0, 7, 8, 9}), "-3--2, 0, 7-9");
}

TEST_F(Compare, MeshesThatAreMissingNewRenamedOrSwapped) {
  const fs::path a = bake("a", info);
  BakeInfo other = info;
  other.meshes.erase(other.meshes.begin() + 1);
  EXPECT_HAS(told(a, bake("b", other)), "muscle \"biceps\" is missing");
  EXPECT_HAS(told(folder / "b", a), "muscle \"biceps\" is new");
  other = info;
  other.meshes[1].name = "brachialis";
  EXPECT_HAS(told(a, bake("c", other)), "muscle \"brachialis\" is what was called \"biceps\"");

  BakeInfo two = info;
  two.meshes.push_back(two.meshes[1]);
  two.meshes.back().name = "triceps";
  for (Vec3& p : two.meshes.back().rest.vertices) p *= 2.0;
  const fs::path d = bake("d", two);
  std::swap(two.meshes[1].name, two.meshes[3].name);
  EXPECT_HAS(told(d, bake("e", two)), "biceps and triceps are swapped");
  two.meshes[3].rest = two.meshes[1].rest;
  EXPECT_HAS(told(d, bake("f", two)), "triceps has the surface of biceps");
}

TEST_F(Compare, TopologyWeightsAndRestShape) {
  const fs::path a = bake("a", info);
  BakeInfo other = info;
  std::swap(other.meshes[1].rest.triangles[2][0], other.meshes[1].rest.triangles[2][1]);
  EXPECT_HAS(told(a, bake("b", other)), "biceps: triangle 2 joins other vertices");
  other = info;
  other.meshes[1].weights[2] = 0.5;
  EXPECT_HAS(told(a, bake("c", other)),
             "biceps: the weight of vertex 2 is 0.5, expected 0.333333\n");
  other = info;
  other.meshes[0].rest.vertices[1].y() += 0.002;
  EXPECT_HAS(told(a, bake("d", other)),
             "ulna: its rest shape is 2 mm from the expected one at "
             "vertex 1");
  other = info;
  other.meshes[2].rest.vertices.pop_back();
  EXPECT_HAS(told(a, bake("e", other)), "skin has 4 vertices and 4 triangles, expected 5 and 4");
  other = info;
  other.meshes[0].kind = BakeMesh::Kind::kSkin;
  EXPECT_HAS(told(a, bake("f", other)), "ulna is a skin, expected a bone");
  other = info;
  other.fps = 25.0;
  EXPECT_HAS(told(a, bake("g", other)), "25 frames a second, expected 24");
}

TEST_F(Compare, FoldersOfPicturesByName) {
  picture("a/skin.0001.png", 100);
  picture("a/skin.0002.png", 100);
  picture("a/skin.0003.png", 100);
  picture("a/contact_sheet.png", 1);
  picture("b/skin.0001.png", 100);
  picture("b/skin.0002.png", 103);
  picture("b/skin.0004.png", 100);
  const std::string text = told(folder / "a", folder / "b");
  EXPECT_HAS(text, "different pictures: 3 of 4 differ");
  EXPECT_HAS(text, "skin.0002.png: 100 % of the pixels changed");
  EXPECT_HAS(text, "skin.0003.png: missing");
  EXPECT_HAS(text, "skin.0004.png: not expected");
  CompareOptions first;
  first.frames = {1};
  EXPECT_HAS(told(folder / "a", folder / "b", first), "same pictures: 1, the same");
  first.frames = {};
  first.progress = ProgressStyle::kPlain;
  testing::internal::CaptureStderr();
  told(folder / "a", folder / "b", first);
  EXPECT_HAS(testing::internal::GetCapturedStderr(), ", 4 of 4, 0 s left\n");
  first.frames = {9};
  EXPECT_HAS(input_error([&] { told(folder / "a", folder / "b", first); }), "of the chosen frames");
}

TEST_F(Compare, TheRenderersAreShownWhereTheyDiffer) {
  picture("a.png", 100, "softpipe, 3.3 Mesa 22.3.6");
  picture("b.png", 100, "llvmpipe");
  picture("c.png", 100, "");
  EXPECT_EQ(read_png(folder / "a.png").renderer, "softpipe, 3.3 Mesa 22.3.6");
  EXPECT_EQ(read_png(folder / "c.png").renderer, "");
  EXPECT_EQ(told(folder / "a.png", folder / "a.png").find("renderers"), std::string::npos);
  EXPECT_HAS(told(folder / "a.png", folder / "b.png"),
             "same pictures: 1, the same\n  renderers differ: expected softpipe, 3.3 Mesa 22.3.6; "
             "actual llvmpipe");
  EXPECT_HAS(told(folder / "a.png", folder / "c.png"), "actual unknown");
  // Where they are not the same, looser limits are offered; not between pictures of one renderer.
  picture("d.png", 120, "llvmpipe");
  EXPECT_HAS(told(folder / "a.png", folder / "d.png"), "--share 0.012 --largest 40 --flip 0.0012");
  EXPECT_EQ(told(folder / "b.png", folder / "d.png").find("--share"), std::string::npos);
}

TEST_F(Compare, PicturesOfOtherSizeDifferAndWhatIsNoneIsRefused) {
  picture("a.png", 100);
  picture("b.png", 100, "", 48);
  EXPECT_HAS(told(folder / "a.png", folder / "b.png"), "is 48 x 16 pixels, expected 32 x 16");
  write("bad.png", "not a picture");
  write("bad.h5", "not a bake");
  write("bad.txt", "");
  const fs::path bake_file = bake("a", info) / "bake.h5";
  EXPECT_HAS(input_error([&] { told(folder / "a.png", folder / "bad.png"); }), "bad.png");
  EXPECT_HAS(input_error([&] { told(bake_file, folder / "bad.h5"); }), "bad.h5");
  EXPECT_HAS(input_error([&] { told(bake_file, folder / "bad.txt"); }), "neither a bake nor");
  EXPECT_HAS(input_error([&] { told(bake_file, folder / "none.h5"); }), "no such file");
  fs::create_directories(folder / "empty");
  EXPECT_HAS(input_error([&] { told(folder / "a", folder / "empty"); }), "holds no bake.h5");
  EXPECT_HAS(input_error([&] { told(folder / "empty", folder / "empty"); }), "holds neither");
  expect_error(ErrorCode::kUsage, "not of one kind", [&] { told(bake_file, folder / "a.png"); });
}

TEST_F(Compare, CommandCodesJsonAndPage) {
  const fs::path a = bake("a", info), b = bake("b", info, [](BakeFrame&frame) {
                                        if (frame.frame == 2)
                                          frame.positions[1][3] += Vec3(0, 0.00012, 0);
                                      });
  picture("a/frames/skin.0000.png", 100);
  picture("a/frames/skin.0002.png", 100);
  picture("b/frames/skin.0000.png", 100);
  picture("b/frames/skin.0002.png", 180, "<b>painter</b> 2");
  CommandOptions options;
  options.json = true;
  testing::internal::CaptureStdout();
  EXPECT_EQ(compare_command(a, a, options, {}), ExitCode::kDone);
  EXPECT_TRUE(nlohmann::json::parse(testing::internal::GetCapturedStdout())["same"]);
  options.out = folder / "page.html";
  testing::internal::CaptureStdout();
  EXPECT_EQ(compare_command(a, b, options, {}), ExitCode::kDifferent);
  const auto json = nlohmann::json::parse(testing::internal::GetCapturedStdout());
  EXPECT_FALSE(json["same"]);
  EXPECT_EQ(json["geometry"]["meshes"][0]["name"], "biceps");
  EXPECT_NEAR(json["geometry"]["meshes"][0]["max_distance_mm"].get<double>(), 0.12, 1e-9);
  EXPECT_EQ(json["geometry"]["meshes"][0]["frame"], 2);
  EXPECT_EQ(json["images"][1]["name"], "frames/skin.0002.png");
  EXPECT_EQ(json["images"][1]["frame"], 2);
  EXPECT_EQ(json["images"][1]["largest"], 80);
  EXPECT_EQ(json["images"][0]["same"], true);

  // One file: it asks for no other, and what others wrote is text in it.
  const std::string page = bytes_of(options.out);
  for (const char* link : {"src=\"http", "href=", "url(", "@import", "<link"}) {
    EXPECT_EQ(page.find(link), std::string::npos) << link;
  }
  EXPECT_EQ(page.find("<b>painter"), std::string::npos);
  for (const char* part : {"biceps moved 0.12 mm in frame 2", "class=\"expected\"",
                           "class=\"actual\"", "class=\"difference\"", "type=\"range\""}) {
    EXPECT_HAS(page, part);
  }
}

}  // namespace
}  // namespace thew::tests
