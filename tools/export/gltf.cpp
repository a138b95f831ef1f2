// SPDX-License-Identifier: Apache-2.0
//
// glTF 2.0, binary. A mesh is its base shape and morph targets, each a displacement of all
// vertices; the animation gives the targets' weights by time. Exact: the base is the rest pose, and
// at frame f target f has weight 1 and all others 0.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/cache/version.h"
#include "tools/base/output_file.h"
#include "tools/base/printing.h"
#include "tools/export/basis.h"
#include "tools/export/formats.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;
using Frames = std::vector<const std::vector<Vec3>*>;

constexpr std::uint64_t kMostBytes = 0xffffffffu;  // lengths in the file are 32 bits wide
enum ComponentType { kUint32 = 5125, kFloat = 5126 };
enum BufferTarget { kNone = 0, kVertices = 34962, kIndices = 34963 };

/// The document and the numbers it points to.
struct Glb {
  ordered_json json;
  std::string bytes;
};

// The last `count` elements of the numbers as an accessor in a view of its own; its number.
std::size_t add_accessor(Glb& glb, std::size_t begin, std::size_t count, const char* type,
                         ComponentType component, BufferTarget target) {
  ordered_json view = {
      {"buffer", 0}, {"byteOffset", begin}, {"byteLength", glb.bytes.size() - begin}};
  if (target != kNone) view["target"] = target;
  glb.json["bufferViews"].push_back(view);
  glb.json["accessors"].push_back({{"bufferView", glb.json["bufferViews"].size() - 1},
                                   {"componentType", component},
                                   {"count", count},
                                   {"type", type}});
  return glb.json["accessors"].size() - 1;
}

std::size_t add_vectors(Glb& glb, const std::vector<Vec3>& values, bool with_bounds) {
  const std::size_t begin = glb.bytes.size();
  Vec3 low = values.front(), high = low;
  for (const Vec3& value : values) {
    put_floats(glb.bytes, value);
    low = low.cwiseMin(value);
    high = high.cwiseMax(value);
  }
  const std::size_t accessor = add_accessor(glb, begin, values.size(), "VEC3", kFloat, kVertices);
  if (with_bounds) {
    // Rounded as the numbers are.
    for (const auto& [name, bound] : {std::pair("min", low), std::pair("max", high)}) {
      for (int axis = 0; axis < 3; ++axis) {
        glb.json["accessors"][accessor][name].push_back(static_cast<float>(bound[axis]));
      }
    }
  }
  return accessor;
}

std::size_t add_scalars(Glb& glb, const std::vector<float>& values) {
  const std::size_t begin = glb.bytes.size();
  for (const float value : values) put(glb.bytes, value);
  const std::size_t accessor = add_accessor(glb, begin, values.size(), "SCALAR", kFloat, kNone);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  glb.json["accessors"][accessor]["min"] = ordered_json::array({*low});
  glb.json["accessors"][accessor]["max"] = ordered_json::array({*high});
  return accessor;
}

std::size_t add_triangles(Glb& glb, const std::vector<Triangle>& triangles) {
  const std::size_t begin = glb.bytes.size();
  for (const Triangle& triangle : triangles) {
    for (const int vertex : triangle) put(glb.bytes, static_cast<std::uint32_t>(vertex));
  }
  return add_accessor(glb, begin, 3 * triangles.size(), "SCALAR", kUint32, kIndices);
}

/// One mesh as base and targets.
struct Morphs {
  std::vector<Vec3> base, base_normals;
  std::vector<std::vector<Vec3>> targets, target_normals;
  std::vector<std::string> names;
  std::vector<std::vector<float>> weights;  // by frame, target
};

std::vector<Vec3> minus(std::vector<Vec3> a, const std::vector<Vec3>& b) {
  for (std::size_t v = 0; v < a.size(); ++v) a[v] -= b[v];
  return a;
}

// As the file will hold them: displacements are from the rounded base, so that a sum is rounded
// once. By way of the bytes, since GCC 12 vectorises a cast to float and back into nothing.
std::vector<Vec3> rounded(const std::vector<Vec3>& values) {
  std::string bytes;
  for (const Vec3& value : values) put_floats(bytes, value);
  std::vector<Eigen::Vector3f> floats(values.size());
  std::memcpy(static_cast<void*>(floats.data()), bytes.data(), bytes.size());
  std::vector<Vec3> result;
  for (const Eigen::Vector3f& value : floats) result.push_back(value.cast<double>());
  return result;
}

