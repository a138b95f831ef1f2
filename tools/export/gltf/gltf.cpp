// SPDX-License-Identifier: Apache-2.0
//
// glTF 2.0, binary. A mesh is its rest shape and morph targets, each a displacement of all
// vertices; the animation gives the targets' weights by time. Exact: at frame f target f has weight
// 1 and all others 0. What moves as one rigid piece is a node that moves, and has no targets.
#include "tools/export/gltf/gltf.h"

#include <Eigen/Geometry>
#include <cstdio>

#include "rig/math.h"
#include "sim/cache/version.h"
#include "tools/base/bake_mesh.h"
#include "tools/export/formats.h"
#include "tools/export/gltf/glb.h"
#include "tools/export/gltf/quantized.h"
#include "tools/export/motion.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

// The number of the material of this kind of mesh, which all of them share.
std::size_t material(Glb& glb, BakeMesh::Kind kind) {
  ordered_json& materials = glb.json["materials"];
  const std::string name = kind_name(kind);
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (materials[i]["name"] == name) return i;
  }
  const auto [red, green, blue] = kind_colour(kind);
  materials.push_back({{"name", name},
                       {"pbrMetallicRoughness",
                        {{"baseColorFactor", {red, green, blue, 1}},
                         {"metallicFactor", 0},
                         {"roughnessFactor", 0.6}}}});
  return materials.size() - 1;
}

// Empty where it is not rigid.
RigidMotion rigid_motion(const std::vector<Vec3>& rest, const std::vector<Shape>& frames) {
  RigidMotion motion;
  for (const Shape& frame : frames) {
    const auto fit = rigid_fit(rest, frame.positions);
    if (!fit) return {};
    motion.push_back(*fit);
  }
  return motion;
}

void add_rigid_channels(Glb& glb, std::size_t node, const RigidMotion& motion, std::size_t times) {
  std::vector<float> turns, places;
  Eigen::Quaterniond last = Eigen::Quaterniond::Identity();
  for (const Transform& transform : motion) {
    Eigen::Quaterniond turn(transform.linear());
    if (turn.dot(last) < 0.0) turn.coeffs() = -turn.coeffs();
    last = turn;
    for (int k = 0; k < 4; ++k) turns.push_back(static_cast<float>(turn.coeffs()[k]));
    for (const double x : transform.translation()) places.push_back(static_cast<float>(x));
  }
  ordered_json& animation = glb.json["animations"][0];
  add_channel(animation, node, "translation", times, add_keys(glb, places, 3));
  add_channel(animation, node, "rotation", times, add_keys(glb, turns, 4));
  ordered_json& written = glb.json["nodes"][node];
  written["translation"] = std::vector<float>(places.begin(), places.begin() + 3);
  written["rotation"] = std::vector<float>(turns.begin(), turns.begin() + 4);
}

// `scale` as of quantize(); 0: exact.
void add_targets(Glb& glb, std::size_t node, const Morphs& morphs, std::size_t times, double scale,
                 ordered_json& mesh) {
  ordered_json targets = ordered_json::array();
  for (const Shape& target : morphs.targets) {
    if (scale > 0.0) {
      targets.push_back({{"POSITION", add_steps_16(glb, target.positions, scale)},
                         {"NORMAL", add_normal_steps(glb, target.normals)}});
      continue;
    }
    targets.push_back({{"POSITION", add_vectors(glb, target.positions, true)},
                       {"NORMAL", add_vectors(glb, target.normals, false)}});
  }
  mesh["primitives"][0]["targets"] = targets;
  mesh["weights"] = morphs.weights.front();
  mesh["extras"] = {{"targetNames", morphs.names}};
  std::vector<float> weights;
  for (const auto& frame : morphs.weights)
    weights.insert(weights.end(), frame.begin(), frame.end());
  add_channel(glb.json["animations"][0], node, "weights", times, add_keys(glb, weights));
}

