// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/reader.h"

#include <charconv>
#include <optional>
#include <set>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/read_muscle.h"
#include "sim/scene/read_rig.h"
#include "sim/scene/values.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

// From a mouse to what no animal is; beyond it other numbers are meant.
constexpr Range kBodySize{1e-3, 1e3};

// "1-120", "-5--1", "7"
std::optional<std::array<int, 2>> parse_frames(const std::string& text) {
  std::array<int, 2> frames;
  const char* end = text.data() + text.size();
  auto [at, error] = std::from_chars(text.data(), end, frames[0]);
  frames[1] = frames[0];
  if (error == std::errc() && at != end && *at == '-') {
    const auto second = std::from_chars(at + 1, end, frames[1]);
    at = second.ptr;
    error = second.ec;
  }
  if (error != std::errc() || at != end) return std::nullopt;
  return frames;
}

void read_frames(TomlValue& value, Scene& scene) {
  std::optional<std::array<int, 2>> frames;
  if (value.type == TomlValue::Type::kText) frames = parse_frames(value.text);
  if (value.type == TomlValue::Type::kInteger) {
    const int one = integer_of(value, -kLastFrame, kLastFrame);
    frames = {one, one};
  }
  if (value.type == TomlValue::Type::kArray && value.items.size() == 2) {
    frames = {integer_of(value.items[0], -kLastFrame, kLastFrame),
              integer_of(value.items[1], -kLastFrame, kLastFrame)};
  }
  if (!frames || (*frames)[0] > (*frames)[1] || (*frames)[0] < -kLastFrame ||
      (*frames)[1] > kLastFrame) {
    refuse(value, "give the first and the last frame, \"1-120\", without a step");
  }
  scene.first_frame = (*frames)[0];
  scene.last_frame = (*frames)[1];
}

void read_general(TomlValue& table, Scene& scene) {
  if (const TomlValue* name = find(table, "name")) scene.name = text_of(*name);
  read(table, "fps", scene.fps, {1e-2, 1e5});
  if (TomlValue* frames = find(table, "frames")) read_frames(*frames, scene);
  read(table, "settle", scene.settle, {0.0, 1000.0});
  read(table, "gravity", scene.gravity, {-1e4, 1e4});
  read(table, "size", scene.size, kBodySize);
}

// The joints' own key frames need not be the same; a clip has one row of all joints a key. Where
// they differ each joint's own curve is sampled at all of them and at every frame.
Clip merge_curves(const std::vector<Clip>& curves, const Scene& scene) {
  Clip clip = curves[0];
  std::set<double> times;
  bool alike = true;
  for (const Clip& curve : curves) {
    times.insert(curve.times.begin(), curve.times.end());
    alike = alike && curve.times == clip.times;
  }
  for (int f = 0; !alike && f <= scene.last_frame - scene.first_frame; ++f) {
    times.insert(f / scene.fps);
  }
  clip.times.assign(times.begin(), times.end());
  clip.values.assign(times.size(), {});
  clip.joints.clear();
  Skeleton one;  // of a single joint
  one.body_names = {""};
  std::vector<double> value;
  for (const Clip& curve : curves) {
    one.joint_names = curve.joints;
    clip.joints.push_back(curve.joints[0]);
    for (std::size_t k = 0; k < clip.times.size(); ++k) {
      sample_clip(curve, one, clip.times[k], value);
      clip.values[k].push_back(value[0]);
    }
  }
  return clip;
}

Clip read_keys(TomlValue& keys, double unit, Clip::Interpolation interpolation,
               const Scene& scene) {
  std::vector<Clip> curves;
  entries_of(keys);
  for (std::size_t j = 0; j < keys.items.size(); ++j) {
    Clip& curve = curves.emplace_back();
    curve.joints = {keys.keys[j]};
    curve.interpolation = interpolation;
    for (const auto& [frame, value] : pairs_of(keys.items[j], "[frame, value]", kFrames,
                                               {-kMaxAngle / kDegree, kMaxAngle / kDegree})) {
      curve.times.push_back((frame - scene.first_frame) / scene.fps);
      curve.values.push_back({value * unit});
    }
  }
  if (curves.empty()) refuse(keys, "give { JOINT = [[frame, value], ...] }");
  return merge_curves(curves, scene);
}

