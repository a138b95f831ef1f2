// SPDX-License-Identifier: Apache-2.0
//
// Table 2 and figures 1 to 7 but the ball: cubes, cow, bodies with holes, finger, muscles, arm.
#include <algorithm>
#include <cmath>
#include <optional>

#include "muscles/volume.h"
#include "rig/math.h"
#include "rig/mesh_import.h"
#include "tools/paper_report.h"
#include "tools/paper_run.h"
#include "tools/paper_shapes.h"
#include "tools/peers/fem_ball.h"

namespace thew {
namespace {

struct Table2 {
  PaperTable table{"table2.csv",
                   "Table 2: errors and speed",
                   "",
                   {"scene", "triangles", "substeps", "error", "printed", "frames per CPU s",
                    "printed", "penetration, m"},
                   {}};
  double worst = 0.0;

  void add(const std::string& scene, const PaperRun& run, double seconds, const std::string& error,
           const std::string& frames) {
    int triangles = 0;
    for (const Muscle& muscle : run.model.muscles) {
      triangles += static_cast<int>(muscle.rest.triangles.size());
    }
    worst = std::max(worst, run.volume_error);
    const Scene& settings = run.model.scene;
    const std::string substeps = settings.solver.integrator == "explicit"
                                     ? std::to_string(explicit_substeps_of(run.model))
                                     : std::to_string(settings.solver.substeps) + " implicit";
    table.rows.push_back({scene, std::to_string(triangles), substeps, number(run.volume_error, 2),
                          error, number(1.0 / seconds), frames, number(run.penetration, 2)});
  }
  static int explicit_substeps_of(const Model& model);
};

int Table2::explicit_substeps_of(const Model& model) {
  const Muscle& muscle = model.muscles[0];
  const double omega2 = highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven);
  return static_cast<int>(std::ceil(std::sqrt(omega2) / (1.6 * model.scene.fps)));
}

PaperRun run_measured(const PaperReport& report, const std::string& scene,
                      std::vector<std::string> overrides, int last = 0) {
  PaperAsk ask;
  ask.scene = report.scenes / (scene + ".toml");
  ask.overrides = std::move(overrides);
  ask.last = last;
  ask.measures = true;
  return run_scene(ask);
}

// The structured cube of linear elements, its top turned like the scene's.
FemBody twisted_fem(double angle, int steps, double penalty, bool& converged) {
  constexpr int kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  constexpr int n = 8;
  FemBody body;
  body.material = {.shear = 1000.0, .lambda = 1000.0, .penalty = penalty};
  const auto node = [](int i, int j, int k) { return (i * (n + 1) + j) * (n + 1) + k; };
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      for (int k = 0; k <= n; ++k) {
        body.rest.push_back(0.2 / n * Vec3(i, j, k) - Vec3::Constant(0.1));
        for (int d = 0; d < 3; ++d) body.fixed.push_back(j == 0 || j == n);
      }
    }
  }
  for (int cube = 0; cube < n * n * n; ++cube) {
    for (const auto& order : kOrders) {
      int at[3] = {cube / (n * n), cube / n % n, cube % n};
      Tetrahedron t = {node(at[0], at[1], at[2])};
      for (int k = 0; k < 3; ++k) {
        ++at[order[k]];
        t[k + 1] = node(at[0], at[1], at[2]);
      }
      if (signed_volume({body.rest, {}}, t) < 0.0) std::swap(t[2], t[3]);
      body.elements.insert(body.elements.end(), t.begin(), t.end());
    }
  }
  prepare(body);
  converged = true;
  for (int s = 1; s <= steps; ++s) {
    const Mat3 turn = rotation_about(Vec3::UnitY(), angle * s / steps);
    for (size_t i = 0; i < body.rest.size(); ++i) {
      if (body.rest[i].y() > 0.0999) body.x[i] = turn * body.rest[i];
    }
    FemStep step;
    step.tolerance = 1e-5;
    step.iterations = 30;
    converged = solve_step(body, step).converged && converged;
  }
  return body;
}

