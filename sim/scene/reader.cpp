// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/reader.h"

#include <charconv>
#include <optional>
#include <set>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/cache/cached_mesh.h"
#include "sim/scene/read_map.h"
#include "sim/scene/read_muscle.h"
#include "sim/scene/read_rig.h"
#include "sim/scene/rig_keys.h"
#include "sim/scene/scene_keys.h"
#include "sim/scene/values.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

// Names in a list of a scene: more than a scene has muscles, so that no slip exhausts the memory.
constexpr std::size_t kMostNames = 1000000;

// Reads "1-120", "-5--1" or "7".
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

void read_frames(TomlValue& value, const Range& range, Scene& scene) {
  std::optional<std::array<int, 2>> frames;
  if (value.type == TomlValue::Type::kText) frames = parse_frames(value.text);
  if (value.type == TomlValue::Type::kInteger) {
    const int one = integer_of(value, range);
    frames = {one, one};
  }
  if (value.type == TomlValue::Type::kArray && value.items.size() == 2) {
    frames = {integer_of(value.items[0], range), integer_of(value.items[1], range)};
  }
  if (!frames || (*frames)[0] > (*frames)[1] || (*frames)[0] < range.least ||
      (*frames)[1] > range.most) {
    refuse(value, "give the first and the last frame, \"1-120\", without a step");
  }
  scene.first_frame = (*frames)[0];
  scene.last_frame = (*frames)[1];
}

void read_general(TomlValue& table, Scene& scene) {
  if (const TomlValue* name = find(table, kScene["name"])) scene.name = text_of(*name);
  read(table, kScene["fps"], scene.fps);
  if (TomlValue* frames = find(table, kScene["frames"])) {
    read_frames(*frames, kScene["frames"].range, scene);
  }
  read(table, kScene["settle"], scene.settle);
  read(table, kScene["gravity"], scene.gravity);
  read(table, kScene["size"], scene.size);
}

// Joints may have keys at different frames, but a clip has one row of values for all joints. Where
// the frames differ, each joint's own curve is sampled at all of them and at every frame.
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
    for (const auto& [frame, value] : pairs_of(keys.items[j], "[frame, value]", kClip["keys"])) {
      curve.times.push_back((frame - scene.first_frame) / scene.fps);
      curve.values.push_back({value * unit});
    }
  }
  if (curves.empty()) refuse(keys, std::string("give ") + kClip["keys"].form);
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
  const auto way = read_word(table, kClip["interpolation"]) == "linear"
                       ? Clip::Interpolation::kLinear
                       : Clip::Interpolation::kSmooth;
  const auto [kind, value] = require_one(table, {&kClip["keys"], &kClip["file"]});
  if (kind == "keys") {
    const std::string unit = read_word(table, kClip["unit"]);
    scene.clip = read_keys(*value, unit == "deg" ? kDegree : 1.0, way, scene);
    scene.clip.angles_only = unit == "deg";
  } else {
    scene.clip = read_clip_file(*value, find(table, kClip["columns"]), folders);
    scene.clip.interpolation = way;
  }
}

void read_rig(TomlValue& table, const Folders& folders, Scene& scene) {
  scene.clip_location = table.location;
  scene.clip.times = {0.0};  // none: the rest pose
  scene.clip.values = {{}};
  TomlValue* file = find(table, kRig["file"]);
  if (!file && find(table, kRig["bone"])) return read_cached_rig(table, folders, scene);
  if (!file) file = &require(table, kRig["file"]);
  scene.rig = file_of(*file, folders);
  scene.rig_location = file->location;
  if (names_bake(scene.rig)) return read_cached_rig(table, folders, scene);
  const bool character = names_character(scene.rig);
  if (character) read_character_rig(table, folders, scene);
  TomlValue* clip = find(table, kRig["clip"]);
  if (clip && character && read_character_clip(*clip, folders, scene)) return;
  if (clip) read_clip(*clip, folders, scene);
}

