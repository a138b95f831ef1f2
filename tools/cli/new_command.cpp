// SPDX-License-Identifier: Apache-2.0
//
// thew new: the template's muscles on another character, as a scene that its artist goes on with.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>

#include "rig/import/character_import.h"
#include "rig/import/mesh_import.h"
#include "rig/import/urdf_import.h"
#include "rig/limits.h"
#include "rig/math.h"
#include "rig/text.h"
#include "sim/cache/durable_file.h"
#include "sim/cache/hash.h"
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "sim/scene/reader.h"
#include "sim/scene/scene.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "tools/base/obj_text.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/signals.h"
#include "tools/cli/commands.h"
#include "tools/fit/scale.h"
#include "tools/fit/target.h"
#include "tools/fit/worn.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

// Beside the program, where it was installed; else in the tree it was built from.
Template read_template() {
  const SharedReader reader;
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
  for (const SceneMuscle& muscle : of.scene.muscles) {
    of.muscles.push_back(import_closed_mesh(muscle.mesh));
    append(of.muscles.back());
  }
  of.bones.resize(of.skeleton.size());
  for (int b = 0; b < of.skeleton.size(); ++b) {
    for (const Skeleton::Visual& visual : of.skeleton.visuals[b]) {
      TriMesh mesh = import_bone(visual.mesh_file);
      for (Vec3& p : mesh.vertices) {
        p = of.rest[b] * (visual.in_body * Vec3(visual.scale.cwiseProduct(p)));
      }
      append_mesh(mesh, of.bones[b]);
    }
  }
  for (const char* name : {"humerus", "ulna", "radius"}) {
    append(of.bones[find_body(of.skeleton, name)]);
  }
  for (Vec3& p : of.arm.skin.vertices) p -= of.humerus;
  for (Vec3& p : flesh) p -= of.humerus;
  return of;
}

// What is there is replaced where it was made for this very scene and nobody has touched it since.
void claim_file(const fs::path& file, const std::string& scene, bool force) {
  claim({file}, force);
  const auto listed = own_file(file);
  if (force || !listed || !fs::exists(file)) return;
  const bool touched = fs::file_size(file) != listed->bytes ||
                       hash_of(read_whole_file(file, listed->bytes)) != listed->hash;
  if (listed->of == scene && !touched) return;
  throw Error(ErrorCode::kOutput,
              file.string() + ": is there, " +
                  (touched ? "and edited since Thew wrote it" : "of another scene") +
                  "; write the scene into another folder, or replace it with --force");
}

// What is there with the same bytes, another scene's on the same character, stays.
void bring_file(const fs::path& from, const fs::path& copy, const std::string& scene, bool force) {
  constexpr size_t kLimit = size_t{256} << 20;  // bytes
  const std::string bytes = read_whole(from, kLimit);
  if (!force && fs::is_regular_file(copy) && read_whole(copy, kLimit) == bytes) return;
  claim_file(copy, scene, force);
  write_durably(copy, bytes, scene);
}

// A scene reads nothing outside its folder: a character from elsewhere is copied beside it, with
// what a glTF keeps in files of its own.
fs::path bring_character(const Character& character, const fs::path& file, const fs::path& folder,
                         const std::string& scene, bool force) {
  create_folders(folder);
  const fs::path real = fs::canonical(file), below = fs::canonical(folder);
  if (is_below(real, below)) return fs::relative(real, below);
  for (const std::string& name : character.files) {
    std::error_code none;  // what cannot be reached is not read either
    const fs::path part = fs::canonical(real.parent_path() / name, none);
    if (!fs::is_regular_file(part, none) || !is_below(part, real.parent_path())) continue;
    const fs::path copy = folder / fs::relative(part, real.parent_path());
    create_folders(copy.parent_path());
    bring_file(part, copy, scene, force);
  }
  bring_file(real, folder / file.filename(), scene, force);
  return file.filename();
}

// Before any is written: bones and muscles by their names.
void claim_meshes(const Template& from, const std::vector<ArmBodies>& arms, const fs::path& folder,
                  const std::string& scene, bool force) {
  for (const char* below : {"bones", "muscles"}) claim_folder(folder / below);
  for (const ArmBodies& arm : arms) {
    const std::string end = std::string("_") + (arm.left ? "left" : "right") + ".obj";
    for (int b = 0; b < from.skeleton.size(); ++b) {
      if (from.bones[b].triangles.empty()) continue;
      claim_file(folder / "bones" / (from.skeleton.body_names[b] + end), scene, force);
    }
    for (const SceneMuscle& muscle : from.scene.muscles) {
      claim_file(folder / "muscles" / (muscle.name + end), scene, force);
    }
  }
}