void cubes(PaperReport& report, Table2& table) {
  report.section(
      "Cube twisted by 180° (figure 7) and under a local load",
      "Bottom fixed, top turned: conventional, volume-preserving, and linear finite elements "
      "with the penalty, which know no rotation and swell.");
  const int last = report.quick ? 31 : 0;
  const PaperRun none = run_measured(report, "cube_twist", {"solver.volume=none"}, last);
  const PaperRun exact = run_measured(report, "cube_twist", {}, last);
  report.done();
  table.add("cube twisted", exact, exact.seconds, "1e-5", "83.3");
  bool converged = false;
  const double angle = kPi * (exact.frames.back() - 1) / 60.0;
  const FemBody fem = twisted_fem(angle, 1, 0.0, converged);  // linear: one step is all
  const FemBody held = twisted_fem(angle, report.quick ? 6 : 12, 1e4, converged);
  const double swelling = fem_volume(fem) / 0.008 - 1.0;
  TetMesh tetrahedra{fem.x, {}};
  int inverted = 0;
  for (size_t e = 0; e < fem.elements.size(); e += 4) {
    tetrahedra.tetrahedra.push_back(
        {fem.elements[e], fem.elements[e + 1], fem.elements[e + 2], fem.elements[e + 3]});
    inverted += signed_volume(tetrahedra, tetrahedra.tetrahedra.back()) <= 0.0;
  }
  report.add(
      {draw_run(none, false), draw_run(exact, false),
       draw_surface(exact.model.scene, {fem.x, boundary(tetrahedra)})},
      {"conventional, V/V0 = " + number(none.volume.back()), "volume-preserving",
       "linear FEM, V/V0 = " + number(1.0 + swelling) + ", " + std::to_string(inverted) +
           " inverted"},
      "figure7_cube.png",
      "Figure 7: the twisted cube. The finite elements without a penalty swell; with one of 1e4 Pa "
      "V/V0 is " +
          number(fem_volume(held) / 0.008) + (converged ? "." : ", not converged."));
  report.done();
  const PaperRun load = run_measured(report, "cube_load", {}, report.quick ? 9 : 0);
  table.add("cube, local load", load, load.seconds, "1e-4", "21.3");
  report.add({draw_run(load, true)}, {"volume-preserving, local zone"}, "cube_load.png",
             "Cube of 19,200 triangles under a ball.");
  report.done();
}

struct Momentum {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
};

Momentum momentum_of(const Muscle& muscle, const MuscleState& now) {
  Momentum out;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Vec3 p = muscle.mass[i] * to_vec(now.v[i]);
    out.linear += p;
    out.angular += to_vec(now.x[i]).cross(p);
  }
  return out;
}

void cow(PaperReport& report, Table2& table) {
  report.section(
      "Cow pressed by a ball (figures 5 and 6)",
      "A free body: nothing holds it but the ball. Local weights would push it about; "
      "their net force and torque are taken out, so it gains what the ball gives and no more.");
  // Another mesh has to lie beside the scene: scenes read nothing outside their folder.
  std::vector<std::string> mesh;
  std::filesystem::path scenes = report.scenes;
  std::optional<std::filesystem::path> copy;
  if (!report.cow.empty()) {
    TriMesh given = with_count(import_closed_mesh(report.cow), 14136);
    Vec3 low = Vec3::Constant(1e30), high = -low;
    for (const Vec3& p : given.vertices) {
      low = low.cwiseMin(p);
      high = high.cwiseMax(p);
    }
    // As long as ours, its flank where the ball comes.
    const double scale = 1.2 / (high - low).maxCoeff();
    for (Vec3& p : given.vertices) p = scale * (p - 0.5 * (low + high));
    double flank = -1e30;
    for (const Vec3& p : given.vertices) {
      if ((p - Vec3(0.05, 0.04, p.z())).norm() < 0.06) flank = std::max(flank, p.z());
    }
    for (Vec3& p : given.vertices) p.z() += 0.215 - flank;
    copy = report.folder / "cow";
    std::filesystem::create_directories(*copy);
    for (const char* file : {"cow.toml", "cow.urdf", "probe.obj"}) {
      std::filesystem::copy_file(scenes / file, *copy / file,
                                 std::filesystem::copy_options::overwrite_existing);
    }
    write_obj(*copy / "cow.obj", "given mesh", given);
    scenes = *copy;
  }
  std::vector<Image> pictures;
  double worst = 0.0;
  const int last = report.quick ? 16 : 0;
  for (const bool local : {false, true}) {
    PaperAsk ask;
    ask.scene = scenes / "cow.toml";
    ask.measures = true;
    ask.last = last;
    if (!local) ask.overrides = {"muscle.cow.weights=even", "muscle.cow.damping=0"};
    const PaperRun run = run_scene(ask);
    const MuscleState& now = run.state.muscles[0];
    const Momentum gained = momentum_of(run.model.muscles[0], now);
    const double size = std::max(now.impulse.norm(), 1e-30);
    const double angular = std::max(now.angular_impulse.norm(), 0.3 * size);
    worst = std::max({worst, (gained.linear - now.impulse).norm() / size,
                      (gained.angular - now.angular_impulse).norm() / angular});
    table.add(local ? "cow, local zone" : "cow, global zone", run, run.seconds, "1e-4", "20.7");
    ask.last = 17;  // pressed deepest
    pictures.push_back(draw_run(report.quick ? run : run_scene(ask), true));
    report.done();
  }
  report.add(pictures, {"global zone", "local zone"}, "figure6_cow.png",
             "Figure 6: the same ball, volume moved everywhere or near it.");
  report.add({"Momentum of the free cow that the ball did not give, share of its impulse",
              number(worst, 2), "<= 1e-10", worst <= 1e-10, ""});
}

