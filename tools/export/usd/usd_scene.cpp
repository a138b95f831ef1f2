// SPDX-License-Identifier: Apache-2.0
#include "tools/export/usd/usd_scene.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <set>

#include "rig/math.h"
#include "tools/base/bake_mesh.h"
#include "tools/export/character_skin.h"
#include "tools/export/fields.h"
#include "tools/export/looks.h"
#include "tools/export/motion.h"

namespace thew::tools {
namespace {

UsdData floats(const std::vector<Vec3>& values) {
  std::vector<float> result;
  result.reserve(3 * values.size());
  for (const Vec3& value : values) {
    for (const double x : value) result.push_back(static_cast<float>(x));
  }
  return result;
}

// It holds the points as they are written.
UsdData extent(const std::vector<Vec3>& positions) {
  Vec3 low = positions.front(), high = low;
  for (const Vec3& p : positions) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  return floats({low, high});
}

void add_topology(Faces faces, UsdPrim& prim) {
  prim.attributes.push_back({"faceVertexCounts", UsdType::kInts, std::move(faces.counts)});
  prim.attributes.push_back({"faceVertexIndices", UsdType::kInts, std::move(faces.corners)});
  prim.attributes.push_back(
      {.name = "orientation", .type = UsdType::kToken, .value = "rightHanded", .uniform = true});
  prim.attributes.push_back(
      {.name = "subdivisionScheme", .type = UsdType::kToken, .value = "none", .uniform = true});
}

void add_primvars(const Shot& shot, std::size_t m, UsdPrim& prim) {
  const BakeMesh& mesh = shot.mesh(m);
  const auto colour = kind_colour(mesh.kind);
  prim.attributes.push_back({.name = "primvars:displayColor",
                             .type = UsdType::kColours,
                             .value = std::vector<float>(colour.begin(), colour.end()),
                             .interpolation = "constant"});
  const Uvs uvs = uvs_of(shot, m);
  if (!uvs.values.empty()) {
    std::vector<float> values;
    for (const auto& uv : uvs.values) values.insert(values.end(), uv.begin(), uv.end());
    prim.attributes.push_back({.name = "primvars:st",
                               .type = UsdType::kUvs,
                               .value = values,
                               .interpolation = "faceVarying"});
    prim.attributes.push_back({"primvars:st:indices", UsdType::kInts, uvs.corners});
  }
  if (!mesh.weights.empty()) {
    prim.attributes.push_back(
        {.name = "primvars:thew:weight",
         .type = UsdType::kFloats,
         .value = std::vector<float>(mesh.weights.begin(), mesh.weights.end()),
         .interpolation = "vertex"});
  }
}

// A reader draws the line between two samples. Normals follow from the points, and are half of the
// file; a degree of them is not seen.
constexpr double kNormalsBetween = kDegree;

// What moves as one piece has a transform, all else its points and normals by frame.
void add_motion(const Shot& shot, std::size_t m, const RigidMotion& rigid, UsdPrim& prim) {
  const BakeMesh& mesh = shot.mesh(m);
  const std::vector<Vec3>& rest = mesh.rest.vertices;
  UsdAttribute around{"extent", UsdType::kFloat3s, extent(rest)};
  UsdAttribute points{"points", UsdType::kPoints, floats(rest)};
  UsdAttribute normals{.name = "normals",
                       .type = UsdType::kNormals,
                       .value = floats(unit_normals(shot, m, rest)),
                       .interpolation = "vertex",
                       .between = kNormalsBetween};
  if (rigid.empty()) {
    around.at = [m](auto, const ShotFrame& frame) { return extent(frame.positions[m]); };
    points.at = [m](auto, const ShotFrame& frame) { return floats(frame.positions[m]); };
    normals.at = [m, &shot](auto, const ShotFrame& frame) {
      return floats(unit_normals(shot, m, frame.positions[m]));
    };
  }
  for (UsdAttribute* attribute : {&around, &points, &normals}) {
    prim.attributes.push_back(std::move(*attribute));
  }
  if (rigid.empty()) return;
  prim.attributes.push_back(
      {.name = "xformOp:transform",
       .type = UsdType::kMatrix,
       .value = Eigen::Matrix4d(Eigen::Matrix4d::Identity()),
       .at = [rigid](std::size_t i, auto&) { return UsdData(rigid[i].matrix()); }});
  prim.attributes.push_back({.name = "xformOpOrder",
                             .type = UsdType::kTokens,
                             .value = std::vector<std::string>{"xformOp:transform"},
                             .uniform = true});
}

// The faces of each material.
void add_parts(const SkinLooks& looks, UsdPrim& prim) {
  bind_look(looks, looks.look, prim);
  if (looks.parts.empty()) return;
  prim.attributes.push_back({.name = "subsetFamily:materialBind:familyType",
                             .type = UsdType::kToken,
                             .value = "partition",
                             .uniform = true});
  std::set<std::string> taken;
  for (const SkinLooks::Part& part : looks.parts) {
    UsdPrim subset{prim_name(part.material, taken), "GeomSubset"};
    subset.full_name = one_line(part.material);
    subset.attributes = {
        {.name = "elementType", .type = UsdType::kToken, .value = "face", .uniform = true},
        {.name = "familyName", .type = UsdType::kToken, .value = "materialBind", .uniform = true},
        {"indices", UsdType::kInts, part.faces}};
    bind_look(looks, part.look, subset);
    prim.children.push_back(std::move(subset));
  }
}

void add_metrics(const Shot& shot, const BakeMesh& mesh, UsdPrim& prim) {
  for (const auto& [name, values] : metrics_of(shot, mesh)) {
    prim.attributes.push_back(
        {.name = "thew:" + name,
         .type = UsdType::kDouble,
         .at = [values = values](
                   auto, const ShotFrame& frame) { return UsdData((*values)[frame.place]); },
         .custom = true});
  }
}

void add_line(const BakeMesh& mesh, std::size_t m, const RigidMotion& rigid, UsdPrim& prim) {
  if (mesh.line == 0) return;
  prim.attributes.push_back({.name = "thew:line",
                             .type = UsdType::kPoints,
                             .at =
                                 [m, rigid](std::size_t i, const ShotFrame& frame) {
                                   return floats(line_of_action(frame, m, i, rigid));
                                 },
                             .custom = true});
}

void add_fields(const BakeMesh& mesh, std::size_t m, const RigidMotion& rigid, UsdPrim& prim) {
  if (mesh.line > 0 && !mesh.coordinates.empty()) {
    prim.attributes.push_back(
        {.name = "primvars:thew:fibre",
         .type = UsdType::kVectors,
         .at =
             [m, rigid, &mesh](std::size_t i, const ShotFrame& frame) {
               return floats(fibre_directions(mesh, line_of_action(frame, m, i, rigid)));
             },
         .interpolation = "vertex"});
  }
  if (mesh.kind != BakeMesh::Kind::kSkin) return;
  prim.attributes.push_back(
      {.name = "primvars:thew:stretch",
       .type = UsdType::kFloat2s,
       .at =
           [m, &mesh, first = first_at_position(mesh.rest)](auto, const ShotFrame& frame) {
             std::vector<float> values;
             for (const auto& of : principal_stretches(mesh.rest, first, frame.positions[m])) {
               values.insert(values.end(), of.begin(), of.end());
             }
             return UsdData(values);
           },
       .interpolation = "vertex"});
}

UsdPrim describe_mesh(const Shot& shot, std::size_t m, const RigidMotion& rigid,
                      std::set<std::string>& taken) {
  const BakeMesh& mesh = shot.mesh(m);
  UsdPrim prim{prim_name(mesh.name, taken), "Mesh"};
  prim.full_name = one_line(mesh.name);
  add_motion(shot, m, rigid, prim);
  add_topology(faces_of(shot, m), prim);
  add_primvars(shot, m, prim);
  add_metrics(shot, mesh, prim);
  add_line(mesh, m, rigid, prim);
  if (shot.fields) add_fields(mesh, m, rigid, prim);
  if (shot.meshes[m] == skin_mesh(shot.info())) add_parts(shot.looks, prim);
  return prim;
}

template <typename Work>
void for_each_attribute(UsdPrim& prim, const Work& work) {
  for (UsdAttribute& attribute : prim.attributes) work(attribute);
  for (UsdPrim& child : prim.children) for_each_attribute(child, work);
}

void add_sample(std::vector<UsdSample>& samples, const UsdSample& sample) {
  const std::size_t n = samples.size();
  if (n > 1 && samples[n - 1].value == sample.value && samples[n - 2].value == sample.value) {
    samples.back() = sample;
  } else {
    samples.push_back(sample);
  }
}

// A value of an attribute that may need no sample, since those around it say it.
struct Waiting {
  int frame;
  UsdData value;
};

// Whether `value` lies on the line from `from` to `to` within an angle, each direction of it.
bool is_between(const Waiting& from, const Waiting& value, const Waiting& to, double angle) {
  const auto& a = std::get<std::vector<float>>(from.value);
  const auto& b = std::get<std::vector<float>>(to.value);
  const auto& v = std::get<std::vector<float>>(value.value);
  const double t = double(value.frame - from.frame) / (to.frame - from.frame);
  const double least = std::cos(angle);
  for (std::size_t i = 0; i + 2 < v.size(); i += 3) {
    const auto at = [i](const std::vector<float>& x) { return Vec3(x[i], x[i + 1], x[i + 2]); };
    const Vec3 line = (1 - t) * at(a) + t * at(b);
    if (line.dot(at(v)) < least * line.norm() * at(v).norm()) return false;
  }
  return true;
}

// The last sample and the frames after it, as long as the line to the last of them says all others.
// More than 8 are not kept in memory.
void wait(std::vector<Waiting>& waiting, Waiting next, double angle,
          const std::function<void(const Waiting&)>& add) {
  if (waiting.empty()) add(next);
  bool fits = waiting.size() <= 8;
  for (std::size_t i = 1; fits && i < waiting.size(); ++i) {
    fits = is_between(waiting.front(), waiting[i], next, angle);
  }
  if (!fits) {
    add(waiting.back());
    waiting.erase(waiting.begin(), waiting.end() - 1);
  }
  waiting.push_back(std::move(next));
}

}  // namespace

std::string prim_name(const std::string& name, std::set<std::string>& taken) {
  std::string result;
  for (const char c : name) {
    const bool digit = c >= '0' && c <= '9';
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    if (digit && result.empty()) result = "_";
    result += digit || letter ? c : '_';
  }
  if (result.empty()) result = "_";
  while (!taken.insert(result).second) result += "_";
  return result;
}

const UsdTypeFacts& facts_of(UsdType type) {
  static constexpr UsdTypeFacts kFacts[] = {
      {"int[]", 1, true, 3},      {"float[]", 1, true, 8},       {"double", 1, false, 9},
      {"float", 1, false, 8},     {"float2", 2, false, 20},      {"float3", 3, false, 24},
      {"float4", 4, false, 28},   {"color3f", 3, false, 24},     {"string", 1, false, 10},
      {"asset", 1, false, 12},    {"token", 1, false, 11},       {"token[]", 1, true, 11},
      {"float3[]", 3, true, 24},  {"point3f[]", 3, true, 24},    {"normal3f[]", 3, true, 24},
      {"color3f[]", 3, true, 24}, {"texCoord2f[]", 2, true, 20}, {"vector3f[]", 3, true, 24},
      {"float2[]", 2, true, 20},  {"matrix4d", 16, false, 15}};
  return kFacts[static_cast<std::size_t>(type)];
}

UsdLayer describe_usd(const Shot& shot, const std::string& images) {
  const std::vector<RigidMotion> rigid = rigid_motions(shot);
  UsdLayer layer{shot.info().fps,
                 static_cast<double>(shot.first_frame()),
                 static_cast<double>(shot.frame(shot.places.size() - 1)),
                 facts_of(shot),
                 {"Bake", "Xform", "component"}};
  constexpr std::pair<BakeMesh::Kind, const char*> kScopes[] = {
      {BakeMesh::Kind::kBone, "Bones"},
      {BakeMesh::Kind::kMuscle, "Muscles"},
      {BakeMesh::Kind::kSkin, "Skin"},
      {BakeMesh::Kind::kProp, "Props"}};
  for (const auto& [kind, name] : kScopes) {
    UsdPrim scope{name, "Scope"};
    std::set<std::string> taken;
    for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
      if (shot.mesh(m).kind != kind) continue;
      scope.children.push_back(describe_mesh(shot, m, rigid[m], taken));
    }
    if (!scope.children.empty()) layer.root.children.push_back(std::move(scope));
  }
  UsdPrim looks = describe_looks(shot.looks, images);
  if (!looks.children.empty()) layer.root.children.push_back(std::move(looks));
  return layer;
}