Morphs exact_morphs(const Shot& shot, const BakeMesh& mesh, const Frames& frames) {
  Morphs morphs;
  morphs.base = rounded(mesh.rest.vertices);
  morphs.base_normals = unit_normals(mesh, morphs.base);
  for (std::size_t f = 0; f < frames.size(); ++f) {
    morphs.targets.push_back(minus(*frames[f], morphs.base));
    morphs.target_normals.push_back(minus(unit_normals(mesh, *frames[f]), morphs.base_normals));
    morphs.names.push_back("frame " + std::to_string(shot.frame(f)));
    morphs.weights.emplace_back(frames.size(), 0.0f)[f] = 1.0f;
  }
  return morphs;
}

// Normals are fitted to the weights of the positions, about the mean direction: a base has to have
// normals of length 1.
Morphs basis_morphs(const BakeMesh& mesh, const Frames& frames, int count) {
  const MotionBasis basis = fit_motion_basis(frames, count);
  Morphs morphs;
  morphs.weights = basis.weights;
  morphs.base = rounded(combine(basis.base_factors, frames));
  std::vector<std::vector<Vec3>> normals;
  Frames normal_frames;
  for (const auto* frame : frames) normals.push_back(unit_normals(mesh, *frame));
  for (auto& frame : normals) normal_frames.push_back(&frame);
  morphs.base_normals = combine(std::vector<double>(frames.size(), 1.0), normal_frames);
  for (Vec3& n : morphs.base_normals) n = n.norm() > 0.0 ? n.normalized() : Vec3::UnitY();
  for (auto& frame : normals) frame = minus(std::move(frame), morphs.base_normals);
  const auto normal_factors = least_squares_factors(basis.weights);
  for (std::size_t k = 0; k < basis.factors.size(); ++k) {
    morphs.targets.push_back(combine(basis.factors[k], frames));
    morphs.target_normals.push_back(combine(normal_factors[k], normal_frames));
    morphs.names.push_back("mode " + std::to_string(k + 1));
  }
  return morphs;
}

/// How far the shapes in the file are from the bake's, as a reader sees them.
struct Deviation {
  double largest = 0.0, squares = 0.0;  // m, m^2
  std::size_t count = 0;
  std::string where;
};

void add_deviation(const Shot& shot, std::size_t m, const Morphs& morphs, const Frames& frames,
                   Deviation& deviation) {
  std::vector<std::vector<Vec3>> targets;
  for (const auto& target : morphs.targets) targets.push_back(rounded(target));
  for (std::size_t f = 0; f < frames.size(); ++f) {
    std::vector<Vec3> shape = morphs.base;
    for (std::size_t k = 0; k < targets.size(); ++k) {
      for (std::size_t v = 0; v < shape.size(); ++v) {
        shape[v] += double{morphs.weights[f][k]} * targets[k][v];
      }
    }
    for (std::size_t v = 0; v < shape.size(); ++v) {
      const double square = (shape[v] - (*frames[f])[v]).squaredNorm();
      deviation.squares += square;
      ++deviation.count;
      if (square <= deviation.largest * deviation.largest) continue;
      deviation.largest = std::sqrt(square);
      deviation.where = shot.mesh(m).name + ", frame " + std::to_string(shot.frame(f)) +
                        ", vertex " + std::to_string(v);
    }
  }
}

ordered_json material(BakeMesh::Kind kind) {
  const ordered_json colour = kind == BakeMesh::Kind::kMuscle ? ordered_json{0.55, 0.12, 0.10, 1}
                              : kind == BakeMesh::Kind::kBone ? ordered_json{0.80, 0.74, 0.62, 1}
                                                              : ordered_json{0.78, 0.52, 0.42, 1};
  return {{"pbrMetallicRoughness",
           {{"baseColorFactor", colour}, {"metallicFactor", 0}, {"roughnessFactor", 0.6}}}};
}

