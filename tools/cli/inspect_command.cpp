// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/inspect_command.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rig/character_bones.h"
#include "rig/import/character_import.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/math.h"
#include "sim/bake/measure.h"
#include "sim/scene/reader.h"
#include "sim/scene/reference.h"
#include "sim/scene/scene.h"
#include "tools/base/bake_mesh.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/signals.h"
#include "tools/base/text.h"
#include "tools/cli/commands.h"
#include "tools/inspect/crossings.h"
#include "tools/inspect/draw_maps.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What was found, as JSON; text is made of it.
struct Found {
  ordered_json facts = ordered_json::object();
  bool sound = true;
};

ordered_json point(const Vec3& p) { return {p.x(), p.y(), p.z()}; }

void add_extent(const TriMesh& mesh, ordered_json& facts) {
  if (mesh.vertices.empty()) return;
  Vec3 low = mesh.vertices[0], high = low;
  for (const Vec3& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  facts["lowest_corner_m"] = point(low);
  facts["highest_corner_m"] = point(high);
}

void add_self_crossings(const TriMesh& mesh, ordered_json& defects, ordered_json& facts) {
  const SelfCrossings crossing = find_self_crossings(mesh);
  if (!crossing.all) {
    facts["self_intersections_looked_for"] = "in part: too many triangles lie in one place";
  }
  if (crossing.pairs == 0) return;
  char at[100];
  std::snprintf(at, sizeof at, "triangles %d and %d at (%.6g, %.6g, %.6g)", crossing.first,
                crossing.second, crossing.at.x(), crossing.at.y(), crossing.at.z());
  defects.push_back({{"defect", "self-intersection, pairs of triangles"},
                     {"count", crossing.pairs},
                     {"first", at},
                     {"fix",
                      "part the surface there in the program that made it: its inside, and "
                      "so its volume, are not defined"}});
}

Found inspect_mesh(const fs::path& file) {
  const ImportedMesh imported = import_mesh(file);
  Found found;
  found.facts = {{"kind", "mesh"},
                 {"vertices", imported.mesh.vertices.size()},
                 {"vertices_before_welding", imported.imported_vertices},
                 {"triangles", imported.mesh.triangles.size()}};
  add_extent(imported.mesh, found.facts);
  ordered_json defects = ordered_json::array();
  for (const Defect& defect : find_defects(imported.mesh)) {
    defects.push_back({{"defect", defect_name(defect.kind)},
                       {"count", defect.count},
                       {"first", defect.where},
                       {"fix", defect.fix}});
  }
  add_self_crossings(imported.mesh, defects, found.facts);
  found.sound = defects.empty();
  if (found.sound) found.facts["volume_m3"] = enclosed_volume(imported.mesh);
  found.facts["defects"] = defects;
  return found;
}

// Of a motion that has no mesh (BVH, or the animations of another file) what a scene's rig.clip
// takes; its lengths have no unit.
Found inspect_character(const Character& character) {
  const Skeleton& skeleton = character.skeleton;
  const bool is_motion = character.parts.empty();
  Found found;
  found.facts = {{"kind", is_motion ? "motion" : "character"}};
  if (!is_motion) {
    found.facts["vertices"] = character.mesh.vertices.size();
    found.facts["triangles"] = character.mesh.triangles.size();
    add_extent(character.mesh, found.facts);
  }
  ordered_json bodies = ordered_json::array(), animations = ordered_json::array();
  for (int i = 0; i < skeleton.size(); ++i) {
    bodies.push_back({{"body", skeleton.body_names[i]}});
    if (skeleton.parent[i] >= 0) bodies.back()["on"] = skeleton.body_names[skeleton.parent[i]];
    if (!is_motion) bodies.back()["at_m"] = point(character.bind[i].translation());
  }
  for (const BodyClip& clip : character.animations) {
    animations.push_back({{"animation", clip.name}, {"seconds", clip.duration}});
  }
  found.facts["bodies"] = bodies;
  found.facts["animations"] = animations;
  found.facts["warnings"] = character.warnings;
  if (!character.size_doubt.empty()) found.facts["warnings"].push_back(character.size_doubt);
  return found;
}

// Not a mesh: it has a skin, a motion or, where rigid pieces hang on its bodies, an arm by name.
bool is_character(const Character& character) {
  const HumanBodies bodies = human_bodies(character);
  const auto has_arm = [&](int side) {
    return bodies.count({BoneKind::kHumerus, side}) > 0 &&
           bodies.count({BoneKind::kForearm, side}) > 0;
  };
  return character.skin.links.size() > character.parts.size() || !character.animations.empty() ||
         has_arm(1) || has_arm(-1);
}

Found inspect_moving(const fs::path& file) {
  const Character motion = import_motion(file);
  if (motion.parts.empty() && !motion.animations.empty()) return inspect_character(motion);
  const Character character = import_character(file);
  return is_character(character) ? inspect_character(character) : inspect_mesh(file);
}

Found inspect_rig(const fs::path& file) {
  const Skeleton skeleton = import_urdf(file, fs::absolute(file).parent_path());
  ordered_json bodies = ordered_json::array();
  for (int i = 0; i < skeleton.size(); ++i) {
    ordered_json body = {{"body", skeleton.body_names[i]}};
    if (skeleton.parent[i] >= 0) {
      const bool turns = skeleton.joint_types[i] == Skeleton::JointType::kRevolute;
      const bool moves = skeleton.joint_types[i] != Skeleton::JointType::kFixed;
      body["on"] = skeleton.body_names[skeleton.parent[i]];
      body["joint"] = skeleton.joint_names[i];
      body["type"] = turns ? "revolute" : (moves ? "prismatic" : "fixed");
      // A joint without limits has infinite ones, for which JSON has no word.
      if (moves && std::isfinite(skeleton.lower[i]) && std::isfinite(skeleton.upper[i])) {
        const double unit = turns ? kDegree : 1.0;
        body[turns ? "range_deg" : "range_m"] = {skeleton.lower[i] / unit,
                                                 skeleton.upper[i] / unit};
      }
      if (moves) body["axis"] = point(skeleton.joint_axes[i]);
    }
    body["meshes"] = skeleton.visuals[i].size();
    bodies.push_back(body);
  }
  return {{{"kind", "rig"}, {"bodies", bodies}}};
}

Found inspect_scene(const fs::path& file) {
  const Scene scene = read_scene(file);
  ordered_json muscles = ordered_json::array();
  for (const SceneMuscle& muscle : scene.muscles) muscles.push_back(muscle.name);
  ordered_json found = {
      {"kind", "scene"},
      {"name", scene.name},
      {"fps", scene.fps},
      {"frames", {scene.first_frame, scene.last_frame}},
      {"rig", scene.rig.string()},
      {"muscles", muscles},
      {"skin", scene.skin.skinned ? "the character's own" : scene.skin.mesh.string()},
      {"integrator", scene.solver.integrator},
      {"volume", scene.solver.volume},
      {"substeps", scene.solver.substeps},
      {"bounds", scene.bounds.size()},
      {"warnings", scene.warnings}};
  if (const auto& tolerance = scene.solver.tolerance) {  // which stands for these two
    found.erase("integrator");
    found.erase("substeps");
    found["tolerance_m"] = tolerance->position;
  }
  return {found};
}

ordered_json crossings_entry(const Crossings& found, const std::vector<BakeMesh>& meshes) {
  ordered_json entry = {{"intersecting_triangle_pairs", found.pairs},
                        {"at_attachments", found.attached},
                        {"deepest_penetration_mm", 1e3 * found.depth}};
  if (found.pairs > 0) {
    entry["first_pair"] = meshes[found.mesh_a].name + " triangle " +
                          std::to_string(found.triangle_a) + " and " + meshes[found.mesh_b].name +
                          " triangle " + std::to_string(found.triangle_b);
    entry["first_pair_at_m"] = point(found.at);
  }
  if (found.deep_mesh >= 0) {
    const bool out = meshes[found.deep_in].kind == BakeMesh::Kind::kSkin;
    entry["deepest"] = meshes[found.deep_mesh].name + " vertex " +
                       std::to_string(found.deep_vertex) + (out ? " outside " : " inside ") +
                       meshes[found.deep_in].name;
    entry["deepest_at_m"] = point(found.deep_at);
  }
  return entry;
}

/// By pair of layers, the worst of the frames seen so far.
struct WorstCrossings {
  Crossings most, deepest;
  int most_attached = 0, most_frame = 0, deepest_frame = 0;
};

void keep_worst(const Crossings& now, int frame, WorstCrossings& worst) {
  worst.most_attached = std::max(worst.most_attached, now.attached);
  if (now.pairs > worst.most.pairs) worst.most = now, worst.most_frame = frame;
  if (now.depth > worst.deepest.depth) worst.deepest = now, worst.deepest_frame = frame;
}

ordered_json worst_entry(const char* layers, const WorstCrossings& worst,
                         const std::vector<BakeMesh>& meshes) {
  Crossings both = worst.deepest;
  both.pairs = worst.most.pairs, both.attached = worst.most_attached, both.at = worst.most.at;
  both.mesh_a = worst.most.mesh_a, both.triangle_a = worst.most.triangle_a;
  both.mesh_b = worst.most.mesh_b, both.triangle_b = worst.most.triangle_b;
  ordered_json entry = {{"layers", layers}};
  entry.update(crossings_entry(both, meshes));
  if (both.pairs > 0) entry["most_pairs_at_frame"] = worst.most_frame;
  if (both.deep_mesh >= 0) entry["deepest_at_frame"] = worst.deepest_frame;
  return entry;
}

const char* const kCrossingsNote =
    "triangle pairs with a common point, by exact tests; bone against bone is left out; what of "
    "bone and muscle crosses where the tendon enters the bone, by the muscle's first and last "
    "vertex within 0.4 of the edge of a cube of its volume, is counted apart as at attachments; "
    "depth is that of vertices inside a closed mesh (of bone and muscle: outside the skin, which "
    "may have a few holes), and not measured of a mesh with itself";

auto crossings_of(const fs::path& file, const BakeInfo& info, const BakeFrame& frame) {
  try {
    return find_crossings(info.meshes, frame.positions);
  } catch (const Error& error) {
    throw Error(error.code(),
                file.string() + ": frame " + std::to_string(frame.frame) + ": " + error.what());
  }
}
const char* const kSingleNote =
    "as written, float32, whose rounding alone makes some 1e-7; report.json has the solver's own "
    "as "
    "max_volume_error";
const char* const kDoubleNote = "as written, float64";

Found inspect_bake(const fs::path& file, const std::string& frames) {
  const BakeReader reader(file);
  const BakeInfo& info = reader.info();
  std::vector<int> chosen = info.frames;
  if (!frames.empty()) chosen = parse_frames(frames, info.frames.front(), info.frames.back());
  std::array<WorstCrossings, kLayerPairs.size()> worst_crossings;
  ordered_json crossings = ordered_json::array(), crossings_by_frame = ordered_json::array();
  int checked = 0;
  std::vector<double> worst(info.meshes.size(), 0.0);
  std::vector<int> worst_frame(info.meshes.size(), info.frames.front());
  for (std::size_t f = 0; f < info.frames.size(); ++f) {
    stop_if_interrupted();
    BakeFrame frame = reader.read(static_cast<int>(f));
    if (std::find(chosen.begin(), chosen.end(), frame.frame) != chosen.end()) {
      const auto found = crossings_of(file, info, frame);
      ordered_json entry = {{"frame", frame.frame}};
      for (std::size_t i = 0; i < found.size(); ++i) {
        entry[kLayerPairs[i]] = crossings_entry(found[i], info.meshes);
        keep_worst(found[i], frame.frame, worst_crossings[i]);
      }
      crossings_by_frame.push_back(entry);
      ++checked;
    }
    for (std::size_t m = 0; m < info.meshes.size(); ++m) {
      const double error =
          written_volume_error(info.meshes[m], frame.positions[m], info.double_precision);
      if (!(error <= worst[m])) worst[m] = error, worst_frame[m] = frame.frame;
    }
  }
  for (std::size_t i = 0; i < kLayerPairs.size(); ++i) {
    crossings.push_back(worst_entry(kLayerPairs[i], worst_crossings[i], info.meshes));
  }
  ordered_json meshes = ordered_json::array();
  for (std::size_t m = 0; m < info.meshes.size(); ++m) {
    const BakeMesh& mesh = info.meshes[m];
    ordered_json entry = {{"mesh", mesh.name},
                          {"kind", kind_name(mesh.kind)},
                          {"vertices", mesh.rest.vertices.size()},
                          {"triangles", mesh.rest.triangles.size()},
                          {"rest_volume_m3", enclosed_volume(mesh.rest)}};
    if (std::isfinite(worst[m])) {  // a mesh of no volume has no relative error
      entry["max_volume_error_written"] = worst[m];
      entry["at_frame"] = worst_frame[m];
    }
    meshes.push_back(entry);
  }
  return {{{"kind", "bake"},
           {"scene", info.scene_name},
           {"scene_hash", info.scene_hash},
           {"hash", info.hash},
           {"fps", info.fps},
           {"frames", info.frames.size()},
           {"first_frame", info.frames.front()},
           {"last_frame", info.frames.back()},
           {"precision", info.double_precision ? "double" : "single"},
           {"meshes", meshes},
           {"volume_error_note", info.double_precision ? kDoubleNote : kSingleNote},
           {"metrics", info.metric_names},
           {"frames_checked_for_crossings", checked},
           {"crossings", crossings},
           {"crossings_note", kCrossingsNote},
           {"crossings_by_frame", crossings_by_frame}}};
}

std::string value_text(const ordered_json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return readable(value.get<double>(), 6);
  if (!value.is_array()) return value.dump();
  std::string text;
  for (const ordered_json& entry : value) text += (text.empty() ? "" : ", ") + value_text(entry);
  return value.empty() ? "none" : text;
}

// One line a fact; a list of objects is one line an object.
std::string as_text(const fs::path& file, const Found& found) {
  std::string text = file.string() + (found.sound ? "" : ": not sound") + "\n";
  for (const auto& [key, value] : found.facts.items()) {
    if (key == "crossings_by_frame") continue;  // for programs; people read the worst of them
    if (!value.is_array() || value.empty() || !value[0].is_object()) {
      text += "  " + in_words(key) + ": " + value_text(value) + "\n";
      continue;
    }
    text += "  " + in_words(key) + ":\n";
    for (const ordered_json& entry : value) {
      std::string line;
      for (const auto& [name, one] : entry.items()) {
        line += (line.empty() ? "    " : "; " + in_words(name) + " ") + value_text(one);
      }
      text += line + "\n";
    }
  }
  return text;
}

}  // namespace

