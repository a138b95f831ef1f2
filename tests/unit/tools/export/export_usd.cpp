// SPDX-License-Identifier: Apache-2.0
//
// USD. Programs that we did not write read it in tests/clients.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/unit/tools/export/crate_reader.h"

namespace thew::tests {
namespace {

// The first of these meshes stands still but for the last frame, the second moves as one piece, the
// third does not move.
const Transform kTurn(Eigen::Translation3d(0.1, 0, -0.2) *
                      Eigen::AngleAxisd(0.5, Vec3(1, 2, 2) / 3.0));

class UsdTest : public ExportTest {
 protected:
  UsdTest() {
    bake({1, 2, 3, 4}, [&](BakeFrame& frame) {
      for (std::size_t m = 0; m < 3; ++m) frame.positions[m] = info_.meshes[m].rest.vertices;
      if (frame.frame == 4) frame.positions[kBiceps][1].x() += 0.01;
      for (Vec3& p : frame.positions[kUlna]) {
        for (int i = 0; i < frame.frame; ++i) p = kTurn * p;
      }
    });
  }
  static constexpr std::size_t kUlna = 0, kBiceps = 1;
};

TEST_F(UsdTest, CrateHoldsSamplesOnlyWhereSomethingMoves) {
  const Crate crate = read_crate(bytes_of(write("all.usdc", {})));
  const auto& biceps = crate.specs.at("/Bake/Muscles/biceps.points");
  EXPECT_EQ(crate.token(biceps.at("typeName")), "point3f[]");
  EXPECT_EQ(crate.floats(biceps.at("default")), as_floats(mesh("biceps").rest.vertices));
  const auto samples = crate.samples(biceps.at("timeSamples"));
  ASSERT_EQ(samples.size(), 3u);  // 2 lies between two of the same
  EXPECT_EQ(samples.at(1), samples.at(3));
  EXPECT_EQ(samples.at(1), biceps.at("default"));
  EXPECT_EQ(crate.floats(samples.at(4)), as_floats(positions("biceps", 3)));
  const auto& skin = crate.specs.at("/Bake/Skin/skin.points");
  EXPECT_EQ(skin.count("timeSamples"), 0u);
  EXPECT_EQ(crate.floats(skin.at("default")), as_floats(positions("skin", 0)));
  const auto& ulna = crate.specs.at("/Bake/Bones/ulna.points");
  EXPECT_EQ(ulna.count("timeSamples"), 0u);
  EXPECT_EQ(ulna.at("default"), biceps.at("default"));  // equal, and so kept once
  const auto turns =
      crate.samples(crate.specs.at("/Bake/Bones/ulna.xformOp:transform").at("timeSamples"));
  ASSERT_EQ(turns.size(), 4u);
  const std::vector<double> rows = crate.doubles(turns.at(1), 16);
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 4; ++column) {
      EXPECT_NEAR(rows[4 * row + column], kTurn.matrix()(column, row), 1e-12);
    }
  }
  EXPECT_EQ(
      crate.samples(crate.specs.at("/Bake/Muscles/biceps.thew:length").at("timeSamples")).size(),
      4u);
  EXPECT_EQ(crate.token(crate.specs.at("").at("defaultPrim")), "Bake");
  EXPECT_EQ(crate.token(crate.specs.at("/Bake").at("kind")), "component");
}

// A mesh that turns around an axis by 1 degree a frame: normals on the line between those four
// frames apart are off by far less than a degree. By 20 degrees a frame no line says them. Where
// nothing turns until the last frame, the line from the first would say that it did.
TEST_F(UsdTest, NormalsHaveSamplesWhereTheLineBetweenTwoIsNotThem) {
  for (const auto& [degrees, expected] : {std::pair{1.0, 2u}, {20.0, 5u}, {0.0, 3u}}) {
    bake({1, 2, 3, 4, 5}, [&, turn = degrees](BakeFrame& frame) {
      const double angle = turn > 0 ? turn * frame.frame : frame.frame == 5 ? 90.0 : 0.0;
      const Eigen::AngleAxisd by(angle * 3.14159265358979 / 180, Vec3::UnitZ());
      frame.positions[kBiceps] = info_.meshes[kBiceps].rest.vertices;
      for (Vec3& p : frame.positions[kBiceps]) p = by * p;
      frame.positions[kBiceps][1] *= 1 + 1e-3 * frame.frame;  // not as one piece
    });
    const auto samples = [crate = read_crate(bytes_of(write("turns.usdc", {})))](const char* of) {
      const std::string path = "/Bake/Muscles/biceps." + std::string(of);
      return crate.samples(crate.specs.at(path).at("timeSamples")).size();
    };
    EXPECT_EQ(samples("normals"), expected) << degrees;
    EXPECT_EQ(samples("points"), 5u);
    std::filesystem::remove(folder_ / "turns.usdc");
  }
}

