// SPDX-License-Identifier: Apache-2.0
//
// Table 2 and figures 1 to 7 but the ball: cubes, cow, bodies with holes, finger, muscles, arm.
#include <algorithm>
#include <cmath>
#include <optional>

#include "muscles/volume.h"
#include "rig/import/mesh_import.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/cache/durable_file.h"
#include "sim/solver/muscle_step.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/report.h"
#include "tools/lab/paper/run.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

struct Table2 {
  Table table{"table2.csv",
              "Table 2: errors and speed",
              "",
              {"scene", "triangles", "substeps", "error", "printed", "frames per CPU s", "printed",
               "penetration, m"},
              {}};
  double worst = 0.0;

  void add(const std::string& scene, const PaperRun& run, double seconds, const std::string& error,
           const std::string& frames) {
    int triangles = 0;
    for (const Muscle& muscle : run.model->muscles) {
      triangles += static_cast<int>(muscle.rest.triangles.size());
    }
    worst = std::max(worst, run.volume_error);
    const Scene& settings = *run.scene;
    const std::string substeps =
        settings.solver.integrator == "explicit"
            ? std::to_string(explicit_substeps(*run.model, 0, 1.0 / settings.fps))
            : std::to_string(settings.solver.substeps) + " implicit";
    table.rows.push_back({scene, std::to_string(triangles), substeps, number(run.volume_error, 2),
                          error, number(1.0 / seconds), frames, number(run.penetration, 2)});
  }
};