// What is said of the scene.
struct Said {
  std::vector<std::string> notes, warnings;
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();  // for programs
  const std::function<void(const std::string&)>& on_warning;

  void warn(const std::string& warning) {
    on_warning(warning);
    warnings.push_back(warning);
  }
};

template <typename... Values>
std::string format(const char* how, Values... values) {
  std::string text(static_cast<size_t>(std::snprintf(nullptr, 0, how, values...)), '\0');
  std::snprintf(text.data(), text.size() + 1, how, values...);
  return text;
}

void say_fit(const Target& to, Said& said) {
  constexpr double kBeside = 0.008;  // m, of an arm of the template's size, of any that lies within
  const Skeleton& skeleton = to.character.skeleton;
  const double length = to.fit.along_upper * to.from.arm.elbow.norm();
  const auto [upper, fore] = thickness_of(to);
  const std::vector<std::string>& names = skeleton.body_names;
  said.notes.push_back(to.side + " arm: clavicle " + names[to.arm.clavicle] + ", humerus " +
                       names[to.arm.humerus] + ", forearm " + names[to.arm.forearm] + ", hand " +
                       (to.arm.has_hand() ? names[to.arm.hand] : "none"));
  said.notes.push_back(format(
      "  humerus %.3f m; of the template's: upper arm %.2f long, %.2f thick, forearm %.2f and "
      "%.2f; bent by %.1f deg in the bind pose",
      length, to.fit.along_upper, upper, to.fit.along_fore, fore, to.fit.at_bind / kDegree));
  said.figures["arms"].push_back({{"side", to.side},
                                  {"clavicle", names[to.arm.clavicle]},
                                  {"humerus", names[to.arm.humerus]},
                                  {"forearm", names[to.arm.forearm]},
                                  {"hand", to.arm.has_hand() ? names[to.arm.hand] : ""},
                                  {"humerus_m", length},
                                  {"upper_arm_girth_m", to.fit.size.upper_girth},
                                  {"forearm_girth_m", to.fit.size.fore_girth}});
  said.notes.push_back(
      format("  girth %.1f cm about the middle of the upper arm, %.1f about the forearm",
             1e2 * to.fit.size.upper_girth, 1e2 * to.fit.size.fore_girth));
  if (to.fit.roll != 0.0) {
    said.notes.push_back(
        format("  its animations roll the forearm by %.0f deg from the bind pose: made so",
               to.fit.roll / kDegree));
  }
  constexpr double kLeft = 0.2;  // of the skin there; a hand beside the thigh has some around it
  int most = -1;
  if (const double left = skin_left_behind(to.character, to.arm, most); left > kLeft) {
    said.warn(
        format("%.0f %% of the skin around the %s forearm and hand hangs on bodies that they "
               "do not carry, \"%s\" first: it stays behind as the elbow bends",
               1e2 * left, to.side.c_str(), names[most].c_str()));
  }
  for (const std::string& name : to.fit.wringing) {
    said.warn("animation \"" + name + "\" rolls the " + to.side +
              " forearm by more than the 80 deg that an arm's turns, and wrings the muscles on its "
              "radius");
  }
  const double beside = to.fit.girth.shift_at(to.fit.elbow_template.y()).norm();
  if (beside > kBeside * to.fit.across) {
    said.warn(
        format("the %s elbow lies in its own skin or outside of it, and its muscles and bones "
               "%.0f mm beside it: they part from one another where it bends; a joint in the "
               "middle of the flesh keeps them together",
               to.side.c_str(), 1e3 * beside));
  }
}

void say_flesh(const NewArms& written, Said& said) {
  said.figures["size"] = written.size();
  said.figures["volume_m3"] = written.volume;
  said.figures["volume_in_proportion_m3"] = written.in_proportion;
  said.figures["room_filled"] = written.fill;
  said.notes.push_back(format(
      "muscles: %.1f cm3, %.1f mm or more under the skin at rest; in proportion %.0f cm3, of "
      "the template's %.0f; of the room under the skin %.2f of what the template's take",
      1e6 * written.volume, 1e3 * written.fat, 1e6 * written.in_proportion,
      1e6 * written.own_volume, written.fill));
  for (const std::string& side : written.handless) {
    said.notes.push_back(side + " hand: no room for bones in it, left out");
  }
  if (written.outside.empty()) return;
  std::string names;
  for (const std::string& name : written.outside) names += (names.empty() ? "" : ", ") + name;
  said.warn("outside the skin at rest: " + names +
            "; the bones may not run within the skin: look at them, and at --map");
}

