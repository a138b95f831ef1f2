// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/chart/maps.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "muscles/volume.h"
#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"
#include "tools/base/signals.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr double kPhase = 0.6;     // s: to the load, there, back, at rest
constexpr double kMostWork = 3e7;  // nodes times substeps that an explicit cell may take
constexpr int kMostNodes = 2000;   // of a body that hundreds of runs are made of
const std::vector<double> kSteps = {0.00625, 0.025, 0.1, 0.2};  // s

struct Method {
  std::string integrator;
  int iterations;
};
const std::vector<Method> kMethods = {
    {"local_global", 3}, {"xpbd", 10}, {"explicit", 1}, {"quasi_static", 1}};

struct Quantity {
  std::string name, unit;
  std::vector<double> columns;
};
const std::vector<Quantity> kQuantities = {
    {"stiffness", "times the scene's", {1e-4, 1e-2, 1, 1e2, 1e4, 1e6}},
    {"nodes with weight", "all others 0", {1, 10, 30, 100, 1e9}},
    {"squeezed to", "% of its height", {60, 40, 20, 10, 5}},
    {"twisted by", "degrees", {90, 180, 360, 540, 720}},
    {"struck at", "m/s", {1, 3, 10, 30}},
    {"planes overlap it at rest", "% of its height", {5, 10, 20, 30, 45}}};

struct Body {
  TriMesh mesh;  // longest along x, thinnest along y, about the origin
  Vec3 size;     // m
  SpringMaterial material;
};

Body body_of(const fs::path& file) {
  const ModelDef def = define_model(read_scene(file));
  if (def.muscles.empty()) throw Error(ErrorCode::kUsage, file.string() + ": has no muscle to map");
  const MuscleDef& first = def.muscles[0];
  Body body{first.mesh, {}, first.material};
  if (body.mesh.vertices.size() > kMostNodes) {
    throw Error(ErrorCode::kUsage,
                file.string() + ": muscle \"" + first.name + "\" has " +
                    std::to_string(body.mesh.vertices.size()) +
                    " nodes; the maps take hundreds of runs of the first muscle, "
                    "give a scene whose first has 2,000 at most");
  }
  const Bounds bounds = bounds_of(body.mesh.vertices);
  const Vec3 extent = bounds.high - bounds.low, middle = bounds.centre();
  std::array<int, 3> axis = {0, 1, 2};
  std::stable_sort(axis.begin(), axis.end(), [&](int a, int b) { return extent[a] > extent[b]; });
  std::swap(axis[1], axis[2]);
  Mat3 turn = Mat3::Zero();
  for (int k = 0; k < 3; ++k) turn(k, axis[k]) = 1.0;
  if (turn.determinant() < 0.0) turn.row(2) *= -1.0;
  for (Vec3& p : body.mesh.vertices) p = turn * Vec3(p - middle);
  body.size = Vec3(extent[axis[0]], extent[axis[1]], extent[axis[2]]);
  return body;
}

// Two planes that close along y, two hands that hold the ends and turn about x.
enum Part { kFrame, kTop, kBottom, kLeft, kRight };

Skeleton rig_of(const Body& body) {
  using Joint = Skeleton::JointType;
  Skeleton rig;
  const auto add = [&](const char* name, int parent, double y, Joint type, const Vec3& axis) {
    rig.body_names.push_back(name);
    rig.parent.push_back(parent);
    rig.joint_in_parent.push_back(Transform(Eigen::Translation3d(0.0, y, 0.0)));
    rig.joint_names.push_back(parent < 0 ? "" : name);
    rig.joint_types.push_back(type);
    rig.joint_axes.push_back(axis);
    rig.lower.push_back(-100.0);
    rig.upper.push_back(100.0);
    rig.visuals.emplace_back();
  };
  const double half = 0.5 * body.size.y();
  add("frame", -1, 0.0, Joint::kFixed, Vec3::UnitX());
  add("top", kFrame, half, Joint::kPrismatic, -Vec3::UnitY());
  add("bottom", kFrame, -half, Joint::kPrismatic, Vec3::UnitY());
  add("left", kFrame, 0.0, Joint::kFixed, Vec3::UnitX());
  add("right", kFrame, 0.0, Joint::kRevolute, Vec3::UnitX());
  return rig;
}

// A slab as thick as the body and four times as wide, outside of the plane that it ends at.
Bone plane_of(const Body& body, const char* name, Part part) {
  const double side = 4.0 * body.size.x(), thick = body.size.y();
  Bone bone{name, part, paper_cube(4, false)};
  for (Vec3& p : bone.in_body.vertices) {
    p = p.cwiseProduct(Vec3(side, thick, side));
    p.y() += (part == kTop ? 0.5 : -0.5) * thick;
  }
  return bone;
}