void read_skin(TomlValue& table, const Folders& folders, Scene& scene) {
  scene.skin.location = table.location;
  scene.skin.skinned = read_word(table, kSkin["kind"]) == "skinned";
  if (scene.skin.skinned && !scene.character.given) {
    refuse(*find(table, kSkin["kind"]), "give a layer's mesh, or a character as [rig] file",
           ", but the rig has no skin of its own");
  }
  TomlValue* cache = scene.skin.skinned ? nullptr : find(table, kSkin["cache"]);
  if (cache) {
    scene.skin.cache = file_of(*cache, folders);
    scene.skin.start = read_frame(table, kSkin["start"]);
  }
  if (!scene.skin.skinned && !names_bake(scene.skin.cache)) {
    scene.skin.mesh = file_of(require(table, kSkin["mesh"]), folders);
  }
  SkinSettings& settings = scene.skin.settings;
  read(table, kSkin["thickness"], settings.thickness);
  read(table, kSkin["smoothing"], settings.smoothing);
  read(table, kSkin["iterations"], settings.iterations);
  read(table, kSkin["fold_gap"], settings.fold_gap);
  read(table, kSkin["reach"], settings.reach);
  if (TomlValue* ignore = find(table, kSkin["ignore"])) {
    for (TomlValue& item : items_of(*ignore, kSkin["ignore"].form, 0, kMostNames)) {
      scene.skin.ignore.push_back(text_of(item));
    }
    if (!scene.skin.skinned) {
      refuse(*ignore, "remove it, or take kind = \"skinned\"", ", but a layer feels all bones");
    }
  }
  SceneSkin& skin = scene.skin;
  read_number_or_map(table, kSkin["fat"], folders, scene.size, skin.fat, skin.fat_map);
  read_number_or_map(table, kSkin["slide"], folders, scene.size, skin.slide, skin.slide_map);
  for (const Key* key : {&kSkin["fat"], &kSkin["slide"]}) {
    TomlValue* value = find(table, *key);
    if (!value || skin.cache.empty()) continue;
    refuse(*value, "remove it, or give a layer's mesh without a cache",
           ", but a skin with a shape by frame keeps to its flesh as it was modelled");
  }
  settings.keeps_volume = read_word(table, kSkin["volume"]) == "exact";
  if (settings.keeps_volume && scene.skin.skinned) {
    refuse(*find(table, kSkin["volume"]), "remove it, or give a layer's mesh",
           ", but the character's own skin need not be closed");
  }
  read(table, kSkin["enabled"], scene.skin.enabled);
  if (scene.skin.enabled) return;
  scene.skin.mesh.clear();
  scene.skin.cache.clear();
  scene.skin.skinned = false;
}

void read_tolerance(TomlValue& solver, TomlValue& table, Scene& scene) {
  for (const Key* key : {&kSolver["integrator"], &kSolver["substeps"], &kSolver["iterations"]}) {
    if (const TomlValue* other = find(solver, *key)) {
      refuse(*other, "remove it, or the tolerance at " + table.location,
             ", but a tolerance chooses it for each muscle");
    }
  }
  if (const TomlValue* volume = find(solver, kSolver["volume"]);
      volume && volume->text != "exact") {
    refuse(*volume, "give \"exact\", or remove the tolerance at " + table.location,
           ", which holds no tolerance");
  }
  auto& tolerance = scene.solver.tolerance.emplace();
  tolerance.location = table.location;
  tolerance.position =
      length_of(require(table, kTolerance["position"]), kTolerance["position"].range);
  read(table, kTolerance["volume"], tolerance.volume);
}

void read_solver(TomlValue& table, Scene& scene) {
  scene.solver.location = table.location;
  read(table, kSolver["integrator"], scene.solver.integrator);
  read(table, kSolver["volume"], scene.solver.volume);
  read(table, kSolver["substeps"], scene.solver.substeps);
  read(table, kSolver["iterations"], scene.solver.iterations);
  const std::string& integrator = scene.solver.integrator;
  if (scene.solver.volume == "zonal" && (integrator == "xpbd" || integrator == "explicit")) {
    refuse(*find(table, kSolver["volume"]),
           "take integrator = \"local_global\" or \"quasi_static\"",
           ", which \"" + integrator + "\" cannot hold");
  }
  if (TomlValue* tolerance = find(table, kSolver["tolerance"]))
    read_tolerance(table, *tolerance, scene);
}

