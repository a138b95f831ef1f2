// SPDX-License-Identifier: Apache-2.0
//
// thew new: the template's muscles on another character, as a scene that its artist goes on with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "rig/character_import.h"
#include "rig/limits.h"
#include "rig/math.h"
#include "rig/mesh_import.h"
#include "rig/text.h"
#include "rig/urdf_import.h"
#include "sim/durable_file.h"
#include "sim/hash.h"
#include "sim/model.h"
#include "sim/scene.h"
#include "sim/scene_model.h"
#include "sim/scene_reader.h"
#include "tools/commands.h"
#include "tools/new_target.h"
#include "tools/obj_text.h"
#include "tools/options.h"
#include "tools/printing.h"
#include "tools/signals.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

// A person's, from the shoulder's centre to the elbow's (platform of adults' anatomy), m.
constexpr double kShortestHumerus = 0.25, kLongestHumerus = 0.40;

// A bone of the template as it lies at rest, in the world.
TriMesh bone_mesh(const Template& from, int body, const Skeleton::Visual& visual) {
  TriMesh mesh = import_closed_mesh(visual.mesh_file);
  for (Vec3& p : mesh.vertices) {
    p = from.rest[body] * (visual.in_body * Vec3(visual.scale.cwiseProduct(p)));
  }
  return mesh;
}

// Beside the program, where it was installed; else in the tree it was built from.
Template read_template() {
  Template of;
  of.scene = read_scene(own_asset("arm/arm.toml"));
  of.skeleton = import_urdf(of.scene.rig, of.scene.folder);
  forward_kinematics(of.skeleton, std::vector<double>(of.skeleton.size(), 0.0), of.rest);
  const auto place = [&](const char* body) {
    return Vec3(of.rest[find_body(of.skeleton, body)].translation());
  };
  of.humerus = place("humerus");
  of.arm.elbow = place("ulna") - of.humerus;
  of.arm.wrist = place("hand") - of.humerus;
  of.arm.elbow_axis = of.skeleton.joint_axes[find_body(of.skeleton, "ulna")];
  of.arm.skin = import_closed_mesh(of.scene.skin.mesh);
  std::vector<Vec3>& flesh = of.arm.flesh;
  const auto append = [&](const TriMesh& mesh) {
    flesh.insert(flesh.end(), mesh.vertices.begin(), mesh.vertices.end());
  };
  for (const SceneMuscle& muscle : of.scene.muscles) append(import_closed_mesh(muscle.mesh));
  for (const char* name : {"humerus", "ulna", "radius"}) {
    const int body = find_body(of.skeleton, name);
    for (const auto& visual : of.skeleton.visuals[body]) append(bone_mesh(of, body, visual));
  }
  for (Vec3& p : of.arm.skin.vertices) p -= of.humerus;
  for (Vec3& p : flesh) p -= of.humerus;
  return of;
}

// The template's anconeus fills what its own elbow leaves free; an elbow of other proportions
// pinches it.
constexpr std::array<const char*, 2> kMayOverlap[] = {{"anconeus", "humerus"},
                                                      {"anconeus", "triceps_lateral"}};

// Files of one arm, and its part of the scene.
struct Written {
  std::string rig, muscles, ignore, keys;
  std::vector<std::string> outside;  // muscles that stand out of the skin
  double fat = 1.0, volume = 0.0;    // m, the least over the muscles; m^3
  double thickness = 1e3;            // of the thinnest segment, over the template's
  double section = 1e3;              // of the thinnest section of a muscle, over the template's
  bool slender = false;              // whether any is, for its length
};

// Over the template's, of the upper arm and of the forearm.
std::array<double, 2> thickness_of(const Target& to) {
  const double elbow = to.from.arm.elbow.y(), wrist = to.fit.wrist_template.y();
  return {to.fit.girth.mean(-0.1, elbow + 0.05), to.fit.girth.mean(elbow - 0.05, wrist)};
}