void holes(PaperReport& report, Table2& table) {
  report.section("Bodies with holes",
                 "A torus and a surface of genus 2 between planes: the enclosed "
                 "volume knows nothing of topology.");
  std::vector<Image> pictures;
  for (const char* scene : {"torus", "two_rings"}) {
    const PaperRun run = run_measured(report, scene, {}, report.quick ? 16 : 0);
    table.add(scene, run, run.seconds, "", "");
    pictures.push_back(draw_run(run, false));
    report.done();
  }
  report.add(pictures, {"torus", "genus 2"}, "holes.png",
             "Pressed between planes that are not drawn.");
}

void finger(PaperReport& report, Table2& table) {
  report.section("Finger on a block (figures 2, 4 and 5)",
                 "Compressible, then with its volume moved everywhere, then in a zone that grows "
                 "with load and time.");
  std::vector<Image> pictures;
  LineChart zone{"Figure 5: radius of the zone", "mm", {}, {}, false, {}};
  for (const char* overrides : {"solver.volume=none", "muscle.finger.weights=even", ""}) {
    std::vector<std::string> set;
    if (*overrides) set.push_back(overrides);
    const PaperRun run = run_measured(report, "finger", set, report.quick ? 16 : 0);
    pictures.push_back(draw_run(run, true));
    if (set.empty()) {
      zone.x = run.frames;
      zone.lines.push_back({"local", run.zone_radius});
      for (double& radius : zone.lines[0].values) radius *= 1e3;
    }
    if (!*overrides || overrides[0] == 'm') {
      table.add(set.empty() ? "finger, local" : "finger, global", run, run.seconds, "", "");
    }
    report.done();
  }
  report.add(pictures, {"compressible", "global", "local"}, "figure2_finger.png",
             "Figures 2 and 4: the pressed finger.");
  report.add(zone, "figure5_zone.svg",
             "The zone grows with the load and the time it acts, up to the user's threshold.");
}

void muscles(PaperReport& report, Table2& table) {
  report.section(
      "Three muscles (figure 3) and the arm (figures 1 and 7d, 7e)",
      "One shortening with weights left, even and right; twelve muscles at an elbow of 130°.");
  const PaperRun three = run_measured(report, "three_muscles", {});
  table.add("three muscles", three, three.seconds, "", "");
  report.add({draw_run(three, false)}, {"weights left, even, right, from above"},
             "figure3_muscles.png", "Figure 3: the weights alone move the volume.");
  report.done();
  PaperAsk ask;
  ask.scene = report.scenes / "../arm/arm.toml";
  ask.overrides = {"skin.enabled=false"};
  ask.last = report.quick ? 12 : 0;
  const PaperRun bare = run_scene(ask);
  table.add("12 muscles, elbow flexion", bare, bare.seconds, "1e-4", "32.34");
  report.done();
  std::vector<Image> pictures;
  for (const int frame : report.quick ? std::vector<int>{12} : std::vector<int>{1, 40, 60}) {
    ask.overrides = {};
    ask.last = std::max(frame, 2);
    const PaperRun run = run_scene(ask);
    pictures.push_back(draw_run(run, true, "muscles"));
    pictures.push_back(draw_run(run, true, "skin"));
    report.done();
  }
  std::vector<std::string> labels;
  for (size_t i = 0; i < pictures.size(); ++i)
    labels.push_back(i % 2 ? "with skin" : "without skin");
  report.add(pictures, labels, "figure7_arm.png", "Figures 1, 7d, 7e: the arm.");
}

}  // namespace

void paper_bodies(PaperReport& report) {
  Table2 table;
  cubes(report, table);
  cow(report, table);
  holes(report, table);
  finger(report, table);
  muscles(report, table);
  table.table.note =
      "Every scene of 30 frames a second but the arm (24), contact included, one thread. Explicit "
      "substeps are "
      "0.8 of the stable step; materials stand in assets/paper and assets/arm.";
  report.add(table.table);
  report.add({"Volume error of every other scene, every frame", number(table.worst, 2), "<= 1e-12",
              table.worst <= 1e-12, ""});
}

int paper_steps(bool quick) {
  const int ball = 1 + (quick ? 3 * 8 + 3 * 8 + 8 : 7 * 8 + 7 * 8 + 3 * 8) + 3 + (quick ? 3 : 6);
  return ball + 3 + 2 + 2 + 3 + 2 + (quick ? 1 : 3) + 1;
}

}  // namespace thew