void read_contact(TomlValue& table, const Folders& folders, Scene& scene) {
  read(table, kContact["enabled"], scene.contact.enabled);
  read(table, kContact["margin"], scene.contact.settings.margin);
  read(table, kContact["max_depth"], scene.contact.settings.max_depth);
  read(table, kContact["gap"], scene.contact.settings.gap);
  read(table, kContact["spacing"], scene.contact.settings.spacing);
  read(table, kContact["friction"], scene.contact.friction);
  if (TomlValue* thickness = find(table, kContact["thickness"])) {
    if (thickness->type != TomlValue::Type::kTable) {
      refuse(*thickness, kContact["thickness"].form);
    }
    entries_of(*thickness);
    for (std::size_t i = 0; i < thickness->items.size(); ++i) {
      TomlValue& one = thickness->items[i];
      const Key& key = kContact["thickness"];
      if (one.type == TomlValue::Type::kTable) {
        scene.contact.thickness_maps.push_back(
            {thickness->keys[i], read_map(one, key, folders, scene.size)});
      } else {
        scene.contact.thickness.push_back({thickness->keys[i], number_of(one, key.range)});
      }
    }
  }
  if (TomlValue* self = find(table, kContact["self"])) {
    for (TomlValue& item : items_of(*self, kContact["self"].form, 0, kMostNames)) {
      scene.contact.self.push_back(text_of(item));
    }
  }
  if (!can_solve_contact(scene, scene.solver.integrator)) {
    refuse(*find(table, scene.contact.friction > 0.0 ? kContact["friction"] : kContact["self"]),
           "take integrator = \"local_global\" or \"quasi_static\"",
           ", which \"" + scene.solver.integrator + "\" cannot solve");
  }
  TomlValue* ignore = find(table, kContact["ignore"]);
  if (!ignore) return;
  scene.contact.location = ignore->location;
  for (TomlValue& item : items_of(*ignore, kContact["ignore"].form, 0, kMostNames)) {
    const std::vector<TomlValue>& pair = items_of(item, "a pair of names, [\"a\", \"b\"]", 2, 2);
    scene.contact.ignore.push_back({text_of(pair[0]), text_of(pair[1])});
  }
}

void read_cut(TomlValue& value, SceneView& view) {
  for (TomlValue& item : items_of(value, kView["cut"].form, 1, kMostCuts)) {
    const std::vector<TomlValue>& four = items_of(item, "a plane, [nx, ny, nz, d]", 4, 4);
    const Vec3 normal(number_of(four[0], kView["cut"].range),
                      number_of(four[1], kView["cut"].range),
                      number_of(four[2], kView["cut"].range));
    if (!(normal.norm() > 1e-9)) refuse(item, "give a normal that is not zero");
    const Vec3 n = normal.normalized();
    view.cut.push_back({n.x(), n.y(), n.z(), number_of(four[3], kView["cut"].second)});
  }
}