Clip read_clip_file(TomlValue& value, TomlValue* columns, const Folders& folders) {
  ColumnMap map;
  if (columns) {
    const TomlValue& table = entries_of(*columns);
    for (std::size_t i = 0; i < table.items.size(); ++i) {
      const bool left_out =
          table.items[i].type == TomlValue::Type::kText && table.items[i].text.empty();
      map[table.keys[i]] = left_out ? "" : text_of(table.items[i]);
    }
  }
  const fs::path file = file_of(value, folders);
  const std::string ending = file.extension().string();
  if (ending == ".csv") return read_csv(file, map);
  if (ending == ".mot" || ending == ".sto") return read_mot(file, map);
  if (ending == ".osim") {
    refuse(value, "give its motion, a .mot or .sto", ", but muscles of OpenSim are not read");
  }
  refuse(value, "give a .mot, .sto or .csv file");
}

void read_clip(TomlValue& table, const Folders& folders, Scene& scene) {
  scene.clip_location = table.location;
  std::string interpolation = "smooth", unit = "rad";
  read(table, "interpolation", interpolation, {"smooth", "linear"});
  const auto way =
      interpolation == "linear" ? Clip::Interpolation::kLinear : Clip::Interpolation::kSmooth;
  const auto [kind, value] = require_one(table, {"keys", "file"});
  if (kind == "keys") {
    read(table, "unit", unit, {"rad", "deg"});
    scene.clip = read_keys(*value, unit == "deg" ? kDegree : 1.0, way, scene);
    scene.clip.angles_only = unit == "deg";
  } else {
    scene.clip = read_clip_file(*value, find(table, "columns"), folders);
    scene.clip.interpolation = way;
  }
}

void read_rig(TomlValue& table, const Folders& folders, Scene& scene) {
  TomlValue& file = require(table, "file");
  scene.rig = file_of(file, folders);
  scene.rig_location = file.location;
  scene.clip_location = table.location;
  scene.clip.times = {0.0};  // none: the rest pose
  scene.clip.values = {{}};
  const bool character = names_character(scene.rig);
  if (character) read_character_rig(table, folders, scene);
  TomlValue* clip = find(table, "clip");
  if (clip && character && read_character_clip(*clip, folders, scene)) return;
  if (clip) read_clip(*clip, folders, scene);
}

void read_skin(TomlValue& table, const Folders& folders, Scene& scene) {
  scene.skin.location = table.location;
  std::string kind = "layer";
  read(table, "kind", kind, {"layer", "skinned"});
  scene.skin.skinned = kind == "skinned";
  if (scene.skin.skinned && !scene.character.given) {
    refuse(*find(table, "kind"), "give a layer's mesh, or a character as [rig] file",
           ", but the rig has no skin of its own");
  }
  if (!scene.skin.skinned) scene.skin.mesh = file_of(require(table, "mesh"), folders);
  SkinSettings& settings = scene.skin.settings;
  read(table, "thickness", settings.thickness, kLength);
  read(table, "smoothing", settings.smoothing, kShare);
  read(table, "iterations", settings.iterations, 1, 10000);
  read(table, "fold_gap", settings.fold_gap, kLength);
  read(table, "reach", settings.reach, kSize);
  std::string volume = "none";
  read(table, "volume", volume, {"none", "exact"});
  settings.keeps_volume = volume == "exact";
  if (settings.keeps_volume && scene.skin.skinned) {
    refuse(*find(table, "volume"), "remove it, or give a layer's mesh",
           ", but the character's own skin need not be closed");
  }
  bool enabled = true;
  read(table, "enabled", enabled);
  if (enabled) return;
  scene.skin.mesh.clear();
  scene.skin.skinned = false;
}

// What is beyond them no choice of ours can promise.
constexpr Range kPositionTolerance{1e-6, 1.0}, kVolumeTolerance{1e-12, 1.0};

void read_tolerance(TomlValue& solver, TomlValue& table, Scene& scene) {
  for (const char* key : {"integrator", "substeps", "iterations"}) {
    if (const TomlValue* other = find(solver, key)) {
      refuse(*other, "remove it, or the tolerance at " + table.location,
             ", but a tolerance chooses it for each muscle");
    }
  }
  if (const TomlValue* volume = find(solver, "volume"); volume && volume->text != "exact") {
    refuse(*volume, "give \"exact\", or remove the tolerance at " + table.location,
           ", which holds no tolerance");
  }
  auto& tolerance = scene.solver.tolerance.emplace();
  tolerance.location = table.location;
  tolerance.position = length_of(require(table, "position"), kPositionTolerance);
  read(table, "volume", tolerance.volume, kVolumeTolerance);
}

