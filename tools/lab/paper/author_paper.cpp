// SPDX-License-Identifier: Apache-2.0
// author_paper FOLDER: makes the meshes of the paper's scenes, for assets/paper.
#include <cstdio>

#include "tools/base/exit_code.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/elements/fem_bar.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

TriMesh scaled(TriMesh mesh, const Vec3& factor) {
  for (Vec3& p : mesh.vertices) p = p.cwiseProduct(factor);
  return mesh;
}

// Along x, with a ring at x = 0.
TriMesh bar(const BarShape& shape) {
  TriMesh mesh = ringed_ball(47, 24);
  for (Vec3& p : mesh.vertices) {
    const double thin = bar_thinning(shape.neck, p.y());
    p = shape.half.cwiseProduct(Vec3(p.y(), thin * p.z(), thin * p.x()));
  }
  return mesh;
}

void write_all(const std::filesystem::path& folder) {
  const Vec3 ball = Vec3::Constant(0.1), cube = Vec3::Constant(0.2);
  for (int triangles : {1470, 1766, 9800}) {
    write_obj(folder / ("ball_" + std::to_string(triangles) + ".obj"), "ball of radius 0.1",
              scaled(paper_ball(triangles), ball));
  }
  write_obj(folder / "box.obj", "unit cube", paper_cube(1, false));
  // Finer, so that it is drawn with sharp edges.
  write_obj(folder / "block.obj", "unit cube", paper_cube(12, false));
  write_obj(folder / "probe.obj", "unit sphere", ringed_ball(31, 62));
  write_obj(folder / "cube_1536.obj", "cube of 0.2", scaled(paper_cube(8, true), cube));
  write_obj(folder / "cube_19200.obj", "cube of 0.2", scaled(paper_cube(40, false), cube));
  write_obj(folder / "torus.obj", "torus", paper_torus(0.07, 0.03, 28, 66));
  write_obj(folder / "two_rings.obj", "surface of genus 2", paper_two_rings(4000));
  write_obj(folder / "finger.obj", "finger", paper_finger(3600));
  write_obj(folder / "bar.obj", "spindle", bar(BarShape{}));
  write_obj(folder / "spindle.obj", "ball stretched", scaled(paper_ball(1470), BarShape{}.half));
  write_obj(folder / "two_bellies.obj", "spindle with a neck", bar({.neck = kNeck}));
  write_obj(folder / "plate.obj", "plate with a rounded edge",
            rounded_plate(0.35, 0.3, 0.05, 0.02));
  write_obj(folder / "cow.obj", "quadruped", paper_cow(14136));
}

int run(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: author_paper FOLDER\n");
    return static_cast<int>(ExitCode::kUsage);
  }
  write_all(argv[1]);
  return 0;
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  return thew::tools::run_or_tell("author_paper", thew::tools::run, argc, argv);
}