SceneView read_view(TomlValue& table) {
  SceneView view;
  view.location = table.location;
  view.name = name_of(require(table, kView["name"]));
  for (const char* word : kView["show"].words) {
    if (word && view.name == word) view.show = word;
  }
  read(table, kView["show"], view.show);
  read(table, kView["eye"], view.eye);
  read(table, kView["target"], view.target);
  if (TomlValue* from = find(table, kView["from"])) {
    view.from = direction_of(*from, kView["from"].range);
    if (find(table, kView["eye"]) || find(table, kView["target"])) {
      refuse(*from, "leave out either", ", in place of eye and target");
    }
    view.eye = view.from;  // until the motion is known
  }
  if (TomlValue* follow = find(table, kView["follow"])) view.follow = text_of(*follow);
  read(table, kView["up"], view.up);
  read(table, kView["field_of_view"], view.field_of_view);
  read(table, kView["light"], view.light);
  if (TomlValue* cut = find(table, kView["cut"])) read_cut(*cut, view);
  if (view.show == "cutaway" && view.cut.empty()) {
    throw Error(ErrorCode::kUsage, table.location + ": [" + table.name +
                                       "] has no cut; say where the skin is open, by planes of the "
                                       "rest pose: cut = [[0, 0, 1, 0.02]]");
  }
  const Vec3 direction = view.target - view.eye;
  if (direction.cross(view.up).norm() <= 1e-6 * direction.norm() * view.up.norm()) {
    throw Error(ErrorCode::kUsage, table.location + ": [" + table.name + "] looks from " +
                                       point_text(view.eye) + " to " + point_text(view.target) +
                                       " with " + point_text(view.up) + " up; give " +
                                       (view.from.isZero() ? "two points" : "a direction") +
                                       ", and an up that is not along the view");
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
  if (TomlValue* size = find(table, kRender["size"])) {
    const std::vector<TomlValue>& two = items_of(*size, kRender["size"].form, 2, 2);
    render.width = integer_of(two[0], kRender["size"].range);
    render.height = integer_of(two[1], kRender["size"].range);
  }
  std::set<std::string> names;
  for (TomlValue* view : tables_of(table, kRender["view"])) {
    render.views.push_back(read_view(*view));
    refuse_duplicate(*view, names, render.views.back().name);
  }
  return render;
}

void read_bounds(TomlValue& table, Scene& scene) {
  for (const Key& quantity : kBound.keys) {
    const TomlValue* limit = find(table, quantity);
    if (!limit) continue;
    for (const Bound& bound : scene.bounds) {
      if (bound.quantity == quantity.name)
        refuse(*limit, "remove it, or the one at " + bound.location);
    }
    scene.bounds.push_back({quantity.name, number_of(*limit, quantity.range), limit->location});
  }
}

void read_all(TomlValue& root, const Folders& folders, Scene& scene) {
  if (TomlValue* table = find(root, kFile["scene"])) read_general(*table, scene);
  scene.skin.settings = times(scene.skin.settings, scene.size);
  scene.contact.settings = times(scene.contact.settings, scene.size);
  read_rig(require(root, kFile["rig"]), folders, scene);
  std::set<std::string> names;
  for (TomlValue* table : tables_of(root, kFile["muscle"])) {
    scene.muscles.push_back(read_muscle(*table, folders, scene.size));
    refuse_duplicate(*table, names, scene.muscles.back().name);
  }
  for (TomlValue* table : tables_of(root, kFile["collider"])) {
    scene.colliders.push_back(read_collider(*table, folders));
    refuse_duplicate(*table, names, scene.colliders.back().name);
  }
  if (TomlValue* table = find(root, kFile["skin"])) read_skin(*table, folders, scene);
  if (TomlValue* table = find(root, kFile["solver"])) read_solver(*table, scene);
  if (TomlValue* table = find(root, kFile["contact"])) read_contact(*table, folders, scene);
  if (TomlValue* table = find(root, kFile["render"])) scene.render = read_render(*table);
  if (TomlValue* table = find(root, kFile["output"])) {
    scene.output.double_precision = read_word(*table, kOutput["precision"]) == "double";
  }
  for (TomlValue* table : tables_of(root, kFile["bound"])) read_bounds(*table, scene);
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
  list_old_names(root, scene.warnings);
  return scene;
}

SceneRender read_render(const fs::path& file, const std::vector<std::string>& overrides) {
  TomlValue root = read_toml(file);
  for (const std::string& setting : overrides) override_toml(root, setting);
  TomlValue& table = require(root, kFile["render"]);
  SceneRender render = read_render(table);
  render.has_rig = std::find(root.keys.begin(), root.keys.end(), "rig") != root.keys.end();
  refuse_unknown_keys(table);
  return render;
}

}  // namespace thew::sim