void keep_values(const Shot& shot, UsdPrim& root,
                 const std::function<std::uint64_t(const UsdAttribute&, const UsdData&)>& keep) {
  for_each_attribute(root, [&](UsdAttribute& attribute) {
    if (attribute.value) attribute.kept = keep(attribute, *attribute.value);
  });
  const auto add = [&keep](UsdAttribute& attribute, int frame, const UsdData& value) {
    const std::uint64_t kept = keep(attribute, value);
    if (attribute.samples.empty() && !attribute.value) attribute.kept = kept;
    add_sample(attribute.samples, {frame, kept});
  };
  std::map<UsdAttribute*, std::vector<Waiting>> waiting;
  std::size_t i = 0;
  for_each_frame(shot, [&](const ShotFrame& frame) {
    for_each_attribute(root, [&](UsdAttribute& attribute) {
      if (!attribute.at) return;
      UsdData value = attribute.at(i, frame);
      if (attribute.between == 0) return add(attribute, frame.frame, value);
      wait(waiting[&attribute], {frame.frame, std::move(value)}, attribute.between,
           [&](const Waiting& it) { add(attribute, it.frame, it.value); });
    });
    ++i;
  });
  for_each_attribute(root, [&](UsdAttribute& attribute) {
    const auto& of = waiting[&attribute];
    if (of.size() > 1) add(attribute, of.back().frame, of.back().value);
  });
  for_each_attribute(root, [&](UsdAttribute& attribute) {
    std::vector<UsdSample>& samples = attribute.samples;
    if (samples.empty() || samples.front().value != samples.back().value || samples.size() > 2) {
      return;
    }
    attribute.kept = samples.front().value;
    samples.clear();
  });
}

}  // namespace thew::tools
