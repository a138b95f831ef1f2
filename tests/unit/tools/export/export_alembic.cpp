// SPDX-License-Identifier: Apache-2.0
//
// Alembic, read back.
#include <gtest/gtest.h>

#include "tests/unit/tools/export/abc_reader.h"

namespace thew::tests {
namespace {

TEST_F(ExportTest, AlembicHoldsEveryFrame) {
  for (const bool double_precision : {false, true}) {
    bake(double_precision);
    const ReadArchive archive = read_archive(write("all.abc", {}));
    EXPECT_NE(archive.meta.find("_ai_DCC_FPS=24"), std::string::npos);
    EXPECT_NE(archive.meta.find("units: m, up_axis: Y, fps: 24, first_frame: -2"),
              std::string::npos);
    EXPECT_EQ(archive.most_samples, (std::vector<unsigned>{0, 4}));
    EXPECT_EQ(archive.samplings[1], (std::vector<double>{2 / 24.0, -2 / 24.0}));
    ASSERT_EQ(archive.objects.size(), 3u);
    for (std::size_t m = 0; m < 3; ++m) {
      const std::string name = std::array{"biceps", "skin", "ulna"}[m];
      const Compound geometry = archive.geometry(m);
      EXPECT_EQ(archive.objects[m].name, name);
      EXPECT_EQ(archive.objects[m].meta,
                "schema=AbcGeom_Xform_v3;schemaObjTitle=AbcGeom_Xform_v3:.xform");
      EXPECT_EQ(archive.transform(m).size(), 1u);  // .inherits alone: it does not move
      EXPECT_EQ(archive.objects[m].children[0].name, name + "Shape");
      EXPECT_EQ(archive.objects[m].children[0].meta,
                "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1;"
                "schemaObjTitle=AbcGeom_PolyMesh_v1:.geom");
      EXPECT_EQ(geometry.at("P").meta, "geoScope=vtx;interpretation=point");
      for (int i = 0; i < 4; ++i) {
        const auto p = sample<float>(archive, geometry.at("P"), i);
        EXPECT_EQ(p, as_floats(positions(name, i)));
        EXPECT_EQ(sample<float>(archive, geometry.at("N"), i).size(), p.size());
        const auto bounds = sample<double>(archive, geometry.at(".selfBnds"), i);
        ASSERT_EQ(bounds.size(), 6u);
        Vec3 low = positions(name, i)[0];
        for (const Vec3& q : positions(name, i)) low = low.cwiseMin(q);
        EXPECT_EQ(Vec3(bounds[0], bounds[1], bounds[2]), low);
      }
      const Compound parameters = archive.below(geometry.at(".arbGeomParams"));
      EXPECT_EQ(sample<float>(archive, parameters.at("Pref"), 2),
                as_floats(mesh(name).rest.vertices));
      EXPECT_EQ(sample<float>(archive, parameters.at("Cd"), 2).size(), 3u);
      const auto indices = sample<std::int32_t>(archive, geometry.at(".faceIndices"), 3);
      const auto counts = sample<std::int32_t>(archive, geometry.at(".faceCounts"), 3);
      const auto& triangles = mesh(name).rest.triangles;
      EXPECT_EQ(counts, std::vector<std::int32_t>(triangles.size(), 3));
      ASSERT_EQ(indices.size(), 3 * triangles.size());
      for (std::size_t t = 0; t < triangles.size(); ++t) {
        // Clockwise.
        EXPECT_EQ((Triangle{indices[3 * t + 2], indices[3 * t + 1], indices[3 * t]}), triangles[t]);
      }
      for (const auto& [property, read] : geometry) {
        if (read.type == 0) continue;
        EXPECT_EQ(read.samples, 4u) << property;
        EXPECT_EQ(read.sampling, 1u) << property;
      }
    }
  }
}

TEST_F(ExportTest, AlembicListsTheTimesOfUnevenFrames) {
  bake(false);
  options_.frames = "-2,0,4";
  const ReadArchive archive = read_archive(write("ulna.abc", {"ulna"}));
  EXPECT_EQ(archive.samplings[1], (std::vector<double>{std::numeric_limits<double>::max() / 32.0,
                                                       -2 / 24.0, 0.0, 4 / 24.0}));
  EXPECT_EQ(sample<float>(archive, archive.geometry(0).at("P"), 2),
            as_floats(positions("ulna", 3)));
}

// A transform for what moves as one piece, one sample for what stands still, bounds of all.
TEST_F(ExportTest, AlembicMovesRigidMeshesByTheirTransform) {
  bake({1, 2, 3}, [&](BakeFrame& frame) {
    for (std::size_t m = 0; m < 3; ++m) frame.positions[m] = info_.meshes[m].rest.vertices;
    const Transform turn(Eigen::Translation3d(0.1 * frame.frame, 0, 0) *
                         Eigen::AngleAxisd(0.5 * frame.frame, Vec3::UnitY()));
    for (Vec3& p : frame.positions[0]) p = turn * p;  // the ulna
    frame.positions[1][1].x() += 0.01 * (frame.frame % 2);
  });
  const ReadArchive archive = read_archive(write("all.abc", {}));
  const Compound ulna = archive.geometry(2);
  EXPECT_TRUE(ulna.at("P").constant);
  EXPECT_TRUE(ulna.at("N").constant);
  const Compound moves = archive.transform(2);
  EXPECT_EQ(sample<std::uint8_t>(archive, moves.at(".ops"), 0), std::vector<std::uint8_t>{0x30});
  EXPECT_EQ(moves.at(".ops").extent, 1u);
  EXPECT_EQ(moves.at(".vals").extent, 16u);
  EXPECT_EQ(sample<std::uint32_t>(archive, moves.at(".animChans"), 0).size(), 16u);
  const auto points = sample<float>(archive, ulna.at("P"), 0);
  for (int i = 0; i < 3; ++i) {
    const auto rows = sample<double>(archive, moves.at(".vals"), i);
    const std::vector<Vec3> baked = positions("ulna", i);
    for (std::size_t v = 0; v < baked.size(); ++v) {
      for (int k = 0; k < 3; ++k) {
        double at = rows[12 + k];
        for (int j = 0; j < 3; ++j) at += points[3 * v + j] * rows[4 * j + k];
        EXPECT_NEAR(at, baked[v][k], 1e-7);
      }
    }
    Eigen::AlignedBox3d box;
    for (const char* name : {"biceps", "skin", "ulna"}) {
      for (const Vec3& p : positions(name, i)) box.extend(p);
    }
    const auto bounds = sample<double>(archive, archive.top.at(".childBnds"), i);
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(bounds[k], box.min()[k]);
      EXPECT_EQ(bounds[3 + k], box.max()[k]);
    }
  }
  const ReadProperty biceps = archive.geometry(0).at("P");
  EXPECT_FALSE(biceps.constant);
  EXPECT_EQ(biceps.children[0], biceps.children[4]);  // frames 1 and 3 are the same, and so once
  EXPECT_TRUE(archive.geometry(1).at("P").constant);  // the skin
  const Compound muscle = archive.below(archive.geometry(0).at(".arbGeomParams"));
  EXPECT_EQ(sample<float>(archive, muscle.at("thew_weight"), 1).size(), 4u);
  EXPECT_EQ(sample<double>(archive, muscle.at("thew_length"), 1), std::vector<double>{2.1 / 4.0});
  const Compound uv = archive.below(archive.geometry(0).at("uv"));
  EXPECT_EQ(sample<std::uint32_t>(archive, uv.at(".indices"), 0).size(), 12u);
  EXPECT_EQ(uv.at(".vals").extent, 2u);
}

TEST_F(ExportTest, AlembicOfOneFrameIsConstant) {
  bake(false);
  options_.frames = "4";
  const ReadArchive archive = read_archive(write("ulna.abc", {"ulna"}));
  EXPECT_TRUE(archive.geometry(0).at("P").constant);
  EXPECT_EQ(sample<float>(archive, archive.geometry(0).at("P"), 0),
            as_floats(positions("ulna", 3)));
}

}  // namespace
}  // namespace thew::tests