// A character's forearm rolls in one piece; an arm's ulna does not.
std::string forearm_text(const Target& to) {
  const Transform into = to.rest[to.arm.forearm].inverse();
  const Vec3 head = to.mapped(to.from.rest[find_body(to.from.skeleton, "radius")].translation());
  return "forearm = { ulna = " + quoted(to.name_of(to.arm.ulna)) +
         ", radius = " + quoted(to.name_of(to.arm.radius)) + ", head = [" +
         metres(into * head, ", ") + "], wrist = [" +
         metres(into * to.rest[to.arm.hand].translation(), ", ") + "] }\n";
}

// m, from the middle of each ring of a tube (muscles/tube.h) to its nodes, in the mean.
std::vector<double> ring_radii(const TriMesh& tube) {
  const auto at_pole = [](const Triangle& t) { return t[0] == 0 || t[1] == 0 || t[2] == 0; };
  const size_t n = std::count_if(tube.triangles.begin(), tube.triangles.end(), at_pole);
  std::vector<double> radii;
  for (size_t first = 1; first + n < tube.vertices.size(); first += n) {
    const Vec3* x = &tube.vertices[first];
    const Vec3 middle = std::accumulate(x, x + n, Vec3(Vec3::Zero())) / n;
    double sum = 0.0;
    for (size_t k = 0; k < n; ++k) sum += (x[k] - middle).norm();
    radii.push_back(sum / n);
  }
  return radii;
}

// Over the same one of the template's.
double thinnest_section(const TriMesh& tube, const TriMesh& of_template) {
  const std::vector<double> radii = ring_radii(tube), before = ring_radii(of_template);
  double least = 1e3;
  for (size_t i = 0; i < radii.size(); ++i) least = std::min(least, radii[i] / before[i]);
  return least;
}

// Beside the scene of that name, for which its files are listed.
void write_arm(const Target& to, const fs::path& folder, const std::string& scene, Written& out) {
  const Template& from = to.from;
  const Transform world = Transform::Identity();
  for (int b = 0; b < from.skeleton.size(); ++b) {
    for (const Skeleton::Visual& visual : from.skeleton.visuals[b]) {
      const int body = to.body_of(b);
      const std::string name = from.skeleton.body_names[b] + "_" + to.side;
      const fs::path file = fs::path("bones") / (name + ".obj");
      write_durably(
          folder / file,
          obj_text(name + " in the frame of " + to.name_of(body) + ", metres; made by thew new",
                   mapped_mesh(to, bone_mesh(from, b, visual), to.rest[body].inverse()),
                   Vec3::Zero()),
          scene);
      out.rig += "[[rig.bone]]\nname = " + quoted(name) + "\nbody = " + quoted(to.name_of(body)) +
                 "\nmesh = " + quoted(file.string()) + "\n\n";
    }
  }
  for (const SceneMuscle& muscle : from.scene.muscles) {
    const std::string name = muscle.name + "_" + to.side;
    const fs::path file = fs::path("muscles") / (name + ".obj");
    const TriMesh before = import_closed_mesh(muscle.mesh);
    const TriMesh mesh = mapped_mesh(to, before, world);
    std::vector<Vec3> points = before.vertices;
    for (Vec3& p : points) p -= from.humerus;
    const double volume = enclosed_volume(mesh);
    const MappedSize size{volume, volume / enclosed_volume(before),
                          least_fat(to.fit, to.skin, points)};
    out.section = std::min(out.section, thinnest_section(mesh, before));
    if (size.fat < 0.0) out.outside.push_back(name);
    out.fat = std::min(out.fat, size.fat);
    out.volume += size.volume;
    write_durably(
        folder / file,
        obj_text(name + " at rest, in the world, metres; made by thew new", mesh, Vec3::Zero()),
        scene);
    out.muscles += muscle_text(to, muscle, name, file, size);
  }
  for (const auto& [a, b] : kMayOverlap) {
    out.ignore += (out.ignore.empty() ? "[" : ", [") + quoted(std::string(a) + "_" + to.side) +
                  ", " + quoted(std::string(b) + "_" + to.side) + "]";
  }
  Pose bind;
  forward_kinematics(to.character.skeleton, std::vector<double>(to.character.skeleton.size(), 0.0),
                     bind);
  const double degrees = to.fit.at_bind / kDegree;
  const std::string elbow = "elbow_" + to.side;
  out.rig +=
      "[[rig.hinge]]  # 0 is the straight arm in which the muscles are made\nname = " +
      quoted(elbow) + "\nbody = " + quoted(to.name_of(to.arm.forearm)) + "\naxis = [" +
      metres(bind[to.arm.forearm].linear().transpose() * to.fit.hinge_axis, ", ") +
      "]\nat_bind = " + number_text(degrees) +
      (to.fit.roll == 0.0
           ? ""
           : "\nroll = " + number_text(to.fit.roll / kDegree) +
                 "  # as its animations have it\nalong = [" +
                 metres(bind[to.arm.forearm].linear().transpose() * to.fit.along, ", ") + "]") +
      "\nrange = [0, 140]\n" + forearm_text(to) + "\n";
  const auto [upper, fore] = thickness_of(to);
  out.thickness = std::min({out.thickness, upper, fore});
  out.slender =
      out.slender || upper < kSlender * to.fit.along_upper || fore < kSlender * to.fit.along_fore;
  out.keys += (out.keys.empty() ? "" : ", ") + elbow + " = [[1, " + number_text(degrees) +
              "], [36, 120], [37, 120], [72, " + number_text(degrees) + "]]";
}