void add_mesh(Glb& glb, const BakeMesh& mesh, const Morphs& morphs, std::size_t times) {
  ordered_json& json = glb.json;
  const std::size_t number = json["meshes"].size();
  ordered_json targets = ordered_json::array();
  for (std::size_t k = 0; k < morphs.targets.size(); ++k) {
    targets.push_back({{"POSITION", add_vectors(glb, morphs.targets[k], true)},
                       {"NORMAL", add_vectors(glb, morphs.target_normals[k], false)}});
  }
  ordered_json primitive = {{"attributes",
                             {{"POSITION", add_vectors(glb, morphs.base, true)},
                              {"NORMAL", add_vectors(glb, morphs.base_normals, false)}}},
                            {"indices", add_triangles(glb, mesh.rest.triangles)},
                            {"material", json["materials"].size()}};
  json["materials"].push_back(material(mesh.kind));
  ordered_json written = {{"name", mesh.name}, {"primitives", ordered_json::array({primitive})}};
  if (!targets.empty()) {
    written["primitives"][0]["targets"] = targets;
    written["weights"] = morphs.weights.front();
    written["extras"] = {{"targetNames", morphs.names}};
    std::vector<float> weights;
    for (const auto& frame : morphs.weights)
      weights.insert(weights.end(), frame.begin(), frame.end());
    const std::size_t output = add_scalars(glb, weights);
    ordered_json& animation = json["animations"][0];
    animation["channels"].push_back({{"sampler", animation["samplers"].size()},
                                     {"target", {{"node", number}, {"path", "weights"}}}});
    animation["samplers"].push_back({{"input", times}, {"output", output}});
  }
  json["meshes"].push_back(written);
  json["nodes"].push_back({{"name", mesh.name}, {"mesh", number}});
  json["scenes"][0]["nodes"].push_back(number);
}

ordered_json head(const Shot& shot) {
  ordered_json facts;
  for (const auto& [name, value] : facts_of(shot)) facts[name] = value;
  ordered_json json = {
      {"asset",
       {{"version", "2.0"}, {"generator", std::string("Thew ") + kVersion}, {"extras", facts}}},
      {"scene", 0}};
  for (const char* list : {"scenes", "nodes", "meshes", "materials"}) {
    json[list] = ordered_json::array();
  }
  json["animations"].push_back(
      {{"channels", ordered_json::array()}, {"samplers", ordered_json::array()}});
  json["scenes"].push_back({{"name", one_line(shot.info().scene_name)}});
  for (const char* list : {"bufferViews", "accessors"}) json[list] = ordered_json::array();
  return json;
}

void write(const std::filesystem::path& file, Glb& glb) {
  if (glb.json["animations"][0]["channels"].empty()) glb.json.erase("animations");
  glb.json["buffers"].push_back({{"byteLength", glb.bytes.size()}});
  std::string json = json_text(glb.json, -1);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::uint64_t length = 12 + 8 + json.size() + 8 + glb.bytes.size();
  if (length > kMostBytes) {
    throw Error(ErrorCode::kOutput,
                file.string() + ": glTF binary holds 4 GiB and this would be " +
                    std::to_string(length >> 30) +
                    "; choose fewer --frames or --mesh, or a --basis of some targets");
  }
  std::string bytes = "glTF";
  put<std::uint32_t>(bytes, 2);
  put(bytes, static_cast<std::uint32_t>(length));
  put(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  put(bytes, static_cast<std::uint32_t>(glb.bytes.size()));
  bytes += std::string("BIN\0", 4);
  ExportFile out(file);
  out.append(bytes);
  out.append(glb.bytes);
  out.finish();
}

std::string in_mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

}  // namespace

Exported export_glb(const Shot& shot, const std::filesystem::path& file, int basis) {
  const std::vector<ShotFrame> shapes = all_frames(shot);
  Glb glb{head(shot), ""};
  std::vector<float> seconds;
  for (std::size_t f = 0; f < shapes.size(); ++f) {
    seconds.push_back(static_cast<float>((shot.frame(f) - shot.first_frame()) / shot.info().fps));
  }
  const std::size_t times = add_scalars(glb, seconds);
  Deviation deviation;
  std::size_t targets = 0;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    Frames frames;
    for (const ShotFrame& shape : shapes) frames.push_back(&shape.positions[m]);
    const Morphs morphs = basis > 0 ? basis_morphs(shot.mesh(m), frames, basis)
                                    : exact_morphs(shot, shot.mesh(m), frames);
    targets = std::max(targets, morphs.targets.size());
    if (basis > 0) add_deviation(shot, m, morphs, frames, deviation);
    add_mesh(glb, shot.mesh(m), morphs, times);
  }
  write(file, glb);
  std::string note = "time 0 is the first frame; ";
  if (basis == 0) return {{file}, note + "a morph target a frame, normals too"};
  note += std::to_string(targets) +
          " morph targets a mesh at most, normals fitted; position error " +
          in_mm(deviation.largest) + " at most (" + deviation.where + "), " +
          in_mm(std::sqrt(deviation.squares / static_cast<double>(deviation.count))) + " RMS";
  return {{file}, note};
}

}  // namespace thew::tools
