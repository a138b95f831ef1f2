// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/arm.h"

#include <cmath>

#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tools/lab/base/play.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/shapes.h"
#include "tools/lab/related/methods.h"

namespace thew::tools {
namespace {

constexpr double kHeldBeyond = 0.9;  // of the half length, beyond which a spindle is held
constexpr double kDensity = 1060.0;  // kg/m^3
constexpr int kTriangles = 1470, kTetrahedra = 2691;
constexpr int kWay = 30, kRest = 15;  // frames of 1/30 s, coming nearer and held
constexpr const char* kOfElements = "biceps_long";
constexpr const char* kFlexors[] = {"biceps_long", "biceps_short", "brachialis"};

// Mean area of the sections across x between two places, which is the volume between over the way.
// By the trapezoidal rule over many sections; each is the polygon in which a plane cuts triangles.
double mean_section(const Points& x, const std::vector<Triangle>& triangles, double from,
                    double to) {
  constexpr int kSections = 40;
  double sum = 0.0;
  for (int k = 0; k < kSections; ++k) {
    const double at = from + (to - from) * (k + 0.5) / kSections;
    double twice = 0.0;
    for (const Triangle& t : triangles) {
      Vec3 cut[2];
      bool leaves[2] = {};
      int found = 0;
      for (int e = 0; e < 3 && found < 2; ++e) {
        const Vec3 a = to_vec(x[t[e]]), b = to_vec(x[t[(e + 1) % 3]]);
        if ((a.x() < at) == (b.x() < at)) continue;
        leaves[found] = a.x() < at;
        cut[found++] = a + (at - a.x()) / (b.x() - a.x()) * (b - a);
      }
      if (found < 2) continue;
      const double area = cut[0].y() * cut[1].z() - cut[0].z() * cut[1].y();
      twice += leaves[0] ? -area : area;
    }
    sum += 0.5 * std::abs(twice) / kSections;
  }
  return sum;
}

Vec3 spindle_axes(double length, double volume) {
  const double half = 0.5 * length;
  const double side = std::sqrt(volume / (4.0 / 3.0 * 3.14159265358979 * half));
  return {half, side, side};
}

RivalBody spindle(const Vec3& axes, bool solid) {
  TriMesh ball = paper_ball(kTriangles);
  TetMesh filled;
  if (solid) filled = fill_ball(ball, kTetrahedra);
  for (std::vector<Vec3>* nodes : {&ball.vertices, &filled.vertices}) {
    for (Vec3& p : *nodes) p = p.cwiseProduct(axes);
  }
  RivalBody body = solid ? solid_body(filled, kDensity) : surface_body(ball, kDensity);
  for (size_t i = 0; i < body.rest.size(); ++i) {
    body.driven[i] = std::abs(body.rest[i].x()) > kHeldBeyond * axes.x();
  }
  return body;
}

// The spindle with its ends nearer by a share of its length.
ArmSection::Shown shown_by(const RelatedMethod& method, const Vec3& axes, double share) {
  RivalBody body = spindle(axes, method.solid);
  const double rest = volume_of(body), end = kHeldBeyond * axes.x();
  const double before = mean_section(body.x, body.triangles, -end, end);
  const double least = share * axes.x();  // m, that each end moves
  Surroundings around;
  around.drive = [&](double time, const std::vector<Vec3>& at, Points& x) {
    for (size_t i = 0; i < at.size(); ++i) {
      if (!body.driven[i]) continue;
      x[i] = to_point(at[i] - Vec3(std::copysign(std::min(time, 1.0) * least, at[i].x()), 0, 0));
    }
  };
  const Stepper step = method.dials[0].make(body, 10.0);
  const double h = 1.0 / kWay;
  for (int k = 1; k <= kWay + kRest; ++k) step(around, k * h, h, body);
  const double now = mean_section(body.x, body.triangles, -(end - least), end - least);
  return {now / before, std::abs(volume_of(body) / rest - 1.0)};
}

const RelatedMethod& named(const std::vector<RelatedMethod>& methods, const std::string& name) {
  for (const RelatedMethod& method : methods) {
    if (method.name == name) return method;
  }
  throw std::runtime_error(name);
}

void add_rivals(const std::vector<RelatedMethod>& methods, double length, double volume,
                ArmSection& row) {
  const Vec3 axes = spindle_axes(length, volume);
  row.ellipsoid = shown_by(named(methods, "Scheepers 1997"), axes, row.shortening);
  row.profile = shown_by(named(methods, "Aubel 2001"), axes, row.shortening);
  if (row.muscle == kOfElements) {
    row.elements = shown_by(named(methods, "Chen 1992"), axes, row.shortening);
  }
}

}  // namespace

std::vector<ArmSection> arm_sections(const std::filesystem::path& file,
                                     const std::vector<double>& degrees) {
  Scene scene = read_scene(file);
  scene.skin.mesh.clear();
  scene.skin.skinned = false;
  const Model model = build_model(scene);
  const int elbow = find_joint(model.skeleton, "elbow");
  const std::vector<RelatedMethod> methods = related_methods(true);
  const int count = static_cast<int>(model.muscles.size());
  std::vector<ArmSection> rows;
  std::vector<double> length(count), area(count);
  Measuring measuring = start_measuring(model, initial_state(model));
  Parallel one(1);
  size_t next = 0;
  play(model, settled_state(model), 0, [&](int frame, State& state) {
    std::vector<double> joints;
    joints_at(model, (frame - model.first_frame) / model.fps, joints);
    if (next == degrees.size() || joints[elbow] / kDegree < degrees[next] - 1e-6) return;
    const FrameMeasures measures = measure(model, measuring, one, state);
    for (int m = 0; m < count; ++m) {
      const MuscleMeasures& found = measures.muscles[m];
      if (next == 0) length[m] = found.length, area[m] = found.area_ratio;
      const Muscle& muscle = model.muscles[m];
      const double belly =
          muscle.shape.belly[1] - muscle.shape.belly[0] + length[m] - muscle.shape.rest_path_length;
      ArmSection& row = rows.emplace_back();
      row.muscle = muscle.name;
      row.degrees = joints[elbow] / kDegree;
      row.rest_area = area[m] * measuring.rest_areas[m];
      row.shortening = (length[m] - found.length) / belly;
      row.ours = {found.area_ratio / area[m], found.volume_error};
      add_rivals(methods, belly, muscle.rest_volume, row);
    }
    ++next;
  });
  return rows;
}

Table sections_of(const std::vector<ArmSection>& rows) {
  Table table{
      "arm.csv",
      "The arm: sections of its muscles as the elbow bends",
      "Mean section of a belly over that at 0 degrees, then |V/V0 - 1|. Constant volume: what "
      "a belly of its length has to have. Thew: on the arm, round bones and beside one "
      "another. The others: each muscle a spindle by itself of the same length and volume. "
      "Flexors: biceps and brachialis, their sections together.",
      {"elbow", "muscle", "belly's length", "constant volume", "Thew", "volume", "Scheepers 1997",
       "volume", "Aubel 2001", "volume", "Chen 1992", "volume"},
      {}};
  const auto text = [](const ArmSection::Shown& shown, std::vector<std::string>& row) {
    const bool has = shown.section > 0.0;
    row.push_back(has ? number(shown.section) : "");
    row.push_back(has ? number(shown.volume_error, 2) : "");
  };
  for (size_t k = 0; k < rows.size();) {
    const double degrees = rows[k].degrees;
    double rest = 0.0, ours = 0.0, ellipsoid = 0.0, profile = 0.0;
    for (; k < rows.size() && rows[k].degrees == degrees; ++k) {
      const ArmSection& one = rows[k];
      std::vector<std::string>& row = table.rows.emplace_back();
      row = {number(degrees), one.muscle, number(1.0 - one.shortening),
             number(1.0 / (1.0 - one.shortening))};
      for (const ArmSection::Shown* shown :
           {&one.ours, &one.ellipsoid, &one.profile, &one.elements}) {
        text(*shown, row);
      }
      for (const char* flexor : kFlexors) {
        if (one.muscle != flexor) continue;
        rest += one.rest_area;
        ours += one.rest_area * one.ours.section;
        ellipsoid += one.rest_area * one.ellipsoid.section;
        profile += one.rest_area * one.profile.section;
      }
    }
    if (rest == 0.0) continue;
    table.rows.push_back({number(degrees), "flexors", "", "", number(ours / rest), "",
                          number(ellipsoid / rest), "", number(profile / rest), "", "", ""});
  }
  return table;
}

}  // namespace thew::tools
