// SPDX-License-Identifier: Apache-2.0
// A definition by arrays and names as one by types and indices.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "rig/api/arrays.h"
#include "rig/limits.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/api/scene_data.h"
#include "sim/maps/node_map.h"
#include "sim/scene/model_def.h"

namespace thew::sim {
namespace {

[[noreturn]] void refuse(const std::string& what) { throw Error(ErrorCode::kUsage, what); }

std::string quoted(const char* kind, const std::string& name) {
  return std::string(kind) + " \"" + name + "\"";
}

Vec3 to_vec3(const Vector3& v, const std::string& what) {
  Vec3 p(v[0], v[1], v[2]);
  if (!p.allFinite()) refuse(what + " is not finite; give three numbers");
  return p;
}

Vec3 to_direction(const Vector3& v, const std::string& what) {
  const Vec3 d = to_vec3(v, what);
  if (!(d.norm() > 0.0)) refuse(what + " is zero; give a direction");
  return d.normalized();
}

int body_named(const Skeleton& skeleton, const std::string& name, const std::string& what) {
  const int body = find_body(skeleton, name);
  if (body < 0) {
    refuse(what + ": there is no body \"" + name + "\"" + did_you_mean(name, skeleton.body_names));
  }
  return body;
}

Skeleton define_skeleton(const std::vector<Body>& bodies) {
  if (bodies.empty()) refuse("there is no body; give one at least");
  Skeleton skeleton;
  for (const Body& body : bodies) {
    const std::string what = quoted("body", body.name);
    const Joint& joint = body.joint;
    const bool is_root = body.parent.empty(), moves = joint.kind != Joint::Kind::kFixed;
    if (is_root != skeleton.body_names.empty()) {
      refuse(what + ": the first body, and no other, has no parent");
    }
    if (body.name.empty() || find_body(skeleton, body.name) >= 0) {
      refuse(what + ": its name is empty or taken; give it another");
    }
    if (is_root && (moves || joint.position != Vector3{})) {
      refuse(what + ": the root is fixed at the origin; give it no joint");
    }
    if (moves && (joint.name.empty() || find_joint(skeleton, joint.name) >= 0)) {
      refuse(what + ": its joint's name is empty or taken; give it another");
    }
    if (!(joint.lower <= 0.0 && joint.upper >= 0.0)) {
      refuse(what + ": its joint's range leaves out 0, the rest pose; widen it");
    }
    skeleton.parent.push_back(is_root ? -1 : body_named(skeleton, body.parent, what));
    skeleton.body_names.push_back(body.name);
    skeleton.joint_in_parent.push_back(
        Transform(Eigen::Translation3d(to_vec3(joint.position, what + ": its joint's position"))));
    skeleton.joint_names.push_back(is_root ? "" : moves ? joint.name : body.name);
    skeleton.joint_types.push_back(joint.kind == Joint::Kind::kHinge
                                       ? Skeleton::JointType::kRevolute
                                   : moves ? Skeleton::JointType::kPrismatic
                                           : Skeleton::JointType::kFixed);
    skeleton.joint_axes.push_back(to_direction(joint.axis, what + ": its joint's axis"));
    skeleton.lower.push_back(joint.lower);
    skeleton.upper.push_back(joint.upper);
    skeleton.visuals.emplace_back();
  }
  return skeleton;
}

rig::Clip define_clip(const SceneDefinition& scene) {
  const thew::Clip& given = scene.clip;
  const size_t joints = given.joints.size();
  if (given.values.size() != joints * given.frames.size()) {
    refuse("the clip has " + std::to_string(given.values.size()) + " values for " +
           std::to_string(joints) + " joints in " + std::to_string(given.frames.size()) +
           " frames; give one for each");
  }
  rig::Clip clip;
  clip.joints = given.joints;
  for (size_t key = 0; key < given.frames.size(); ++key) {
    if (!std::isfinite(given.frames[key]) ||
        (key > 0 && given.frames[key] <= given.frames[key - 1])) {
      refuse("the clip's frames do not rise; give each once, in their order");
    }
    clip.times.push_back((given.frames[key] - scene.first_frame) / scene.fps);
    const auto first = given.values.begin() + static_cast<std::ptrdiff_t>(key * joints);
    clip.values.emplace_back(first, first + static_cast<std::ptrdiff_t>(joints));
  }
  return clip;
}

TriMesh closed_mesh(const TriMesh& mesh, const std::string& what, Pieces pieces = Pieces::kOne) {
  std::string message;
  for (const Defect& defect : find_defects(mesh)) {
    if (pieces == Pieces::kAny && defect.kind == Defect::kSeveralComponents) continue;
    message += std::string("\n  ") + defect_name(defect.kind) + ": " +
               std::to_string(defect.count) + ", first " + defect.where + "; " + defect.fix;
  }
  if (!message.empty()) refuse(what + ": its mesh is not a sound closed surface" + message);
  return mesh;
}

TriMesh closed_mesh(const Mesh& mesh, const std::string& what, Pieces pieces = Pieces::kOne) {
  return closed_mesh(to_tri_mesh(mesh.positions, mesh.triangles), what, pieces);
}

// A map by name, its values within the bounds; empty where it is not given.
std::vector<double> map_of(const Maps& maps, const std::string& name,
                           const std::array<double, 2>& bounds, const std::string& what) {
  const auto found = maps.find(name);
  if (found == maps.end()) return {};
  for (const double value : found->second) {
    if (value >= bounds[0] && value <= bounds[1]) continue;
    refuse(what + ": its map \"" + name + "\" holds " + number_text(value) + "; give " +
           number_text(bounds[0]) + " to " + number_text(bounds[1]));
  }
  return found->second;
}

void check_map_names(const Maps& maps, const std::vector<std::string>& known,
                     const std::string& what) {
  for (const auto& [name, values] : maps) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    refuse(what + ": there is no map \"" + name + "\"" + did_you_mean(name, known) +
           "; it may have: " + names_text(known));
  }
}

// Of a mesh that was welded: the first vertex of a place counts. Sizes that do not fit stay, for
// the one who builds to tell.
std::vector<double> by_node(const std::vector<double>& given, const WeldResult& welded) {
  if (given.size() != welded.map_back.size()) return given;
  std::vector<double> values(welded.mesh.vertices.size(), 0.0);
  for (size_t i = given.size(); i-- > 0;) values[welded.map_back[i]] = given[i];
  return values;
}

// Joined, and the order in which it was given where that differs; weights likewise.
void define_shape(const thew::Muscle& given, const std::string& what, MuscleDef& muscle) {
  const TriMesh mesh = to_tri_mesh(given.mesh.positions, given.mesh.triangles);
  check_triangles(mesh);
  const WeldResult welded = weld(mesh);
  const size_t nodes = welded.mesh.vertices.size();
  muscle.mesh = closed_mesh(welded.mesh, what);
  muscle.weights = given.weights;
  muscle.stiffness = map_of(given.maps, "stiffness", {1e-12, 1e12}, what);
  if (nodes == mesh.vertices.size()) return;
  muscle.order.node = welded.map_back;
  for (const Triangle& t : mesh.triangles) {
    const int a = welded.map_back[t[0]], b = welded.map_back[t[1]], c = welded.map_back[t[2]];
    if (a != b && b != c && c != a) muscle.order.triangles.push_back(t);
  }
  muscle.weights = by_node(muscle.weights, welded);
  muscle.stiffness = by_node(muscle.stiffness, welded);
}

void check_curve(const std::vector<std::array<double, 2>>& curve, const std::string& wrong) {
  for (size_t i = 0; i < curve.size(); ++i) {
    const auto [at, value] = curve[i];
    if (value >= 0.0 && value <= 1.0 && (i == 0 ? std::isfinite(at) : at > curve[i - 1][0]))
      continue;
    refuse(wrong);
  }
}

void define_by_joint(const thew::Muscle& given, const std::string& what, MuscleDef& muscle) {
  const thew::JointActivation& by = given.by_joint;
  if (by.joint.empty()) return;
  muscle.by_joint.emplace();
  muscle.by_joint->joint = by.joint;
  muscle.by_joint->curve = by.curve;
  muscle.by_joint->speed = by.speed;
  const std::string wrong = " of its activation by joint is not (value, 0 to 1) with rising values";
  check_curve(by.curve, what + ": the curve" + wrong);
  check_curve(by.speed, what + ": the speed" + wrong);
  if (!(by.load >= 0.0 && by.load <= 1e6)) refuse(what + ": its load is not 0 to 1e6 kg");
  if (by.load_body.empty()) return;
  muscle.by_joint->load = muscles::JointActivation::Load{};
  muscle.by_joint->load->mass = by.load;
  muscle.by_joint->load->body = by.load_body;
  muscle.by_joint->load->at = to_vec3(by.load_at, what + ": its load");
}

MuscleDef define_muscle(const Skeleton& skeleton, const thew::Muscle& given) {
  const std::string what = quoted("muscle", given.name);
  if (given.path.size() < 2)
    refuse(what + ": its path has not two points; give origin and insertion");
  MuscleDef muscle;
  muscle.name = given.name;
  define_shape(given, what, muscle);
  for (const thew::PathPoint& point : given.path) {
    muscle.path.points.push_back({body_named(skeleton, point.body, what + ": its path"),
                                  to_vec3(point.position, what + ": a point of its path")});
  }
  for (const Wrap& wrap : given.wraps) {
    const std::string its = what + ": its wrap";
    if (wrap.segment < 0 || wrap.segment + 1 >= static_cast<int>(given.path.size()) ||
        !(wrap.radius > 0.0) || std::fabs(wrap.turn) != 1.0) {
      refuse(its + " has a segment, radius or turn that is none");
    }
    muscle.path.wraps.push_back({wrap.segment, body_named(skeleton, wrap.body, its),
                                 to_vec3(wrap.centre, its + "'s centre"),
                                 to_direction(wrap.axis, its + "'s axis"), wrap.radius, wrap.turn});
  }
  muscle.belly = given.belly;
  muscle.material.stiffness = given.stiffness;
  take_constant(muscle.stiffness, muscle.material.stiffness);
  muscle.f_max = given.f_max;
  muscle.activation = given.activation;
  if (!(given.stiffness > 0.0 && given.f_max >= 0.0) ||
      !std::isfinite(given.stiffness + given.f_max)) {
    refuse(what + ": stiffness has to be above 0 and f_max not below");
  }
  check_curve(given.activation,
              what + ": its activation is not (frame, 0 to 1) with rising frames");
  define_by_joint(given, what, muscle);
  check_map_names(given.maps, {"stiffness", "thickness"}, what);
  return muscle;
}

SolverSettings define_solver(const Solver& given) {
  SolverSettings solver;
  const auto word = std::find(std::begin(kIntegrators), std::end(kIntegrators), given.integrator);
  if (word == std::end(kIntegrators)) {
    refuse("solver: there is no integrator \"" + given.integrator + "\"" +
           did_you_mean(given.integrator, {std::begin(kIntegrators), std::end(kIntegrators)}));
  }
  solver.integrator = static_cast<Integrator>(word - std::begin(kIntegrators));
  solver.substeps = given.substeps;
  solver.iterations = given.iterations;
  if (given.substeps < 1 || given.iterations < 1) {
    refuse("solver: substeps and iterations have to be 1 or more");
  }
  return solver;
}

void check_names(const ModelDef& def) {
  std::set<std::string> names;
  if (!def.skin.mesh.triangles.empty()) names.insert("skin");
  const auto take = [&](const std::string& name, const char* kind) {
    if (!name.empty() && name.find_first_of("/.") == std::string::npos &&
        names.insert(name).second) {
      return;
    }
    refuse(quoted(kind, name) + ": its name is empty, taken, or has a / or . in it");
  };
  for (const MuscleDef& muscle : def.muscles) take(muscle.name, "muscle");
  for (const Bone& bone : def.bones) take(bone.name, "bone");
}

}  // namespace