// The rig's motion: of both planes (m), or of the right hand (rad).
Clip clip_of(const std::string& quantity, double value, const Body& body) {
  const double height = body.size.y();
  const bool twists = quantity == "twisted by";
  double before = 0.0, load = 0.2 * height, begin = 0.0;  // each plane's way to 60 %
  if (quantity == "squeezed to") load = 0.5 * height * (1.0 - 0.01 * value);
  if (quantity == "struck at") begin = std::max(kPhase - load / value, 1e-3);
  if (quantity == "planes overlap it at rest") before = load = 0.5 * height * 0.01 * value;
  if (twists) load = value * kDegree;
  Clip clip;
  clip.interpolation = Clip::Interpolation::kLinear;
  clip.joints =
      twists ? std::vector<std::string>{"right"} : std::vector<std::string>{"top", "bottom"};
  const auto key = [&](double time, double x) {
    clip.times.push_back(time);
    clip.values.emplace_back(clip.joints.size(), x);
  };
  key(0.0, before);
  if (begin > 0.0) key(begin, before);
  key(kPhase, load);
  key(2.0 * kPhase, load);
  key(3.0 * kPhase, twists ? 0.0 : std::min(before, 0.0) - 0.02 * height);
  return clip;
}

// 1 for those nearest to the top of the body, 0 for all others.
std::vector<double> weights_at_top(const Body& body, double count) {
  std::vector<size_t> order(body.mesh.vertices.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  const Vec3 top(0.0, 0.5 * body.size.y(), 0.0);
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    return (body.mesh.vertices[a] - top).norm() < (body.mesh.vertices[b] - top).norm();
  });
  std::vector<double> weights(order.size(), 0.0);
  const size_t weighted = static_cast<size_t>(std::min(count, 1.0 * order.size()));
  for (size_t i = 0; i < weighted; ++i) weights[order[i]] = 1.0;
  return weights;
}

std::vector<int> held_ends(const Body& body) {
  const double end = 0.45 * body.size.x();
  std::vector<int> held;
  for (const Vec3& p : body.mesh.vertices) {
    held.push_back(p.x() <= -end ? kLeft : p.x() >= end ? kRight : -1);
  }
  return held;
}

Model model_of(const Body& body, const std::string& quantity, double value) {
  const bool twists = quantity == "twisted by";
  ModelDef def;
  def.name = "maps";
  def.fps = 1000.0;
  def.last_frame = 3000;
  def.settle = 0.0;
  def.gravity = Vec3::Zero();
  def.skeleton = rig_of(body);
  def.clip = clip_of(quantity, value, body);
  MuscleDef& muscle = def.muscles.emplace_back();
  muscle.name = "body";
  muscle.mesh = body.mesh;
  muscle.guide = 0.0;
  muscle.damping = 20.0;
  muscle.material = body.material;
  muscle.material.anisotropy = 1.0;
  muscle.material.shape = 0.0;
  if (quantity == "stiffness") muscle.material.stiffness *= value;
  if (quantity == "nodes with weight") muscle.weights = weights_at_top(body, value);
  if (twists) muscle.fixed_to = held_ends(body);
  def.bones = {plane_of(body, "top", kTop), plane_of(body, "bottom", kBottom)};
  def.contact.enabled = !twists;
  def.contact.settings.margin = def.contact.settings.max_depth = 0.25 * body.size.y();
  def.contact.settings.gap = 0.0;
  return build_model(def);
}

int inverted_triangles(const Surface& surface, const Points& x) {
  const std::vector<Triangle>& triangles = surface.triangles;
  std::vector<Vec3> normals, sums(x.size(), Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 a = to_vec(x[t[0]]);
    normals.push_back((to_vec(x[t[1]]) - a).cross(to_vec(x[t[2]]) - a));
    for (const int i : t) sums[i] += normals.back();
  }
  int inverted = 0;
  for (size_t k = 0; k < triangles.size(); ++k) {
    Vec3 around = -3.0 * normals[k];
    for (const int i : triangles[k]) around += sums[i];
    inverted += normals[k].dot(around) < 0.0;
  }
  return inverted;
}

double energy_of(const Muscle& muscle, const MuscleState& now) {
  double energy = spring_energy(muscle.springs, now.rest_length, now.x);
  for (size_t i = 0; i < now.v.size(); ++i) {
    if (!muscle.driven[i]) energy += 0.5 * muscle.mass[i] * to_vec(now.v[i]).squaredNorm();
  }
  return energy;
}

