// SPDX-License-Identifier: Apache-2.0
#include "tools/export/usd/usd_scene.h"

#include <algorithm>
#include <memory>
#include <set>

#include "tools/base/bake_mesh.h"
#include "tools/export/character_skin.h"
#include "tools/export/looks.h"
#include "tools/export/motion.h"

namespace thew::tools {
namespace {

// A prim's name is an identifier, and no two prims of a scope have the same.
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

void add_topology(const BakeMesh& mesh, UsdPrim& prim) {
  std::vector<std::int32_t> indices;
  for (const Triangle& triangle : mesh.rest.triangles) {
    indices.insert(indices.end(), triangle.begin(), triangle.end());
  }
  const std::vector<std::int32_t> counts(mesh.rest.triangles.size(), 3);
  prim.attributes.push_back({"faceVertexCounts", UsdType::kInts, counts});
  prim.attributes.push_back({"faceVertexIndices", UsdType::kInts, indices});
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

// What moves as one piece has a transform, all else its points and normals by frame.
void add_motion(const Shot& shot, std::size_t m, const RigidMotion& rigid, UsdPrim& prim) {
  const BakeMesh& mesh = shot.mesh(m);
  const std::vector<Vec3>& rest = mesh.rest.vertices;
  UsdAttribute around{"extent", UsdType::kFloat3s, extent(rest)};
  UsdAttribute points{"points", UsdType::kPoints, floats(rest)};
  UsdAttribute normals{.name = "normals",
                       .type = UsdType::kNormals,
                       .value = floats(unit_normals(shot, m, rest)),
                       .interpolation = "vertex"};
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

// The triangles of each material, to which a layer over this one may bind one.
void add_parts(const SkinLooks& looks, UsdPrim& prim) {
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
        {"indices", UsdType::kInts, part.triangles}};
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

UsdPrim describe_mesh(const Shot& shot, std::size_t m, const RigidMotion& rigid,
                      std::set<std::string>& taken) {
  const BakeMesh& mesh = shot.mesh(m);
  UsdPrim prim{prim_name(mesh.name, taken), "Mesh"};
  prim.full_name = one_line(mesh.name);
  add_motion(shot, m, rigid, prim);
  add_topology(mesh, prim);
  add_primvars(shot, m, prim);
  add_metrics(shot, mesh, prim);
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

}  // namespace

const UsdTypeFacts& facts_of(UsdType type) {
  static constexpr UsdTypeFacts kFacts[] = {
      {"int[]", 1, true, 3},         {"float[]", 1, true, 8},     {"double", 1, false, 9},
      {"token", 1, false, 11},       {"token[]", 1, true, 11},    {"float3[]", 3, true, 24},
      {"point3f[]", 3, true, 24},    {"normal3f[]", 3, true, 24}, {"color3f[]", 3, true, 24},
      {"texCoord2f[]", 2, true, 20}, {"matrix4d", 16, false, 15}};
  return kFacts[static_cast<std::size_t>(type)];
}

UsdLayer describe_usd(const Shot& shot) {
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
  return layer;
}

void keep_values(const Shot& shot, UsdPrim& root,
                 const std::function<std::uint64_t(const UsdAttribute&, const UsdData&)>& keep) {
  for_each_attribute(root, [&](UsdAttribute& attribute) {
    if (attribute.value) attribute.kept = keep(attribute, *attribute.value);
  });
  std::size_t i = 0;
  for_each_frame(shot, [&](const ShotFrame& frame) {
    for_each_attribute(root, [&](UsdAttribute& attribute) {
      if (!attribute.at) return;
      const std::uint64_t kept = keep(attribute, attribute.at(i, frame));
      if (i == 0 && !attribute.value) attribute.kept = kept;
      add_sample(attribute.samples, {frame.frame, kept});
    });
    ++i;
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