TEST_F(UsdTest, TextHoldsWhatTheCrateDoes) {
  const Crate crate = read_crate(bytes_of(write("all.usdc", {})));
  std::istringstream text(bytes_of(write("all.usda", {})));
  std::size_t attributes = 0, samples = 0, expected = 0;
  for (std::string line; std::getline(text, line);) {
    attributes += line.find(" = ") != std::string::npos && line.find("    ") == 0 &&
                  line.find("timeSamples") == std::string::npos &&
                  line.find("[] ") != std::string::npos;
    samples += line.find_first_of("0123456789") != std::string::npos &&
               line.find_first_not_of(' ') == line.find_first_of("0123456789");
  }
  std::size_t arrays = 0;
  for (const auto& [path, fields] : crate.specs) {
    arrays += path.find('.') != std::string::npos &&
              crate.token(fields.at("typeName")).find("[]") != std::string::npos;
    if (fields.count("timeSamples")) expected += crate.samples(fields.at("timeSamples")).size();
  }
  EXPECT_EQ(attributes, arrays);
  EXPECT_EQ(samples, expected);
  EXPECT_GT(samples, 10u);
}

TEST_F(UsdTest, ArchiveHoldsTheCrateOnAMultipleOf64) {
  const std::string crate = bytes_of(write("all.usdc", {}));
  const std::string archive = bytes_of(write("all.usdz", {}));
  EXPECT_EQ(archive.substr(0, 4), "PK\3\4");
  EXPECT_EQ(archive.substr(30, 9), "bake.usdc");
  EXPECT_EQ(archive.substr(64, crate.size()), crate);
  EXPECT_EQ((ByteReader{archive, 22}.take<std::uint32_t>()), crate.size());
  const std::size_t end = archive.size() - 22;
  EXPECT_EQ(archive.substr(end, 4), "PK\5\6");
  EXPECT_EQ((ByteReader{archive, end + 16}.take<std::uint32_t>()), 64 + crate.size());
  EXPECT_EQ(archive.substr(64 + crate.size(), 4), "PK\1\2");
}

TEST_F(ExportTest, UsdaHoldsSamplesByFrameNumber) {
  bake(false);
  const std::string text = bytes_of(write("all.usda", {}));
  for (const char* fact : {"metersPerUnit = 1\n", "upAxis = \"Y\"\n", "timeCodesPerSecond = 24\n",
                           "startTimeCode = -2\n", "endTimeCode = 4\n", "kind = \"component\"\n"}) {
    EXPECT_NE(text.find(fact), std::string::npos) << fact;
  }
  for (const char* name : {"biceps", "skin", "ulna"}) {
    std::size_t at = text.find("def Mesh \"" + std::string(name) + "\"");
    at = text.find(" points = [", at);  // the default first
    at = text.find(" points.timeSamples = {\n", at);
    ASSERT_NE(at, std::string::npos) << name;
    std::istringstream in(text.substr(at));
    std::string line;
    std::getline(in, line);
    for (int i = 0; i < 4; ++i) {
      std::getline(in, line);
      for (char& c : line) {
        if (std::string("()[],:").find(c) != std::string::npos) c = ' ';
      }
      std::istringstream numbers(line);
      int frame = 0;
      numbers >> frame;
      EXPECT_EQ(frame, info_.frames[i]);
      std::vector<float> values;
      for (float value; numbers >> value;) values.push_back(value);
      EXPECT_EQ(values, as_floats(positions(name, i)));
    }
  }
}

}  // namespace
}  // namespace thew::tests