Inspection inspect(const fs::path& file, bool as_json, const std::string& frames) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  Found found;
  if (ending == ".urdf") {
    found = inspect_rig(file);
  } else if (ending == ".toml") {
    found = inspect_scene(file);
  } else if (ending == ".h5") {
    found = inspect_bake(file, frames);
  } else if (names_motion(file)) {
    found = inspect_moving(file);
  } else {
    found = inspect_mesh(file);
  }
  if (!as_json) return {as_text(file, found), found.sound};
  ordered_json all = {{"file", file.string()}, {"sound", found.sound}};
  all.update(found.facts);
  return {json_text(all, 1) + "\n", found.sound};
}

Inspection inspect_maps(const fs::path& file, const fs::path& folder,
                        const CommandOptions& options) {
  Found found;
  found.facts = {{"kind", "scene"}, {"maps", ordered_json::array()}};
  for (const DrawnMap& map : draw_maps(read_scene(file), folder, options.overwrite)) {
    found.facts["maps"].push_back({{"mesh", map.mesh},
                                   {"map", map.quantity},
                                   {"from", map.least},
                                   {"to", map.most},
                                   {"picture", map.picture.string()}});
  }
  if (!options.json) return {as_text(file, found), true};
  ordered_json all = {{"file", file.string()}, {"sound", true}};
  all.update(found.facts);
  return {json_text(all, 1) + "\n", true};
}

std::string inspect_keys(bool as_json) {
  if (!as_json) return scene_reference();
  ordered_json keys = ordered_json::array();
  for (const KeyEntry& entry : scene_keys()) {
    keys.push_back({{"section", entry.section},
                    {"key", entry.key},
                    {"type", entry.type},
                    {"unit", entry.unit},
                    {"default", entry.standard},
                    {"range", entry.range},
                    {"meaning", entry.meaning}});
  }
  return ordered_json{{"keys", keys}}.dump(1) + "\n";
}

}  // namespace thew::tools