const PaperView kBare{"", false, false}, kZone{"", true, true};

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
  constexpr int kCells = 8;  // along an edge, as the surface has squares
  FemBody body;
  body.material = {.shear = 1000.0, .lambda = 1000.0, .penalty = penalty};
  const auto node = [](int i, int j, int k) { return (i * (kCells + 1) + j) * (kCells + 1) + k; };
  for (int i = 0; i <= kCells; ++i) {
    for (int j = 0; j <= kCells; ++j) {
      for (int k = 0; k <= kCells; ++k) {
        body.rest.push_back(0.2 / kCells * Vec3(i, j, k) - Vec3::Constant(0.1));
        for (int d = 0; d < 3; ++d) body.fixed.push_back(j == 0 || j == kCells);
      }
    }
  }
  for (int cube = 0; cube < kCells * kCells * kCells; ++cube) {
    for (const auto& order : kKuhnOrders) {
      int at[3] = {cube / (kCells * kCells), cube / kCells % kCells, cube % kCells};
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
      "Cube twisted by 180° and 360° (figure 7) and under a local load",
      "Bottom fixed, top turned: conventional, volume-preserving, and linear finite elements "
      "with the penalty, which know no rotation and swell.");
  const int half = report.quick ? 31 : 61;
  PaperAsk ask{report.scenes / "cube_twist.toml", {}, report.quick ? half : 121, {half, 91}, true};
  const PaperRun exact = run_scene(ask);
  ask.overrides = {"solver.volume=none"};
  const PaperRun none = run_scene(ask);
  report.done();
  table.add("cube twisted", exact, exact.seconds, "1e-5", "83.3");
  bool converged = false;
  const double angle = kPi * (half - 1) / 60.0;
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
      {picture_of(none, none.kept.at(half), kBare), picture_of(exact, exact.kept.at(half), kBare),
       picture_of(*exact.scene, {fem.x, boundary(tetrahedra)})},
      {"conventional, V/V0 = " + number(none.volume.at(half - 1)), "volume-preserving",
       "linear FEM, V/V0 = " + number(1.0 + swelling) + ", " + std::to_string(inverted) +
           " inverted"},
      "figure7_cube.png",
      "Figure 7: the twisted cube. The finite elements without a penalty swell; with one of 1e4 Pa "
      "V/V0 is " +
          number(fem_volume(held) / 0.008) + (converged ? "." : ", not converged."));
  if (!report.quick) {
    report.add(
        {picture_of(none, none.kept.at(91), kBare), picture_of(exact, exact.kept.at(91), kBare)},
        {"conventional, V/V0 = " + number(none.volume.at(90)), "volume-preserving"},
        "figure7_cube_270.png",
        "Turned on to 270°. A membrane does not meet itself: beyond 180° its walls go through "
        "one another, and at 360° the cube stands as if untwisted. Its volume holds all the "
        "way.");
  }
  report.done();
  const PaperRun load = run_measured(report, "cube_load", {}, report.quick ? 9 : 0);
  table.add("cube, local load", load, load.seconds, "1e-4", "21.3");
  const State& pressed = load.state;
  report.add({picture_of(load, pressed, {}), picture_of(load, pressed, kZone)},
             {"volume-preserving, local zone", "the zone's weights"}, "cube_load.png",
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

// m by which each node moved out of the rest shape; the whole body's own way is not counted.
std::vector<double> outward(const Muscle& muscle, const MuscleState& now) {
  const std::vector<Vec3> normals = vertex_normals(muscle.rest);
  const std::vector<Vec3>& rest = muscle.rest.vertices;
  Vec3 way = Vec3::Zero();
  for (size_t i = 0; i < rest.size(); ++i) way += (to_vec(now.x[i]) - rest[i]) / rest.size();
  std::vector<double> out;
  for (size_t i = 0; i < rest.size(); ++i) {
    out.push_back(std::max(0.0, normals[i].dot(to_vec(now.x[i]) - rest[i] - way)));
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
    const Bounds bounds = bounds_of(given.vertices);
    // As long as ours, its flank where the ball comes.
    const double scale = 1.2 / (bounds.high - bounds.low).maxCoeff();
    for (Vec3& p : given.vertices) p = scale * (p - bounds.centre());
    double flank = -1e30;
    for (const Vec3& p : given.vertices) {
      if ((p - Vec3(0.05, 0.04, p.z())).norm() < 0.06) flank = std::max(flank, p.z());
    }
    for (Vec3& p : given.vertices) p.z() += 0.215 - flank;
    copy = report.folder / "cow";
    claim_folder(*copy);
    for (const char* file : {"cow.toml", "cow.urdf", "probe.obj"}) {
      write_durably(report.place("cow/" + std::string(file)), read_whole(scenes / file, 1 << 20));
    }
    write_durably(report.place("cow/cow.obj"), shape_text("given mesh", given));
    scenes = *copy;
  }
  std::vector<PaperPicture> pictures;
  std::vector<std::string> labels;
  double worst = 0.0;
  const int last = report.quick ? 16 : 0;
  for (const bool local : {false, true}) {
    PaperAsk ask;
    ask.scene = scenes / "cow.toml";
    ask.measures = true;
    ask.last = last;
    ask.keep = {std::min(17, report.quick ? last : 17)};  // pressed deepest
    if (!local) ask.overrides = {"muscle.cow.weights=even", "muscle.cow.damping=0"};
    const PaperRun run = run_scene(ask);
    const MuscleState& now = run.state.muscles[0];
    const Momentum gained = momentum_of(run.model->muscles[0], now);
    const double size = std::max(now.contact_impulse.impulse.norm(), 1e-30);
    const double angular = std::max(now.contact_impulse.angular_impulse.norm(), 0.3 * size);
    worst = std::max({worst, (gained.linear - now.contact_impulse.impulse).norm() / size,
                      (gained.angular - now.contact_impulse.angular_impulse).norm() / angular});
    table.add(local ? "cow, local zone" : "cow, global zone", run, run.seconds, "1e-4", "20.7");
    const State& pressed = run.kept.begin()->second;
    PaperView bulge = kBare;
    bulge.values = outward(run.model->muscles[0], pressed.muscles[0]);
    const double most = *std::max_element(bulge.values.begin(), bulge.values.end());
    pictures.push_back(picture_of(run, pressed, {}));
    pictures.push_back(picture_of(run, pressed, bulge));
    labels.push_back(local ? "local zone" : "global zone");
    labels.push_back("what came out, " + number(1e3 * most, 2) + " mm at most");
    report.done();
  }
  report.add(pictures, labels, "figure6_cow.png",
             "Figure 6: the same ball, volume moved everywhere or near it. Colours: how far the "
             "surface came out, without the ball, each to its own largest.");
  report.add({"Momentum of the free cow that the ball did not give, share of its impulse",
              number(worst, 2), "<= 1e-10", worst <= 1e-10, ""});
}

void holes(PaperReport& report, Table2& table) {
  report.section("Bodies with holes",
                 "A torus and a surface of genus 2 between planes: the enclosed "
                 "volume knows nothing of topology.");
  std::vector<PaperPicture> pictures;
  for (const char* scene : {"torus", "two_rings"}) {
    const PaperRun run = run_measured(report, scene, {}, report.quick ? 16 : 0);
    table.add(scene, run, run.seconds, "", "");
    pictures.push_back(picture_of(run, run.state, kBare));
    report.done();
  }
  report.add(pictures, {"torus", "genus 2"}, "holes.png",
             "Pressed between planes that are not drawn.");
}

void finger(PaperReport& report, Table2& table) {
  report.section("Finger on a block (figures 2, 4 and 5)",
                 "Compressible, then with its volume moved everywhere, then in a zone that grows "
                 "with load and time.");
  const int last = report.quick ? 16 : 61;
  const std::vector<int> times =
      report.quick ? std::vector<int>{6, 16} : std::vector<int>{6, 10, 16, 61};
  PaperAsk ask{report.scenes / "finger.toml", {"solver.volume=none"}, last, times, true};
  const PaperRun none = run_scene(ask);
  report.done();
  ask.overrides = {"muscle.finger.weights=even"};
  const PaperRun global = run_scene(ask);
  report.done();
  ask.overrides = {};
  const PaperRun local = run_scene(ask);
  report.done();
  table.add("finger, global", global, global.seconds, "", "");
  table.add("finger, local", local, local.seconds, "", "");
  const auto draw = [](const PaperRun& run, const PaperView& view) {
    return picture_of(run, run.state, view);
  };
  report.add({draw(none, {}), draw(global, {}), draw(local, {})},
             {"compressible, V/V0 = " + number(none.volume.back()), "global", "local"},
             "figure2_finger.png", "Figure 2: the pressed finger.");
  report.add({draw(global, kZone), draw(local, kZone)}, {"global: everywhere alike", "local"},
             "figure4_zone.png",
             "Figure 4: where the volume is moved, by weight: none, amber, crimson, most.");
  std::vector<PaperPicture> pictures;
  std::vector<std::string> labels;
  for (const auto& [frame, state] : local.kept) {
    pictures.push_back(picture_of(local, state, kZone));
    labels.push_back("frame " + std::to_string(frame) + ", radius " +
                     number(1e3 * state.muscles[0].zone_radius) + " mm");
  }
  report.add(pictures, labels, "figure5_zone.png",
             "Figure 5: the zone grows with the load and the time that it acts.");
  LineChart zone{"Figure 5: radius of the zone", "mm", local.frames, {}, false, {}};
  zone.lines.push_back({"local", local.zone_radius});
  for (double& radius : zone.lines[0].values) radius *= 1e3;
  report.add(
      zone, "figure5_zone.svg",
      "By frame at 30 fps: pressed from frame 1 to 16, then held. It grows with the load and "
      "the time that it acts, up to the user's threshold.");
}

// The last rows of the printed table 2, muscle by muscle.
void add_muscle_rows(const PaperRun& bare, const PaperRun& skinned, PaperReport& report) {
  const std::vector<int> printed = {680, 520, 760, 760, 1064, 440, 280, 840, 680, 680, 660, 1380};
  Table table{"table2_muscles.csv",
              "Table 2, last rows: the muscles of the arm",
              "",
              {"muscle", "triangles", "printed", "error", "with skin", "printed"},
              {}};
  for (size_t m = 0; m < bare.model->muscles.size(); ++m) {
    const Muscle& muscle = bare.model->muscles[m];
    table.rows.push_back({muscle.name, std::to_string(muscle.rest.triangles.size()),
                          std::to_string(printed.at(m)), number(bare.volume_errors[m], 2),
                          number(skinned.volume_errors[m], 2), "1e-4"});
  }
  report.add(table);
}

void muscles(PaperReport& report, Table2& table) {
  report.section(
      "Three muscles (figure 3) and the arm (figures 1 and 7d, 7e)",
      "One shortening with weights left, even and right; twelve muscles at an elbow of 130°.");
  const PaperRun three = run_measured(report, "three_muscles", {});
  table.add("three muscles", three, three.seconds, "", "");
  report.add({picture_of(three, three.state, kBare), picture_of(three, three.state, kZone)},
             {"from above: weights left, even, right", "the weights"}, "figure3_muscles.png",
             "Figure 3: the weights alone move the volume.");
  report.done();
  PaperAsk ask;
  ask.scene = report.scenes / "../arm/arm.toml";
  ask.overrides = {"skin.enabled=false"};
  ask.last = report.quick ? 12 : 0;
  const PaperRun bare = run_scene(ask);
  table.add("12 muscles, elbow flexion", bare, bare.seconds, "1e-4", "32.34");
  report.done();
  ask.overrides = {};
  if (report.quick) {
    ask.overrides = {"scene.settle=0.2"};
    ask.last = 6;
  }
  ask.keep = report.quick ? std::vector<int>{6} : std::vector<int>{1, 40, 60};
  const PaperRun skinned = run_scene(ask);
  table.add("the same with their skin", skinned, skinned.seconds, "", "");
  report.done();
  add_muscle_rows(bare, skinned, report);
  std::vector<PaperPicture> muscles, skin;
  std::vector<std::string> labels;
  for (const auto& [frame, state] : skinned.kept) {
    muscles.push_back(picture_of(skinned, state, {"muscles"}));
    skin.push_back(picture_of(skinned, state, {"skin"}));
    const int elbow = find_joint(skinned.model->skeleton, "elbow");
    labels.push_back("elbow at " + number(state.joints.at(elbow) / kDegree) + "°");
  }
  report.add(muscles, labels, "figure7_arm.png", "Figures 1 and 7d: the arm without its skin.");
  report.add(skin, labels, "figure7_arm_skin.png", "Figure 7e: the arm with its skin.");
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
      "substeps are 0.95 of a bound of the stable step; materials stand in assets/paper and "
      "assets/arm.";
  report.add(table.table);
  report.add({"Volume error of every other scene, every frame", number(table.worst, 2), "<= 1e-12",
              table.worst <= 1e-12, ""});
}

int paper_steps(bool quick) {
  const int truth = quick ? 2 : 4, penalties = quick ? 2 : 6;
  const int balls = quick ? 2 * (5 * 8 + 1) + 3 * 8 + 1 : 2 * (9 * 8 + 1) + 5 * 8 + 1;
  return truth + balls + 1 + penalties + 3 + 2 + 2 + 3 + 3 + 1;  // cubes, cow, holes, finger, arm
}

}  // namespace thew::tools