ModelDef define_model(const SceneDefinition& scene) {
  if (!(scene.fps > 0.0 && scene.size > 0.0 && scene.settle >= 0.0) ||
      !std::isfinite(scene.fps + scene.size + scene.settle) ||
      scene.last_frame < scene.first_frame) {
    refuse(
        "fps and size have to be above 0, settle not below, and the last frame not before the "
        "first");
  }
  ModelDef def;
  def.source = def.name = scene.name;
  def.fps = scene.fps;
  def.first_frame = scene.first_frame;
  def.last_frame = scene.last_frame;
  def.settle = scene.settle;
  def.gravity = to_vec3(scene.gravity, "gravity");
  def.size = scene.size;
  def.skeleton = define_skeleton(scene.bodies);
  def.clip = define_clip(scene);
  def.clip_location = "clip";
  for (const thew::Muscle& muscle : scene.muscles) {
    def.muscles.push_back(define_muscle(def.skeleton, muscle));
    std::vector<double> thickness =
        map_of(muscle.maps, "thickness", {0.0, kMaxCoordinate}, quoted("muscle", muscle.name));
    double everywhere = 0.0;
    if (take_constant(thickness, everywhere)) {
      def.contact.thickness.push_back({muscle.name, everywhere});
    }
    if (thickness.empty()) continue;
    def.contact.thicknesses.push_back(
        {muscle.name,
         by_node(thickness, weld(to_tri_mesh(muscle.mesh.positions, muscle.mesh.triangles)))});
  }
  for (const thew::Bone& bone : scene.bones) {
    const std::string what = quoted("bone", bone.name);
    def.bones.push_back({bone.name, body_named(def.skeleton, bone.body, what),
                         closed_mesh(bone.mesh, what, Pieces::kAny)});
  }
  if (!scene.skin.mesh.triangles.empty()) def.skin.mesh = closed_mesh(scene.skin.mesh, "skin");
  def.skin.location = "skin";
  def.skin.settings = times(def.skin.settings, scene.size);
  def.skin.settings.keeps_volume = scene.skin.keeps_volume;
  check_map_names(scene.skin.maps, {"fat", "slide"}, "skin");
  def.skin.maps.fat = map_of(scene.skin.maps, "fat", {0.0, 0.03}, "skin");
  def.skin.maps.slide = map_of(scene.skin.maps, "slide", {0.0, 1.0}, "skin");
  def.contact.settings = times(def.contact.settings, scene.size);
  def.solver = define_solver(scene.solver);
  check_names(def);
  return def;
}

}  // namespace thew::sim