nlohmann::ordered_json told(const NewOptions& options, size_t muscles, const Said& said) {
  nlohmann::ordered_json json = {{"scene", options.out.string()},
                                 {"muscles", muscles},
                                 {"notes", said.notes},
                                 {"warnings", said.warnings}};
  json.update(said.figures);
  return json;
}

// For people.
std::string as_text(const nlohmann::ordered_json& told) {
  std::string text;
  for (const auto& note : told["notes"]) text += note.get<std::string>() + "\n";
  const auto scene = told["scene"].get<std::string>();
  return text + scene + ": " + std::to_string(told["muscles"].get<size_t>()) +
         " muscles; next: thew bake " + scene + " --out FOLDER\n";
}

std::string why_threads(const std::vector<std::string>& threads) {
  const size_t others = threads.size() - 1;
  return "too thin for muscles: " + threads[0] +
         (others == 0 ? "" : ", and so are " + std::to_string(others) + " more");
}

// With a picture beside the scene's place.
[[noreturn]] void refuse(const NewOptions& options, const Character& character,
                         const ArmTemplate& from, const ArmFit& fit, const TriMesh& skin,
                         const std::string& why) {
  const fs::path folder = fs::absolute(options.out).parent_path();
  fs::path picture = options.out;
  picture.replace_extension(".why.svg");
  create_folders(folder);
  claim_file(picture, options.out.filename().string(), options.force);
  write_durably(picture, why_picture(from, fit, skin, why), options.out.filename().string());
  const std::vector<std::string> meshes = mesh_names(character);
  throw Error(ErrorCode::kInput,
              options.character.string() + ": " + why + "; " + picture.string() +
                  " shows it: choose the meshes around the arm with --skin (" +
                  (meshes.empty() ? "the file has none" : "of " + names_text(meshes)) +
                  "), or its bodies with --map");
}

// A scene that a bake would refuse, or whose muscles come to no rest, is not written. It is read
// from beside its place, as its paths are relative.
void check_scene(const fs::path& character, const fs::path& out, const std::string& text,
                 Said& said) {
  // Of the muscles' frames. Arms that lie in each other took 0.08 (a wrong humerus); limbs of odd
  // shape that settle well all the same, 0.01.
  constexpr double kMostRungs = 0.05;
  const Temporary trial(out);
  replace_durably(trial.path, text);
  try {
    // The skin moves no muscle, refuses nothing that is not refused here before, and would take
    // most of the time.
    const Model model = build_model(read_scene(trial.path, {"skin.enabled=false"}));
    Parallel parallel(1);
    State state = initial_state(model);
    int rungs = 0;
    const double all = model.settle * model.fps * static_cast<double>(model.muscles.size());
    settle(model, parallel, state, [&] {
      rungs += muscles_on_rungs(state);
      if (rungs <= kMostRungs * all) return;
      throw Error(ErrorCode::kInput, "while settling, more than " +
                                         std::to_string(std::lround(1e2 * kMostRungs)) +
                                         " % of the muscles' frames cannot be solved");
    });
    if (rungs > 0) {
      said.warn(std::to_string(rungs) + " frames of a muscle could not be solved while settling");
    }
  } catch (const Error& error) {
    std::string refusal = error.what();
    if (const size_t at = refusal.find(trial.path.string()); at != std::string::npos) {
      refusal.replace(at, trial.path.string().size(), out.string());
    }
    for (size_t at; (at = refusal.find("\n  ")) != std::string::npos;) refusal.replace(at, 3, "; ");
    throw Error(ErrorCode::kInput,
                character.string() + ": no scene that bakes comes of it (" + refusal +
                    "); name its bodies with --map, or give its unit with --scale");
  }
}

// A body in the trunk's middle is no upper arm; muscles on two such arms would lie in each other.
void check_apart(const Character& character, const std::vector<ArmBodies>& arms,
                 const std::vector<ArmFit>& fits, const std::string& place) {
  if (arms.size() < 2) return;
  const auto shoulder = [&](size_t i) {
    return Vec3(character.bind[arms[i].humerus].translation());
  };
  const double apart = (shoulder(0) - shoulder(1)).norm();
  if (apart > kShouldersApart * (fits[0].elbow - shoulder(0)).norm()) return;
  const std::vector<std::string>& names = character.skeleton.body_names;
  throw Error(ErrorCode::kUsage, place + ": the upper arms \"" + names[arms[0].humerus] +
                                     "\" and \"" + names[arms[1].humerus] +
                                     "\" begin in one place; name others with --map");
}