// Returns the number of its morph targets.
std::size_t add_mesh(Glb& glb, const Shot& shot, std::size_t m, const std::vector<Shape>& frames,
                     const GlbOptions& options, std::size_t times, Deviation& deviation) {
  const int basis = options.basis;
  const BakeMesh& mesh = shot.mesh(m);
  ordered_json& json = glb.json;
  const std::size_t number = json["meshes"].size();
  std::vector<std::string> names;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    names.push_back("frame " + std::to_string(shot.frame(f)));
  }
  const Shape rest{mesh.rest.vertices, unit_normals(shot, m, mesh.rest.vertices)};
  const bool still = is_still(frames);
  const RigidMotion rigid = still ? RigidMotion{} : rigid_motion(rest.positions, frames);
  Morphs morphs;
  if (still) {
    morphs.base = frames.front();
  } else if (!rigid.empty()) {
    morphs.base = rest;
  } else {
    morphs =
        basis > 0 ? basis_morphs(rest, frames, names, basis) : exact_morphs(rest, frames, names);
  }
  const bool rounds = options.quantized && !morphs.targets.empty();
  const double scale = rounds ? quantize(morphs) : 0.0;
  ordered_json primitive = {{"attributes",
                             {{"POSITION", rounds ? add_scaled(glb, morphs.base.positions, scale)
                                                  : add_vectors(glb, morphs.base.positions, true)},
                              {"NORMAL", add_vectors(glb, morphs.base.normals, false)}}},
                            {"indices", add_triangles(glb, mesh.rest.triangles)},
                            {"material", material(glb, mesh.kind)}};
  ordered_json written = {{"name", mesh.name}, {"primitives", ordered_json::array({primitive})}};
  json["nodes"].push_back({{"name", mesh.name}, {"mesh", number}});
  json["scenes"][0]["nodes"].push_back(number);
  if (!rigid.empty()) add_rigid_channels(glb, number, rigid, times);
  if (rounds) json["nodes"][number]["scale"] = std::vector<double>(3, scale);
  if (!morphs.targets.empty()) add_targets(glb, number, morphs, times, scale, written);
  json["meshes"].push_back(written);
  const bool stated = basis > 0 || rounds;
  for (std::size_t f = 0; stated && rigid.empty() && f < frames.size(); ++f) {
    const Shape read = morphed(morphs, f);
    for (std::size_t v = 0; v < read.positions.size(); ++v) {
      deviation.add(read.positions[v], frames[f].positions[v], mesh.name, shot.frame(f), v);
      deviation.add_normal(read.normals[v], frames[f].normals[v]);
    }
  }
  return morphs.targets.size();
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

}  // namespace

std::vector<float> seconds_of(const Shot& shot) {
  std::vector<float> seconds;
  const int zero = std::min(shot.first_frame(), 0);
  for (std::size_t f = 0; f < shot.places.size(); ++f) {
    seconds.push_back(static_cast<float>((shot.frame(f) - zero) / shot.info().fps));
  }
  return seconds;
}

std::string time_note(const Shot& shot) {
  return shot.first_frame() < 0 ? "time 0 is the first frame, since glTF has none below 0; "
                                : "time is frame / fps, in seconds; ";
}

void check_targets(const std::filesystem::path& file, std::size_t targets) {
  if (targets <= kMostTargets) return;
  throw Error(ErrorCode::kUsage, file.string() + ": a mesh would have " + std::to_string(targets) +
                                     " morph targets, and readers of glTF take " +
                                     std::to_string(kMostTargets) +
                                     "; give --basis 50, or fewer --frames");
}

std::string targets_note(std::size_t targets, std::size_t frames, int basis) {
  std::string note = std::to_string(targets) + " morph targets a mesh at most";
  if (basis > 0) return note + ", normals fitted";
  note += targets == frames ? ", one a frame, normals too" : "";
  if (targets < kManyTargets) return note;
  return note +
         "; many readers are slow with so many: --basis 50 writes fewer and says what error "
         "that costs";
}

std::string error_note(const Deviation& deviation) {
  char degrees[32];
  std::snprintf(degrees, sizeof degrees, "%.3g", deviation.normal / kDegree);
  return "; position error " + in_mm(deviation.largest) + " at most (" + deviation.where + "), " +
         in_mm(deviation.rms()) + " RMS; normals " + degrees + " degrees at most";
}

void put_errors(const Deviation& deviation, ordered_json& asset) {
  asset["extras"]["position_error_max_mm"] = 1e3 * deviation.largest;
  asset["extras"]["position_error_rms_mm"] = 1e3 * deviation.rms();
  asset["extras"]["normal_error_max_deg"] = deviation.normal / kDegree;
}

Exported export_glb(const Shot& shot, const std::filesystem::path& file,
                    const GlbOptions& options) {
  const int basis = options.basis;
  if (basis == 0) check_targets(file, shot.places.size());
  const std::vector<ShotFrame> shapes = all_frames(shot);
  Glb glb{head(shot), ""};
  const std::size_t times = add_keys(glb, seconds_of(shot));
  Deviation deviation;
  std::size_t targets = 0;
  for (std::size_t m = 0; m < shot.meshes.size(); ++m) {
    std::vector<Shape> frames;
    for (const ShotFrame& shape : shapes) {
      frames.push_back({shape.positions[m], unit_normals(shot, m, shape.positions[m])});
    }
    targets = std::max(targets, add_mesh(glb, shot, m, frames, options, times, deviation));
  }
  check_targets(file, targets);
  if (glb.json["animations"][0]["channels"].empty()) glb.json.erase("animations");
  const bool stated = basis > 0 || options.quantized;
  if (stated) put_errors(deviation, glb.json["asset"]);
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    if (options.quantized && targets > 0) glb.json[list] = {kQuantization};
  }
  write_glb(file, glb);
  return {{file},
          time_note(shot) + targets_note(targets, shapes.size(), basis) +
              (stated ? error_note(deviation) : "; exact, and --quantized would halve the file")};
}

}  // namespace thew::tools
