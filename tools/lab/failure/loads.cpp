// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/loads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "rig/math.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/elements/fem_ball.h"
#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

constexpr int kMostNodes = 2000;  // of a body that hundreds of runs are made of
constexpr double kFilling = 2.0;  // tetrahedra over triangles, as in the paper's table 1

// The body's inside in tetrahedra, if its nodes lie on an ellipsoid.
TetMesh filled(const MapBody& body) {
  TriMesh ball = body.mesh;
  for (Vec3& p : ball.vertices) {
    p = p.cwiseQuotient(0.5 * body.size);
    if (std::abs(p.norm() - 1.0) > 0.02) return {};
  }
  const double triangles = static_cast<double>(ball.triangles.size());
  TetMesh solid = fill_ball(ball, static_cast<int>(kFilling * triangles));
  for (Vec3& p : solid.vertices) p = p.cwiseProduct(0.5 * body.size);
  return solid;
}

// Two planes that close along y, two hands that hold the ends and turn about x.
enum Part { kFrame, kTop, kBottom, kLeft, kRight };

Skeleton rig_of(const MapBody& body) {
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
Bone plane_of(const MapBody& body, const char* name, Part part) {
  const double side = 4.0 * body.size.x(), thick = body.size.y();
  Bone bone{name, part, paper_cube(4, false)};
  for (Vec3& p : bone.in_body.vertices) {
    p = p.cwiseProduct(Vec3(side, thick, side));
    p.y() += (part == kTop ? 0.5 : -0.5) * thick;
  }
  return bone;
}

// 1 for those nearest to the top of the body, 0 for all others.
std::vector<double> weights_at_top(const MapBody& body, double count) {
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

// A mesh's nodes by the triangles and tetrahedra around each.
struct Stars {
  std::vector<std::vector<Triangle>> triangles;
  std::vector<std::vector<Tetrahedron>> tetrahedra;
};

Stars stars_of(const MapBody& body) {
  Stars stars;
  stars.triangles.resize(body.mesh.vertices.size());
  stars.tetrahedra.resize(body.solid.vertices.size());
  for (const Triangle& t : body.mesh.triangles) {
    for (const int i : t) stars.triangles[i].push_back(t);
  }
  for (const Tetrahedron& t : body.solid.tetrahedra) {
    for (const int i : t) stars.tetrahedra[i].push_back(t);
  }
  return stars;
}

// Whether node i may go to a place: nothing around it turns over or by more than 60 degrees.
bool may_go(const MapBody& body, const Stars& stars, int i, const Vec3& to) {
  const auto normal = [&](const Triangle& t, bool moved) {
    const auto at = [&](int k) { return moved && t[k] == i ? to : body.mesh.vertices[t[k]]; };
    return Vec3((at(1) - at(0)).cross(at(2) - at(0)).normalized());
  };
  for (const Triangle& t : stars.triangles[i]) {
    if (!(normal(t, false).dot(normal(t, true)) > 0.5)) return false;
  }
  if (stars.tetrahedra.empty()) return true;
  TetMesh moved = {{}, {}};
  for (const Tetrahedron& t : stars.tetrahedra[i]) {
    moved.vertices.clear();
    for (const int k : t) moved.vertices.push_back(k == i ? to : body.solid.vertices[k]);
    if (!(signed_volume(moved, {0, 1, 2, 3}) > 0.0)) return false;
  }
  return true;
}

}  // namespace

const std::vector<Quantity>& map_quantities() {
  static const std::vector<Quantity> kAll = {
      {Load::kStiffness,
       "stiffness",
       "times the scene's",
       {1e-4, 1e-3, 1e-2, 0.1, 1, 10, 1e2, 1e3, 1e4, 1e5, 1e6}},
      {Load::kWeights, "nodes with weight", "(all others 0)", {1, 3, 10, 30, 100, 300, 1e9}},
      {Load::kEdges, "edges shortened to", "% of their length", {100, 50, 20, 10, 5, 2, 1}},
      {Load::kSqueeze, "squeezed to", "% of its height", {80, 60, 50, 40, 30, 20, 15, 10, 5}},
      {Load::kTwist, "twisted by", "degrees", {90, 135, 180, 270, 360, 450, 540, 630, 720}},
      {Load::kStrike, "struck at", "m/s", {1, 2, 3, 5, 10, 20, 30}},
      {Load::kOverlap,
       "planes overlap it at rest",
       "% of its height",
       {5, 10, 15, 20, 25, 30, 35, 40, 45}}};
  return kAll;
}

MapBody map_body(const std::filesystem::path& file) {
  const ModelDef def = define_model(read_scene(file));
  if (def.muscles.empty()) throw Error(ErrorCode::kUsage, file.string() + ": has no muscle to map");
  const MuscleDef& first = def.muscles[0];
  MapBody body{first.mesh, {}, first.material, {}};
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
  body.solid = filled(body);
  return body;
}

MapBody loaded_body(const MapBody& body, Load load, double value) {
  if (load != Load::kEdges || value >= 100.0) return body;
  constexpr double kLeast = 0.005;  // the same edges for all values
  MapBody out = body;
  const Stars stars = stars_of(body);
  std::set<int> near;  // nodes that share a triangle or tetrahedron with one that has gone
  for (const Triangle& t : body.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int i = t[k], j = t[(k + 1) % 3];
      const Vec3 &from = body.mesh.vertices[i], &to = body.mesh.vertices[j];
      if (near.count(i) > 0 || !may_go(body, stars, i, to + kLeast * (from - to))) continue;
      out.mesh.vertices[i] = to + 0.01 * value * (from - to);
      if (!out.solid.vertices.empty()) out.solid.vertices[i] = out.mesh.vertices[i];
      for (const Triangle& around : stars.triangles[i]) near.insert(around.begin(), around.end());
      if (stars.tetrahedra.empty()) continue;
      for (const Tetrahedron& around : stars.tetrahedra[i]) {
        near.insert(around.begin(), around.end());
      }
    }
  }
  return out;
}