void read_solver(TomlValue& table, Scene& scene) {
  scene.solver.location = table.location;
  read(table, "integrator", scene.solver.integrator,
       {"explicit", "xpbd", "local_global", "quasi_static"});
  read(table, "volume", scene.solver.volume,
       {"none", "penalty", "printed", "linear", "exact", "exact_always", "zonal"});
  read(table, "substeps", scene.solver.substeps, 1, 1000000);
  read(table, "iterations", scene.solver.iterations, 1, 10000);
  const std::string& integrator = scene.solver.integrator;
  if (scene.solver.volume == "zonal" && (integrator == "xpbd" || integrator == "explicit")) {
    refuse(*find(table, "volume"), "take integrator = \"local_global\" or \"quasi_static\"",
           ", which \"" + integrator + "\" cannot hold");
  }
  if (TomlValue* tolerance = find(table, "tolerance")) read_tolerance(table, *tolerance, scene);
}

void read_contact(TomlValue& table, Scene& scene) {
  read(table, "enabled", scene.contact.enabled);
  read(table, "margin", scene.contact.settings.margin, kLength);
  read(table, "max_depth", scene.contact.settings.max_depth, kLength);
  read(table, "gap", scene.contact.settings.gap, kLength);
  read(table, "spacing", scene.contact.settings.spacing, kSize);
  read(table, "friction", scene.contact.friction, kNotNegative);
  if (TomlValue* thickness = find(table, "thickness")) {
    if (thickness->type != TomlValue::Type::kTable) {
      refuse(*thickness, "name surfaces, { humerus = 0.001 }");
    }
    for (const std::string& name : thickness->keys) {
      double metres = 0.0;
      read(*thickness, name.c_str(), metres, kLength);
      scene.contact.thickness.push_back({name, metres});
    }
  }
  if (TomlValue* self = find(table, "self")) {
    for (TomlValue& item : items_of(*self, "names of muscles, [\"a\", ...]", 0, 1000000)) {
      scene.contact.self.push_back(text_of(item));
    }
  }
  if (!can_solve_contact(scene, scene.solver.integrator)) {
    refuse(*find(table, scene.contact.friction > 0.0 ? "friction" : "self"),
           "take integrator = \"local_global\" or \"quasi_static\"",
           ", which \"" + scene.solver.integrator + "\" cannot solve");
  }
  TomlValue* ignore = find(table, "ignore");
  if (!ignore) return;
  scene.contact.location = ignore->location;
  for (TomlValue& item : items_of(*ignore, "pairs of names, [[\"a\", \"b\"], ...]", 0, 1000000)) {
    const std::vector<TomlValue>& pair = items_of(item, "a pair of names, [\"a\", \"b\"]", 2, 2);
    scene.contact.ignore.push_back({text_of(pair[0]), text_of(pair[1])});
  }
}

void read_cut(TomlValue& value, SceneView& view) {
  for (TomlValue& item : items_of(value, "planes, [[nx, ny, nz, d], ...]", 1, kMostCuts)) {
    const std::vector<TomlValue>& four = items_of(item, "a plane, [nx, ny, nz, d]", 4, 4);
    const Vec3 normal(number_of(four[0], kDirection), number_of(four[1], kDirection),
                      number_of(four[2], kDirection));
    if (!(normal.norm() > 1e-9)) refuse(item, "give a normal that is not zero");
    const Vec3 n = normal.normalized();
    view.cut.push_back({n.x(), n.y(), n.z(), number_of(four[3], kPlace)});
  }
}

SceneView read_view(TomlValue& table) {
  const std::vector<std::string> shows = {"skin", "muscles", "weights", "cutaway"};
  SceneView view;
  view.name = name_of(require(table, "name"));
  for (const std::string& show : shows) {
    if (view.name == show) view.show = show;
  }
  read(table, "show", view.show, shows);
  read(table, "eye", view.eye, kPlace);
  read(table, "target", view.target, kPlace);
  read(table, "up", view.up, kDirection);
  read(table, "field_of_view", view.field_of_view, {1.0, 170.0});
  read(table, "light", view.light, kDirection);
  if (TomlValue* cut = find(table, "cut")) read_cut(*cut, view);
  if (view.show == "cutaway" && view.cut.empty()) {
    throw Error(ErrorCode::kUsage, table.location + ": [" + table.name +
                                       "] has no cut; say where the skin is open, by planes of the "
                                       "rest pose: cut = [[0, 0, 1, 0.02]]");
  }
  const Vec3 direction = view.target - view.eye;
  if (direction.cross(view.up).norm() <= 1e-6 * direction.norm() * view.up.norm()) {
    throw Error(ErrorCode::kUsage,
                table.location + ": [" + table.name + "] looks from " + point_text(view.eye) +
                    " to " + point_text(view.target) + " with " + point_text(view.up) +
                    " up; give two points, and an up that is not along the view");
  }
  return view;
}