std::string clip_text(const Written& written, const Character& character) {
  std::string text = "[rig.clip]\nunit = \"deg\"\nkeys = { " + written.keys + " }\n";
  if (!character.animations.empty()) {
    text +=
        "# Or instead of unit and keys one of the character's own, or a BVH (file = \"x.bvh\"):\n";
  }
  for (const BodyClip& clip : character.animations) {
    text += "# animation = " + quoted(clip.name) + "  # " + number_text(clip.duration) + " s\n";
  }
  return text + "\n";
}

// Deeper in than a muscle is thick where it is thinnest, its node would be drawn out on the wrong
// side.
std::string contact_text(const ContactSettings& of_template, const Written& written) {
  const auto line = [&](const char* key, double of) {
    return std::string(key) + " = " + metres(of * written.thickness) + "\n";
  };
  char note[120];
  std::snprintf(note, sizeof note, "[contact]  # the template's, by the thinnest segment: %.2f\n",
                written.thickness);
  return note + line("margin", of_template.margin) +
         "max_depth = " + metres(of_template.max_depth * written.section) +
         "  # by the thinnest section\n" + line("gap", of_template.gap) +
         line("spacing", of_template.spacing) + "ignore = [" + written.ignore + "]\n\n";
}

// Within the reach of a person's skin there lie, in a slender arm, muscles of its other side: with
// them its skin would be drawn off it.
std::string skin_text(const Written& written) {
  const std::string text =
      "[skin]  # the character's own, with the muscles' displacement on top\nkind = \"skinned\"\n";
  if (!written.slender) return text + "\n";
  return text + "reach = " + metres(SkinSettings{}.reach * written.thickness) +
         "  # by the thinnest segment\n\n";
}

std::string scene_text(const std::string& name, const fs::path& character_file, double scale,
                       const Written& written, const std::string& clip, const std::string& contact,
                       const std::string& views) {
  return "# Twelve muscles an arm on " + character_file.filename().string() +
         ", made by `thew new`: metres, seconds, newtons. Yours to edit.\n[scene]\nname = " +
         quoted(name) +
         "\nfps = 24\nframes = \"1-72\"\nsettle = 2.0\ngravity = [0, -9.81, 0]\n\n[rig]\nfile = " +
         quoted(character_file.string()) + "\n" +
         (scale == 1.0 ? "" : "scale = " + number_text(scale) + "\n") + "\n" + written.rig + clip +
         written.muscles + skin_text(written) + contact + "[render]\nsize = [960, 540]\n\n" +
         views +
         "# As float32 writes it, some 1e-6 of a thin muscle a metre from the origin; with\n"
         "# [output] precision = \"double\" 1e-13 is met.\n[[bound]]\nvolume_error = 1e-5\n";
}

// What is there is replaced where it was made for this very scene and nobody has touched it since.
void claim_file(const fs::path& file, const std::string& scene, bool force) {
  claim({file}, force);
  const auto listed = own_file(file);
  if (force || !listed || !fs::exists(file)) return;
  const bool touched = fs::file_size(file) != listed->bytes ||
                       hash_of(read_whole_file(file, listed->bytes)) != listed->hash;
  if (listed->of == scene && !touched) return;
  throw Error(ExitCode::kOutput,
              file.string() + ": is there, " +
                  (touched ? "and edited since Thew wrote it" : "of another scene") +
                  "; write the scene into another folder, or replace it with --force");
}

