// SPDX-License-Identifier: Apache-2.0
//
// Values by node that follow from a bake, against sheets and lines of known shape; and that a
// bake's line of action reaches its exports.
#include "tools/export/fields.h"

#include <gtest/gtest.h>

#include "tests/unit/tools/export/abc_reader.h"
#include "tests/unit/tools/export/crate_reader.h"

namespace thew::tests {
namespace {

using tools::fibre_directions;
using tools::principal_stretches;

// A sheet of triangles of many shapes.
TriMesh sheet() {
  constexpr int kSide = 6;
  TriMesh mesh;
  for (int i = 0; i <= kSide; ++i) {
    for (int j = 0; j <= kSide; ++j) {
      mesh.vertices.push_back(Vec3(0.1 * i + 0.02 * (j % 3), 0.07 * j + 0.013 * (i * i % 5), 0.0));
    }
  }
  const auto at = [](int i, int j) { return i * (kSide + 1) + j; };
  for (int i = 0; i < kSide; ++i) {
    for (int j = 0; j < kSide; ++j) {
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return mesh;
}

std::vector<Vec3> moved(const std::vector<Vec3>& points, const Mat3& by) {
  std::vector<Vec3> result;
  for (const Vec3& p : points) result.push_back(by * p + Vec3(0.3, -0.2, 0.1));
  return result;
}

void expect_stretches(const TriMesh& rest, const Mat3& by, double larger, double smaller) {
  for (const auto& of :
       principal_stretches(rest, first_at_position(rest), moved(rest.vertices, by))) {
    EXPECT_NEAR(of[0], larger, 1e-6);
    EXPECT_NEAR(of[1], smaller, 1e-6);
  }
}

TEST(PrincipalStretches, OfSheetsOfKnownStretch) {
  const TriMesh rest = sheet();
  const Mat3 turn = Eigen::AngleAxisd(1.1, Vec3(1, 2, 2) / 3.0).toRotationMatrix();
  const Mat3 slant = Eigen::AngleAxisd(0.4, Vec3::UnitZ()).toRotationMatrix();
  expect_stretches(rest, turn, 1.0, 1.0);  // a motion of the whole stretches nothing
  const Mat3 along = Vec3(1.3, 0.9, 1.0).asDiagonal();
  expect_stretches(rest, along, 1.3, 0.9);
  expect_stretches(rest, Mat3(turn * slant * along * slant.transpose()), 1.3, 0.9);
  Mat3 shear = Mat3::Identity();  // by 1: the golden ratio and its inverse
  shear(0, 1) = 1.0;
  expect_stretches(rest, Mat3(turn * shear), 0.5 * (std::sqrt(5.0) + 1),
                   0.5 * (std::sqrt(5.0) - 1));
  Mat3 flat = Mat3::Identity();
  flat(1, 1) = 0.0;
  expect_stretches(rest, flat, 1.0, 0.0);
}

TEST(PrincipalStretches, JoinVerticesAtOnePlaceAndSkipWhatHasNoArea) {
  TriMesh rest{{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(1, 1, 0),
                Vec3(0, 1, 0), Vec3(3, 3, 3)},
               {{0, 1, 2}, {3, 4, 5}, {6, 6, 0}}};
  std::vector<Vec3> now = rest.vertices;
  now[4] = Vec3(2, 2, 0);  // the second triangle alone
  const auto stretches = principal_stretches(rest, first_at_position(rest), now);
  EXPECT_EQ(stretches[1], stretches[3]);  // a seam has the same on both sides
  EXPECT_EQ(stretches[2], stretches[5]);
  EXPECT_EQ(stretches[0], (std::array<float, 2>{1, 1}));
  EXPECT_GT(stretches[4][0], 1.5f);
  EXPECT_EQ(stretches[6], (std::array<float, 2>{1, 1}));
}

// The nodes of a muscle at `shares` of its path.
BakeMesh with_shares(const std::vector<double>& shares) {
  BakeMesh mesh;
  for (const double share : shares) mesh.coordinates.push_back({share, 0.5, 1.0});
  return mesh;
}

TEST(FibreDirections, OfAStraightMuscleAreItsAxis) {
  const Vec3 axis = Vec3(2, -1, 2) / 3.0;
  std::vector<Vec3> line;
  for (int k = 0; k < 33; ++k) line.push_back(Vec3(0.1, 0.2, 0.3) + 0.01 * k * k / 33.0 * axis);
  for (const Vec3& d : fibre_directions(with_shares({0, 0.01, 0.3, 0.999, 1}), line)) {
    EXPECT_LT((d - axis).norm(), 1e-12);
  }
}

TEST(FibreDirections, FollowAnArc) {
  std::vector<Vec3> line;
  std::vector<double> shares;
  for (int k = 0; k < 33; ++k) {
    const double angle = 1.5 * k / 32.0;
    line.push_back(0.2 * Vec3(std::sin(angle), 1 - std::cos(angle), 0));
    shares.push_back(k / 32.0 * 0.98 + 0.01);
  }
  const auto directions = fibre_directions(with_shares(shares), line);
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double angle = 1.5 * shares[i];
    // A chord of a 32nd of 86 degrees leans 1.3 degrees at the ends; within, far less.
    EXPECT_LT((directions[i] - Vec3(std::cos(angle), std::sin(angle), 0)).norm(), 0.024) << i;
    EXPECT_NEAR(directions[i].norm(), 1.0, 1e-12);
  }
}

TEST(FibreDirections, AreNumbersOnALineOfOnePoint) {
  const std::vector<Vec3> line(5, Vec3(1, 2, 3));
  for (const Vec3& d : fibre_directions(with_shares({0, 0.4, 1}), line)) {
    EXPECT_NEAR(d.norm(), 1.0, 1e-12);
  }
  EXPECT_TRUE(fibre_directions(with_shares({0.5}), {}).empty());
}

// The biceps turns about z by 0.3 a frame, and its line with it; the skin is stretched along x.
class FieldsTest : public ExportTest {
 protected:
  FieldsTest() {
    info_ = small_info(true);
    info_.frames = {1, 2, 3};
    info_.meshes[1].line = 5;
    info_.metric_names = {"activation/biceps", "penetration/biceps", "skin_penetration"};
    BakeWriter writer(folder_, info_, false);
    for (const int number : info_.frames) {
      BakeFrame frame = small_frame(info_, number);
      frame.positions[1][1] = Vec3(0.5, 0.1 * number, 0);  // so that it is not rigid
      frame.lines.resize(3);
      for (int k = 0; k < 5; ++k) frame.lines[1].push_back(0.1 * k * axis(number));
      frame.positions[2] = info_.meshes[2].rest.vertices;
      for (Vec3& p : frame.positions[2]) p *= 1.0 + 0.25 * number;
      writer.write(frame);
    }
    writer.pack();
    reader_.emplace(folder_ / "bake.h5");
  }
  static Vec3 axis(int frame) { return {std::cos(0.3 * frame), std::sin(0.3 * frame), 0.0}; }
  static void expect_axis(const std::vector<float>& values, int frame, std::size_t count) {
    ASSERT_EQ(values.size(), 3 * count);
    for (std::size_t v = 0; v < count; ++v) {
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(values[3 * v + k], axis(frame)[k], 2e-7);
    }
  }
};

TEST_F(FieldsTest, AlembicHasThem) {
  auto archive = read_archive(write("plain.abc", {}));
  auto muscle = archive.below(archive.geometry(0).at(".arbGeomParams"));
  auto skin = archive.below(archive.geometry(1).at(".arbGeomParams"));
  EXPECT_EQ(muscle.count("thew_fibre") + skin.count("thew_stretch"), 0u);
  EXPECT_NE(muscle.at("thew_line").meta.find("arrayExtent=5"), std::string::npos);
  for (int i = 0; i < 3; ++i) {
    const auto line = sample<float>(archive, muscle.at("thew_line"), i);
    ASSERT_EQ(line.size(), 15u);
    EXPECT_NEAR(line[13], 0.4 * axis(i + 1).y(), 1e-7);
    EXPECT_EQ(sample<double>(archive, muscle.at("thew_penetration"), i),
              std::vector<double>{reader_->metric(1)[i]});
    EXPECT_EQ(sample<double>(archive, skin.at("thew_penetration"), i),
              std::vector<double>{reader_->metric(2)[i]});
  }
  choice_.fields = true;
  archive = read_archive(write("fields.abc", {}));
  muscle = archive.below(archive.geometry(0).at(".arbGeomParams"));
  skin = archive.below(archive.geometry(1).at(".arbGeomParams"));
  for (int i = 0; i < 3; ++i) {
    expect_axis(sample<float>(archive, muscle.at("thew_fibre"), i), i + 1, 4);
    const auto stretches = sample<float>(archive, skin.at("thew_stretch"), i);
    ASSERT_EQ(stretches.size(), 10u);
    for (std::size_t k = 0; k < 8; ++k) EXPECT_NEAR(stretches[k], 1.25 + 0.25 * i, 1e-6);
  }
}

TEST_F(FieldsTest, UsdHasThem) {
  EXPECT_EQ(read_crate(bytes_of(write("plain.usdc", {})))
                .specs.count("/Bake/Muscles/biceps.primvars:thew:fibre"),
            0u);
  choice_.fields = true;
  const Crate crate = read_crate(bytes_of(write("fields.usdc", {})));
  const auto samples = [&](const std::string& path) {
    return crate.samples(crate.specs.at(path).at("timeSamples"));
  };
  const auto fibres = samples("/Bake/Muscles/biceps.primvars:thew:fibre");
  const auto lines = samples("/Bake/Muscles/biceps.thew:line");
  const auto stretches = samples("/Bake/Skin/skin.primvars:thew:stretch");
  ASSERT_EQ(fibres.size(), 3u);
  for (int frame = 1; frame <= 3; ++frame) {
    expect_axis(crate.floats(fibres.at(frame)), frame, 4);
    EXPECT_EQ(crate.floats(lines.at(frame)).size(), 15u);
    for (std::size_t k = 0; k < 8; ++k) {
      EXPECT_NEAR(crate.floats(stretches.at(frame))[k], 1 + 0.25 * frame, 1e-6);
    }
  }
  EXPECT_EQ(samples("/Bake/Skin/skin.thew:penetration").size(), 3u);
}

TEST_F(FieldsTest, OtherFormatsRefuseThem) {
  choice_.fields = true;
  expect_refused(ErrorCode::kUsage, "--fields is not for", "all.glb", {});
  choice_.fields = false;
  const std::string text = bytes_of(write("all.xdmf", {}));
  EXPECT_NE(text.find("Name=\"activation\" AttributeType=\"Scalar\" Center=\"Grid\""),
            std::string::npos);
}

}  // namespace
}  // namespace thew::tests