void check_options(const NewOptions& options) {
  if (options.out.extension() != ".toml") {
    throw Error(ErrorCode::kUsage,
                options.out.string() + ": a scene's name ends in .toml; give --out SCENE.toml");
  }
  if (fs::exists(options.out) && !options.force) {
    throw Error(ErrorCode::kUsage, options.out.string() +
                                       ": exists already, and may have been edited; give another "
                                       "name, or --force to replace it");
  }
  if (options.scale && !(*options.scale >= kMinScale && *options.scale <= kMaxScale)) {
    throw Error(ErrorCode::kUsage,
                "--scale is " + number_text(*options.scale) + "; give a number from 1e-6 to 1e6");
  }
}

}  // namespace

nlohmann::ordered_json new_scene(const NewOptions& options,
                                 const std::function<void(const std::string&)>& on_warning) {
  check_options(options);
  claim({options.out}, options.force);
  const Template from = read_template();
  if (!names_character(options.character)) {
    throw Error(ErrorCode::kInput, options.character.string() +
                                       ": give a skinned character as glTF, VRM, FBX or Collada");
  }
  Said said{{}, {}, nlohmann::ordered_json::object(), on_warning};
  double scale = 1.0;
  std::vector<ArmBodies> arms;
  std::vector<std::string> warnings;
  const Character character = read_in_metres(options, scale, arms, said.notes, warnings);
  for (const std::string& warning : warnings) said.warn(warning);
  std::vector<ArmFit> fits;
  for (const ArmBodies& arm : arms) fits.push_back(fit_arm(character, arm, from.arm));
  check_apart(character, arms, fits, options.character.string());
  Pose straight = straight_pose(character, arms, fits);
  const Points x = skin_in_pose(character, straight);
  for (ArmBodies& arm : arms) {
    for (int* bone : {&arm.ulna, &arm.radius, &arm.scapula}) {
      *bone = static_cast<int>(straight.size());
      straight.push_back(Transform(straight[bone == &arm.scapula ? arm.clavicle : arm.forearm]));
    }
  }
  const Pose rest = hanging_pose(character, straight, arms, fits);
  const TriMesh whole = skin_around(character, {0}, options.skin, x, options.character.string());
  NewArms written;
  for (size_t i = 0; i < arms.size(); ++i) {
    stop_if_interrupted();
    const auto around = [&](const std::vector<int>& bodies) {
      return skin_around(character, bodies, options.skin, x, options.character.string());
    };
    const TriMesh skin = around({arms[i].humerus}), hand = around(hand_bodies(character, arms[i]));
    const OwnSkin own = fit_own_skin(from.arm, skin, whole, fits[i]);
    const Limb limb(own.limb), body(own.body);
    const std::string side = arms[i].left ? "left" : "right";
    if (const std::string why = why_no_arm(fits[i], side); !why.empty()) {
      refuse(options, character, from.arm, fits[i], skin, why);
    }
    Target to{from, character, straight, rest, limb, body, hand, arms[i], fits[i], side};
    leave_fat(is_hard(whole, own.limb, fits[i]), to);
    say_fit(to, said);
    add_arm(to, written);
    if (!written.threads.empty()) {
      refuse(options, character, from.arm, fits[i], skin, why_threads(written.threads));
    }
  }
  say_flesh(written, said);

  const fs::path folder = fs::absolute(options.out).parent_path();
  const std::string scene = options.out.filename().string();
  const fs::path file = bring_character(character, options.character, folder, scene, options.force);
  claim_meshes(from, arms, folder, scene, options.force);
  for (const NewFile& one : written.files) {
    write_durably(folder / one.file, obj_text(one.heading, one.mesh, Vec3::Zero()), scene);
  }
  const std::string text =
      scene_text(options.out.stem().string(), file, scale, character, from.scene.contact.settings,
                 written, views_text(character, arms, fits));
  check_scene(options.character, options.out, text, said);
  write_durably(options.out, text, scene);
  return told(options, arms.size() * from.scene.muscles.size(), said);
}

ExitCode new_command(const NewOptions& options) {
  const nlohmann::ordered_json told = new_scene(options, [](const std::string& warning) {
    std::fprintf(stderr, "thew: warning: %s\n", warning.c_str());
  });
  if (options.json) {
    print_json(told);
  } else {
    print(as_text(told));
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