// A scene reads nothing outside its folder: a character from elsewhere is copied beside it.
fs::path bring_character(const fs::path& file, const fs::path& folder, const std::string& scene,
                         bool force) {
  create_folders(folder);
  const fs::path real = fs::canonical(file), below = fs::canonical(folder);
  if (is_below(real, below)) return fs::relative(real, below);
  const fs::path copy = folder / file.filename();
  const std::string bytes = read_whole(real, size_t{256} << 20);
  if (!force && fs::is_regular_file(copy) && read_whole(copy, size_t{256} << 20) == bytes) {
    return file.filename();  // another scene's on the same character
  }
  claim_file(copy, scene, force);
  write_durably(copy, bytes, scene);
  return file.filename();
}

// Before any is written: bones and muscles by their names.
void claim_meshes(const Template& from, const std::vector<ArmBodies>& arms, const fs::path& folder,
                  const std::string& scene, bool force) {
  for (const char* below : {"bones", "muscles"}) claim_folder(folder / below);
  for (const ArmBodies& arm : arms) {
    const std::string end = std::string("_") + (arm.left ? "left" : "right") + ".obj";
    for (int b = 0; b < from.skeleton.size(); ++b) {
      if (from.skeleton.visuals[b].empty()) continue;
      claim_file(folder / "bones" / (from.skeleton.body_names[b] + end), scene, force);
    }
    for (const SceneMuscle& muscle : from.scene.muscles) {
      claim_file(folder / "muscles" / (muscle.name + end), scene, force);
    }
  }
}

// What is said of the scene: notes to standard output, warnings to standard error.
struct Said {
  std::vector<std::string> notes, warnings;

  void warn(const std::string& warning) {
    std::fprintf(stderr, "thew: warning: %s\n", warning.c_str());
    warnings.push_back(warning);
  }
};

template <typename... Values>
std::string format(const char* how, Values... values) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, how, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, how, values...);
  return text;
}

void say_fit(const Target& to, double scale, Said& said) {
  const Skeleton& skeleton = to.character.skeleton;
  const double length = to.fit.along_upper * to.from.arm.elbow.norm();
  const auto [upper, fore] = thickness_of(to);
  const std::vector<std::string>& names = skeleton.body_names;
  said.notes.push_back(to.side + " arm: clavicle " + names[to.arm.clavicle] + ", humerus " +
                       names[to.arm.humerus] + ", forearm " + names[to.arm.forearm] + ", hand " +
                       names[to.arm.hand]);
  said.notes.push_back(format(
      "  humerus %.3f m; of the template's: upper arm %.2f long, %.2f thick, forearm %.2f and "
      "%.2f; bent by %.1f deg in the bind pose",
      length, to.fit.along_upper, upper, to.fit.along_fore, fore, to.fit.at_bind / kDegree));
  if (to.fit.roll != 0.0) {
    said.notes.push_back(
        format("  its animations roll the forearm by %.0f deg from the bind pose: made so",
               to.fit.roll / kDegree));
  }
  for (const std::string& name : to.fit.wringing) {
    said.warn("animation \"" + name + "\" rolls the " + to.side +
              " forearm by more than the 80 deg that an arm's turns, and wrings the muscles on its "
              "radius; if a bake of it ends with exit 5 there, set contact.enabled=false");
  }
  if (length >= kShortestHumerus && length <= kLongestHumerus) return;
  said.warn(
      format("a humerus of %.3f m, that of an adult is 0.25 to 0.40; if the file's unit is "
             "not the metre, give --scale %.3g",
             length, scale * 0.32 / length));
}

void say_flesh(const Written& written, Said& said) {
  said.notes.push_back(format("muscles: %.1f cm3, %.1f mm or more under the skin at rest",
                              1e6 * written.volume, 1e3 * written.fat));
  if (written.outside.empty()) return;
  std::string names;
  for (const std::string& name : written.outside) names += (names.empty() ? "" : ", ") + name;
  said.warn("outside the skin at rest: " + names +
            "; the bones may not run within the skin: look at them, and at --map");
}