void refuse_duplicate(const TomlValue& table, std::set<std::string>& names,
                      const std::string& name) {
  if (names.insert(name).second) return;
  throw Error(ErrorCode::kUsage,
              table.location + ": a second [" + table.name + "]; give each a name of its own");
}

SceneRender read_render(TomlValue& table) {
  SceneRender render;
  if (TomlValue* size = find(table, "size")) {
    const std::vector<TomlValue>& two = items_of(*size, "pixels, [width, height]", 2, 2);
    render.width = integer_of(two[0], 16, 16384);  // OSMesa draws nonsense beyond that
    render.height = integer_of(two[1], 16, 16384);
  }
  std::set<std::string> names;
  for (TomlValue* view : tables_of(table, "view")) {
    render.views.push_back(read_view(*view));
    refuse_duplicate(*view, names, render.views.back().name);
  }
  return render;
}

void read_bounds(TomlValue& table, Scene& scene) {
  for (const char* quantity :
       {"volume_error", "substep_volume_error", "penetration", "poke_through", "attachment_gap"}) {
    const TomlValue* limit = find(table, quantity);
    if (!limit) continue;
    for (const Bound& bound : scene.bounds) {
      if (bound.quantity == quantity) refuse(*limit, "remove it, or the one at " + bound.location);
    }
    scene.bounds.push_back({quantity, number_of(*limit, kNotNegative), limit->location});
  }
}

void read_all(TomlValue& root, const Folders& folders, Scene& scene) {
  if (TomlValue* table = find(root, "scene")) read_general(*table, scene);
  scene.skin.settings = times(scene.skin.settings, scene.size);
  scene.contact.settings = times(scene.contact.settings, scene.size);
  read_rig(require(root, "rig"), folders, scene);
  std::set<std::string> names;
  for (TomlValue* table : tables_of(root, "muscle")) {
    scene.muscles.push_back(read_muscle(*table, folders, scene.size));
    refuse_duplicate(*table, names, scene.muscles.back().name);
  }
  if (TomlValue* table = find(root, "skin")) read_skin(*table, folders, scene);
  if (TomlValue* table = find(root, "solver")) read_solver(*table, scene);
  if (TomlValue* table = find(root, "contact")) read_contact(*table, scene);
  if (TomlValue* table = find(root, "render")) scene.render = read_render(*table);
  if (TomlValue* table = find(root, "output")) {
    std::string precision = "single";
    read(*table, "precision", precision, {"single", "double"});
    scene.output.double_precision = precision == "double";
  }
  for (TomlValue* table : tables_of(root, "bound")) read_bounds(*table, scene);
}

}  // namespace

bool can_solve_contact(const Scene& scene, const std::string& integrator) {
  const bool asks = scene.contact.friction > 0.0 || !scene.contact.self.empty();
  return !asks || integrator == "local_global" || integrator == "quasi_static";
}

Scene read_scene(const fs::path& file, const std::vector<std::string>& overrides,
                 const fs::path& allowed_root) {
  TomlValue root = read_toml(file);
  for (const std::string& setting : overrides) override_toml(root, setting);
  Scene scene;
  scene.file = file;
  const Folders folders = {fs::canonical(fs::absolute(file).parent_path()),
                           allowed_root.empty() ? fs::canonical(fs::absolute(file).parent_path())
                                                : fs::weakly_canonical(fs::absolute(allowed_root))};
  scene.folder = folders.root;
  read_all(root, folders, scene);
  refuse_unknown_keys(root);
  return scene;
}

SceneRender read_render(const fs::path& file, const std::vector<std::string>& overrides) {
  TomlValue root = read_toml(file);
  for (const std::string& setting : overrides) override_toml(root, setting);
  TomlValue& table = require(root, "render");
  SceneRender render = read_render(table);
  refuse_unknown_keys(table);
  return render;
}

}  // namespace thew::sim
