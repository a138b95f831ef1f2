// SPDX-License-Identifier: Apache-2.0
//
// The paper's bodies: counts to the last triangle, closed, of the right topology.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "rig/import/mesh_import.h"
#include "tools/lab/elements/delaunay.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tests {
namespace {

// V - E + F of a closed surface is 2 - 2 genus, and E = 3 F / 2.
int genus(const TriMesh& mesh) {
  const int v = static_cast<int>(mesh.vertices.size());
  const int f = static_cast<int>(mesh.triangles.size());
  return (2 - (v - f / 2)) / 2;
}

void expect_sound(const TriMesh& mesh, int triangles, int holes) {
  EXPECT_EQ(static_cast<int>(mesh.triangles.size()), triangles);
  EXPECT_EQ(genus(mesh), holes);
  for (const Defect& defect : find_defects(mesh)) {
    ADD_FAILURE() << defect_name(defect.kind) << " " << defect.where;
  }
}

TEST(PaperShapes, HaveThePapersCounts) {
  for (int triangles : {1470, 1766, 9800}) expect_sound(paper_ball(triangles), triangles, 0);
  expect_sound(paper_cube(8, true), 1536, 0);
  expect_sound(paper_cube(40, false), 19200, 0);
  expect_sound(paper_torus(0.07, 0.03, 28, 66), 3696, 1);
  expect_sound(paper_two_rings(4000), 4000, 2);
#ifndef THEW_SANITIZED  // half a minute there, and WithCount below goes the same way
  expect_sound(paper_cow(14136), 14136, 0);
#endif
}

TEST(PaperShapes, AreRoundAndSquare) {
  EXPECT_NEAR(enclosed_volume(paper_ball(9800)), 4.18879, 5e-3);
  EXPECT_NEAR(enclosed_volume(paper_cube(8, true)), 1.0, 1e-12);
  EXPECT_NEAR(enclosed_volume(paper_torus(0.07, 0.03, 40, 90)), 2 * 9.8696 * 0.07 * 0.0009, 2e-5);
}

TEST(PaperShapes, TheAssetsAreWhatTheAuthorMakes) {
  const std::string folder = THEW_SOURCE_DIR "/assets/paper/";
  EXPECT_EQ(import_closed_mesh(folder + "ball_1766.obj").triangles.size(), 1766u);
  EXPECT_EQ(import_closed_mesh(folder + "ball_9800.obj").triangles.size(), 9800u);
  EXPECT_EQ(import_closed_mesh(folder + "cow.obj").triangles.size(), 14136u);
}

TEST(WithCount, GoesUpAndDownToTheLastTriangle) {
  const TriMesh ball = paper_ball(1000);
  expect_sound(with_count(ball, 400), 400, 0);
  expect_sound(with_count(ball, 2344), 2344, 0);
  EXPECT_THROW(with_count(ball, 1001), Error);
  const double volume = enclosed_volume(with_count(ball, 400));
  EXPECT_NEAR(volume, enclosed_volume(ball), 0.05 * volume);
}

TEST(WithCount, BringsSpotToTheCowsCount) {
  const std::filesystem::path spot = THEW_SHARED_DATA "/spot.obj";
  if (!std::filesystem::exists(spot)) GTEST_SKIP() << spot << " is not there";
  TriMesh mesh = import_mesh(spot).mesh;
  mesh = with_count(mesh, 14136);
  EXPECT_EQ(mesh.triangles.size(), 14136u);
  EXPECT_EQ(genus(mesh), 0);
}

TEST(Delaunay, FillsTheHullWithEmptySpheres) {
  std::vector<Vec3> points = {{0.01, 0.02, 0.03}};
  for (const Vec3& p : paper_ball(60).vertices) points.push_back(p);
  const TetMesh mesh = delaunay(points);
  double volume = 0.0;
  for (const Tetrahedron& t : mesh.tetrahedra) {
    EXPECT_GT(signed_volume(mesh, t), 0.0);
    volume += signed_volume(mesh, t);
  }
  const TriMesh hull{points, boundary(mesh)};
  EXPECT_EQ(hull.triangles.size(), 60u);
  EXPECT_NEAR(volume, enclosed_volume(hull), 1e-12);
}

}  // namespace
}  // namespace thew::tests