void tell(const NewOptions& options, size_t muscles, const Said& said) {
  if (options.json) {
    return print_json({{"scene", options.out.string()},
                       {"muscles", muscles},
                       {"notes", said.notes},
                       {"warnings", said.warnings}});
  }
  std::string text;
  for (const std::string& note : said.notes) text += note + "\n";
  print(text + options.out.string() + ": " + std::to_string(muscles) +
        " muscles; next: thew bake " + options.out.string() + " --out FOLDER\n");
}

// A scene that a bake would refuse is not written. It is read from beside its place, as its paths
// are relative.
void check_scene(const fs::path& character, const fs::path& out, const std::string& text) {
  const Temporary trial(out);
  replace_durably(trial.path, text);
  try {
    build_model(read_scene(trial.path));
  } catch (const Error& error) {
    std::string refusal = error.what();
    if (const size_t at = refusal.find(trial.path.string()); at != std::string::npos) {
      refusal.replace(at, trial.path.string().size(), out.string());
    }
    throw Error(ExitCode::kInput,
                character.string() + ": no scene that bakes comes of it (" + refusal +
                    "); name its bodies with --map, or give its unit with --scale");
  }
}

}  // namespace

ExitCode new_command(const NewOptions& options) {
  if (options.out.extension() != ".toml") {
    throw Error(ExitCode::kUsage,
                options.out.string() + ": a scene's name ends in .toml; give --out SCENE.toml");
  }
  if (fs::exists(options.out) && !options.force) {
    throw Error(ExitCode::kUsage, options.out.string() +
                                      ": exists already, and may have been edited; give another "
                                      "name, or --force to replace it");
  }
  if (!(options.scale >= kLeastScale && options.scale <= kMostScale)) {
    throw Error(ExitCode::kUsage,
                "--scale is " + number_text(options.scale) + "; give a number from 1e-6 to 1e6");
  }
  claim({options.out}, options.force);
  const Template from = read_template();
  if (!names_character(options.character)) {
    throw Error(ExitCode::kInput,
                options.character.string() + ": give a skinned character as glTF, FBX or Collada");
  }
  Character character = import_character(options.character, options.scale);
  Said said;
  for (const std::string& warning : character.warnings) {
    said.warn(warning);
  }
  std::vector<ArmBodies> arms =
      find_arms(character, options.side, options.map, options.character.string(), said.notes);
  std::vector<ArmFit> fits;
  for (const ArmBodies& arm : arms) fits.push_back(fit_arm(character, arm, from.arm));
  Pose rest = rest_pose_of(character, arms, fits);
  const TriMesh skin = skin_at_rest(character, rest);
  for (ArmFit& fit : fits) fit_girth(from.arm, skin, fit);
  for (ArmBodies& arm : arms) {
    for (int* bone : {&arm.ulna, &arm.radius}) {
      *bone = static_cast<int>(rest.size());
      rest.push_back(Transform(rest[arm.forearm]));
    }
  }

  const fs::path folder = fs::absolute(options.out).parent_path();
  const std::string scene = options.out.filename().string();
  const fs::path file = bring_character(options.character, folder, scene, options.force);
  claim_meshes(from, arms, folder, scene, options.force);
  Written written;
  std::optional<std::string> views;
  for (size_t i = 0; i < arms.size(); ++i) {
    const Target to{from, character, rest, skin, arms[i], fits[i], arms[i].left ? "left" : "right"};
    stop_if_interrupted();
    say_fit(to, options.scale, said);
    write_arm(to, folder, scene, written);
    if (!views) views = views_text(character, arms[i], fits[i], rest);
  }
  say_flesh(written, said);
  const std::string text = scene_text(options.out.stem().string(), file, options.scale, written,
                                      clip_text(written, character),
                                      contact_text(from.scene.contact.settings, written), *views);
  check_scene(options.character, options.out, text);
  write_durably(options.out, text, scene);
  tell(options, arms.size() * from.scene.muscles.size(), said);
  return ExitCode::kDone;
}

}  // namespace thew
