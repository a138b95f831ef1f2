// SPDX-License-Identifier: Apache-2.0
//
// Pictures of maps: which there are, and that the scale's colours are those of the mesh.
#include "tools/inspect/draw_maps.h"

#include <set>

#include "sim/scene/reader.h"
#include "tests/unit/rig/temp.h"
#include "tools/render/image.h"

namespace thew::tests {
namespace {

using MapPictures = TempFolder;

// How many pixels of the columns [first, last) have nearly this colour.
int count_of(const Image& image, int first, int last, const std::array<int, 3>& colour) {
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = first; x < last; ++x) {
      int off = 0;
      for (int c = 0; c < 3; ++c) {
        off = std::max(off, std::abs(image.rgb[3 * (y * image.width + x) + c] - colour[c]));
      }
      count += off <= 12;
    }
  }
  return count;
}

TEST_F(MapPictures, EachMapOfASceneOnItsMesh) {
  const Scene scene = read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/painted.toml");
  const auto drawn = draw_maps(scene, folder / "maps", false);
  std::set<std::string> names;
  for (const auto& [mesh, quantity, least, most, picture] : drawn) {
    names.insert(mesh + "." + quantity);
    EXPECT_EQ(picture, folder / "maps" / (mesh + "." + quantity + ".png"));
    EXPECT_LE(least, most);
    const Image image = read_png(picture);
    EXPECT_EQ(image.width, 640);
    // The ends of the scale, right, and not the background, left.
    EXPECT_GT(count_of(image, 600, 624, {237, 235, 222}), 24 * 5) << picture;
    EXPECT_GT(count_of(image, 600, 624, {84, 18, 61}), 24 * 5) << picture;
  }
  EXPECT_EQ(names, (std::set<std::string>{"front.weights", "side.weights", "front.stiffness",
                                          "side.thickness", "skin.fat", "skin.slide"}));
  for (const auto& map : drawn) {
    if (map.quantity != "stiffness") continue;
    EXPECT_GT(map.least, 400.0);
    EXPECT_LT(map.least, 600.0);
    EXPECT_EQ(map.most, 1000.0);
  }
}

// Parts of a character without the attribute are not drawn.
TEST_F(MapPictures, OfACharacterOnItsOwnMesh) {
  const Scene scene = read_scene(THEW_SOURCE_DIR "/tests/scenes/figure/painted.toml");
  const auto drawn = draw_maps(scene, folder / "maps", false);
  std::set<std::string> names;
  for (const auto& map : drawn) {
    names.insert(map.mesh + "." + map.quantity);
    if (map.quantity != "fat") continue;
    EXPECT_NEAR(map.least, 0.005, 1e-9);
    EXPECT_NEAR(map.most, 0.009, 1e-9);
    const Image image = read_png(map.picture);  // the trunk, in the middle, is not there
    EXPECT_LT(count_of(image, 300, 340, {84, 18, 61}), 40);
  }
  EXPECT_EQ(names,
            (std::set<std::string>{"front.weights", "back.weights", "skin.fat", "skin.slide"}));
}

}  // namespace
}  // namespace thew::tests