double LoadWay::at(double time) const {
  if (time <= times.front()) return values.front();
  for (size_t k = 1; k < times.size(); ++k) {
    if (time > times[k]) continue;
    const double part = (time - times[k - 1]) / (times[k] - times[k - 1]);
    return values[k - 1] + part * (values[k] - values[k - 1]);
  }
  return values.back();
}

LoadWay load_way(const MapBody& body, Load load, double value) {
  const double height = body.size.y();
  const bool twists = load == Load::kTwist;
  double before = 0.0, most = 0.2 * height, begin = 0.0;  // each plane's way to 60 %
  if (load == Load::kSqueeze) most = 0.5 * height * (1.0 - 0.01 * value);
  if (load == Load::kStrike) begin = std::max(kPhase - most / value, 1e-3);
  if (load == Load::kOverlap) before = most = 0.5 * height * 0.01 * value;
  if (twists) most = value * kDegree;
  LoadWay way;
  const auto key = [&](double time, double x) {
    way.times.push_back(time);
    way.values.push_back(x);
  };
  key(0.0, before);
  if (begin > 0.0) key(begin, before);
  key(kPhase, most);
  key(2.0 * kPhase, most);
  key(3.0 * kPhase, twists ? 0.0 : std::min(before, 0.0) - 0.02 * height);
  return way;
}

std::vector<char> held_nodes(const MapBody& body, const std::vector<Vec3>& nodes) {
  const double end = 0.45 * body.size.x();
  std::vector<char> held;
  for (const Vec3& p : nodes) held.push_back(p.x() <= -end ? 1 : p.x() >= end ? 2 : 0);
  return held;
}

Model map_model(const MapBody& body, Load load, double value) {
  const bool twists = load == Load::kTwist;
  ModelDef def;
  def.name = "maps";
  def.fps = 1000.0;
  def.last_frame = 3000;
  def.settle = 0.0;
  def.gravity = Vec3::Zero();
  def.skeleton = rig_of(body);
  def.clip.interpolation = Clip::Interpolation::kLinear;
  def.clip.joints =
      twists ? std::vector<std::string>{"right"} : std::vector<std::string>{"top", "bottom"};
  const LoadWay way = load_way(body, load, value);
  def.clip.times = way.times;
  for (const double x : way.values) def.clip.values.emplace_back(def.clip.joints.size(), x);
  MuscleDef& muscle = def.muscles.emplace_back();
  muscle.name = "body";
  muscle.mesh = body.mesh;
  muscle.guide = 0.0;
  muscle.damping = kMapDrag;
  muscle.material = body.material;
  muscle.material.anisotropy = 1.0;
  muscle.material.shape = 0.0;
  if (load == Load::kStiffness) muscle.material.stiffness *= value;
  if (load == Load::kWeights) muscle.weights = weights_at_top(body, value);
  if (twists) {
    for (const char hand : held_nodes(body, body.mesh.vertices)) {
      muscle.fixed_to.push_back(hand == 1 ? kLeft : hand == 2 ? kRight : -1);
    }
  }
  def.bones = {plane_of(body, "top", kTop), plane_of(body, "bottom", kBottom)};
  def.contact.enabled = !twists;
  def.contact.settings.margin = def.contact.settings.max_depth = 0.25 * body.size.y();
  def.contact.settings.gap = 0.0;
  return build_model(def);
}

}  // namespace thew::tools