// Runs all phases; `last`: positions at the end.
MapCell run_cell(Model model, const Method& method, double h, double size, Points& last) {
  MapCell cell;
  model.fps = 1.0 / h;
  model.solver.rungs = false;
  model.solver.integrator = integrator_of(method.integrator);
  model.solver.iterations = method.iterations;
  const Muscle& muscle = model.muscles[0];
  const int phase = static_cast<int>(std::lround(kPhase / h));
  if (method.integrator == "explicit") {
    const double work = 1.0 * explicit_substeps(model, 0, h) * 4 * phase * muscle.mass.size();
    if (work > kMostWork) {
      cell.failure = "not run: " + std::to_string(explicit_substeps(model, 0, h)) + " parts a step";
      return cell;
    }
  }
  State state = initial_state(model);
  const MuscleState& now = state.muscles[0];
  Parallel one(1);
  StageSeconds stages;
  double at_rest = 0.0, floor = 0.0;  // energy when the rig came to rest; what does not count
  try {
    for (int frame = 1; frame <= 4 * phase; ++frame) {
      if (interrupted()) throw Error(ErrorCode::kRetry, "interrupted; run the command again");
      step_frame(model, frame * h, one, state, stages);
      const double energy = energy_of(muscle, now);
      const bool rests = (frame - 1) / phase % 2 == 1;
      floor = std::max(floor, 1e-6 * energy);
      if (frame % phase == 0 && !rests) at_rest = std::max(energy, floor);
      if (rests) cell.growth = std::max(cell.growth, energy / at_rest);
      cell.last_volume =
          std::abs(enclosed_volume(now.x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
      cell.last_inverted = inverted_triangles(model.surfaces[0].surface, now.x);
      cell.volume_error = std::max(cell.volume_error, cell.last_volume);
      cell.inverted = std::max(cell.inverted, cell.last_inverted);
    }
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kSolver) throw;
    cell.failure = error.what();
    cell.verdict = Verdict::kDiverged;
    return cell;
  }
  for (const Point& v : now.v) cell.speed = std::max(cell.speed, to_vec(v).norm() / size);
  last = now.x;
  return cell;
}

void judge(const Points& finest, const Points& last, double size, MapCell& cell) {
  if (cell.verdict == Verdict::kDiverged || last.empty()) return;
  if (!finest.empty()) {
    double sum = 0.0;
    for (size_t i = 0; i < last.size(); ++i) {
      sum += (to_vec(last[i]) - to_vec(finest[i])).squaredNorm();
    }
    cell.distance = std::sqrt(sum / static_cast<double>(last.size())) / size;
  }
  const bool ends_well = cell.last_volume <= kMapVolume && cell.last_inverted == 0 &&
                         cell.speed <= kMapSpeed && cell.distance <= kMapDistance;
  const bool always_well =
      cell.volume_error <= kMapVolume && cell.inverted == 0 && cell.growth <= kMapGrowth;
  cell.verdict = cell.growth > 10.0 || !(cell.last_volume < 0.01) ? Verdict::kDiverged
                 : !ends_well                                     ? Verdict::kDegraded
                 : always_well                                    ? Verdict::kAccurate
                                                                  : Verdict::kRecovered;
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  constexpr const char* kNames[] = {"accurate", "degraded", "recovered", "diverged", "not run"};
  return kNames[static_cast<int>(verdict)];
}

std::vector<StabilityMap> run_maps(const MapAsk& ask) {
  const Body body = body_of(ask.scene);
  const double size = body.size.norm();
  std::vector<StabilityMap> maps;
  int total = 0, done = 0;
  std::vector<Method> methods = kMethods;
  std::vector<Quantity> asked = kQuantities;
  std::erase_if(methods, [&](const Method& m) {
    return !ask.only_method.empty() && m.integrator != ask.only_method;
  });
  std::erase_if(asked, [&](const Quantity& q) {
    return !ask.only_quantity.empty() && q.name != ask.only_quantity;
  });
  for (const Method& method : methods) {
    for (const Quantity& quantity : asked) {
      StabilityMap map{method.integrator, quantity.name, quantity.unit,
                       quantity.columns,  kSteps,        {}};
      if (method.integrator == "quasi_static") map.steps = {0.1, 0.2};  // it knows no step
      map.cells.assign(map.steps.size(), std::vector<MapCell>(map.columns.size()));
      total += static_cast<int>(map.steps.size() * map.columns.size());
      maps.push_back(map);
    }
  }
  std::mutex one_at_a_time;
  Parallel parallel(ask.threads);
  const size_t quantities = asked.size();
  for (size_t q = 0; q < quantities; ++q) {
    for (size_t column = 0; column < asked[q].columns.size(); ++column) {
      const Model model = model_of(body, asked[q].name, asked[q].columns[column]);
      parallel.each(static_cast<int>(methods.size()), [&](int k) {
        StabilityMap& map = maps[k * quantities + q];
        Points finest;
        for (size_t s = 0; s < map.steps.size(); ++s) {
          Points last;
          MapCell& cell = map.cells[s][column];
          cell = run_cell(model, methods[k], map.steps[s], size, last);
          judge(finest, last, size, cell);
          if (finest.empty()) finest = last;
          const std::lock_guard lock(one_at_a_time);
          ask.on_cell(++done, total);
        }
      });
    }
  }
  return maps;
}

}  // namespace thew::tools
