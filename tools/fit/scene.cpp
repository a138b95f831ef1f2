// SPDX-License-Identifier: Apache-2.0
//
// The scene that thew new writes: its bones, its muscles, its text.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

#include "rig/character_bones.h"
#include "rig/math.h"
#include "rig/text.h"
#include "tools/base/obj_text.h"
#include "tools/fit/target.h"

namespace thew::tools {

namespace fs = std::filesystem;

namespace {

// Of the template's muscles in proportion, a strong man's: adults have 0.5 to 1 of them. With 1 no
// room is left in the fold of an ordinary body's elbow for the skin, which leaps there.
constexpr double kMostMuscle = 0.85;
// Of the share of the room under the skin that the template's muscles take.
constexpr double kLeastFill = 2.0 / 3.0;

// A character's forearm rolls in one piece; an arm's ulna does not.
std::string forearm_text(const Target& to) {
  const Transform into = to.rest[to.arm.forearm].inverse();
  const Vec3 head = to.mapped(to.from.rest[find_body(to.from.skeleton, "radius")].translation());
  return "forearm = { ulna = " + quoted(to.name_of(to.arm.ulna)) +
         ", radius = " + quoted(to.name_of(to.arm.radius)) + ", head = [" +
         metres(into * head, ", ") + "], wrist = [" +
         metres(into * to.arm.wrist_in(to.rest), ", ") + "] }\n";
}

// m, from the middle of each ring of a tube to its nodes, in the mean.
std::vector<double> ring_radii(const TriMesh& tube) {
  std::vector<double> radii;
  for (const Ring& ring : rings_of(tube)) {
    const Vec3* x = &tube.vertices[ring.first];
    const Vec3 middle = std::accumulate(x, x + ring.nodes, Vec3(Vec3::Zero())) / ring.nodes;
    double sum = 0.0;
    for (int k = 0; k < ring.nodes; ++k) sum += (x[k] - middle).norm();
    radii.push_back(sum / ring.nodes);
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

}  // namespace

void append_mesh(const TriMesh& mesh, TriMesh& to) {
  const int first = static_cast<int>(to.vertices.size());
  to.vertices.insert(to.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
  for (const Triangle& t : mesh.triangles) {
    to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

std::vector<Ring> rings_of(const TriMesh& tube) {
  const auto at_pole = [](const Triangle& t) { return t[0] == 0 || t[1] == 0 || t[2] == 0; };
  const int nodes =
      static_cast<int>(std::count_if(tube.triangles.begin(), tube.triangles.end(), at_pole));
  std::vector<Ring> rings;
  for (int first = 1; first + nodes < static_cast<int>(tube.vertices.size()); first += nodes) {
    rings.push_back({first, nodes});
  }
  return rings;
}

// Over the template's, of the upper arm and of the forearm.
std::array<double, 2> thickness_of(const Target& to) {
  const double elbow = to.from.arm.elbow.y(), wrist = to.fit.wrist_template.y();
  const GirthField& girth = to.fit.girth;
  return {to.fit.across * girth.mean(-0.1, elbow + 0.05),
          to.fit.across * girth.mean(elbow - 0.05, wrist)};
}

namespace {

// Its table in the scene; `mesh` is in the rest pose.
std::string add_bone(const Target& to, const std::string& of_template, int body, TriMesh mesh,
                     NewArms& out) {
  const std::string name = of_template + "_" + to.side;
  for (Vec3& p : mesh.vertices) p = to.rest[body].inverse() * p;
  const fs::path file = fs::path("bones") / (name + ".obj");
  out.files.push_back(
      {file, name + " in the frame of " + to.name_of(body) + ", metres; made by thew new", mesh});
  return "[[rig.bone]]\nname = " + quoted(name) + "\nbody = " + quoted(to.name_of(body)) +
         "\nmesh = " + quoted(file.string()) + "\n\n";
}

// Each in a finger of the character's own; where it has none, all in one.
void add_hand(Target& to, std::vector<HandBone> hand, NewArms& out) {
  const std::vector<std::string>& names = to.from.skeleton.body_names;
  if (!(to.in_hand = fit_fingers(to, hand))) {
    for (size_t i = 1; i < hand.size(); ++i) append_mesh(hand[i].mesh, hand[0].mesh);
    hand.resize(1);
    if (!(to.in_hand = fit_hand(to, hand[0].mesh))) {
      if (to.arm.has_hand()) out.handless.push_back(to.side);
      return;
    }
  }
  for (const HandBone& bone : hand) {
    std::string& where = bone.of_template == hand[0].of_template ? out.rig : out.fingers;
    where += add_bone(to, names[bone.of_template], bone.body, bone.mesh, out);
  }
  out.hands += (out.hands.empty() ? "" : ", ") + quoted("hand_" + to.side);
}

void add_bones(Target& to, NewArms& out) {
  const Skeleton& skeleton = to.from.skeleton;
  const int wrist = find_body(skeleton, "hand");
  std::vector<HandBone> hand;
  for (int b = 0; b < skeleton.size(); ++b) {
    if (to.from.bones[b].triangles.empty()) continue;
    const TriMesh mesh = mapped_mesh(to, to.from.bones[b]);
    if (hangs_on(skeleton, b, wrist)) {
      hand.push_back({b, mesh, b == wrist ? to.arm.hand : -1});
    } else {
      out.rig += add_bone(to, skeleton.body_names[b], to.body_of(b), mesh, out);
    }
  }
  add_hand(to, std::move(hand), out);
}

bool reaches_hand(const Template& from, const SceneMuscle& muscle) {
  const int hand = find_body(from.skeleton, "hand");
  return std::any_of(muscle.path.begin(), muscle.path.end(), [&](const ScenePathPoint& point) {
    return hangs_on(from.skeleton, find_body(from.skeleton, point.body), hand);
  });
}

void add_muscles(const Target& arm, NewArms& out) {
  const Template& from = arm.from;
  Target forearm = arm;  // whose bones stay where they are
  forearm.in_hand = nullptr;
  double volume = 0.0, own_volume = 0.0;
  for (size_t m = 0; m < from.muscles.size(); ++m) {
    const SceneMuscle& muscle = from.scene.muscles[m];
    const Target& to = reaches_hand(from, muscle) ? arm : forearm;
    const std::string name = muscle.name + "_" + to.side;
    const fs::path file = fs::path("muscles") / (name + ".obj");
    const TriMesh& before = from.muscles[m];
    const TriMesh mesh = mapped_muscle(to, before);
    std::vector<Vec3> points = before.vertices;
    for (Vec3& p : points) p -= from.humerus;
    const double of_template = enclosed_volume(before);
    MappedSize size{enclosed_volume(mesh), 0.0, least_fat(to.fit, to.limb, to.body, points)};
    size.volume_ratio = size.volume / of_template;
    if (const std::string why = why_thread(to, mesh, size); !why.empty()) {
      out.threads.push_back(name + why);
    }
    out.section = std::min(out.section, thinnest_section(mesh, before));
    if (size.fat < 0.0) out.outside.push_back(name);
    out.fat = std::min(out.fat, size.fat);
    volume += size.volume;
    own_volume += of_template;
    out.files.push_back({file, name + " at rest, in the world, metres; made by thew new", mesh});
    out.muscles += muscle_text(to, muscle, name, file, size);
  }
  out.volume += volume;
  out.own_volume += own_volume;
  out.in_proportion += volume / std::pow(arm.fit.across, 3);
  out.fill = std::min(out.fill, volume / arm.fit.size.room / (own_volume / arm.fit.own_size.room));
}

std::string direction_text(const Vec3& v) { return "[" + metres(v, ", ") + "]"; }

// From where the arm hangs, as its muscles are made, to where it is bound.
std::string shoulder_text(const Target& to, const std::string& shoulder, double at_bind,
                          const Vec3& axis) {
  const auto& names = to.character.skeleton.body_names;
  const Mat3 into = to.rest[to.arm.scapula].linear().transpose();
  const Vec3 shaft =
      (to.fit.hang * to.fit.elbow - to.rest[to.arm.humerus].translation()).normalized();
  return "[[rig.hinge]]  # 0 is the hanging arm in which the muscles are made\nname = " +
         quoted(shoulder) + "\nbody = " + quoted(to.name_of(to.arm.humerus)) +
         "\naxis = " + direction_text(axis) + "\nat_bind = " + number_text(at_bind / kDegree) +
         "\nrange = [-180, 180]\nscapula = { body = " + quoted(to.name_of(to.arm.scapula)) +
         ", on = " + quoted(names[to.arm.clavicle]) +
         ", axis = " + direction_text(into * to.fit.upwards) +
         ", hanging = " + direction_text(into * shaft) + " }\n\n";
}

std::string hinge_text(const Target& to, const std::string& elbow) {
  Pose bind;
  forward_kinematics(to.character.skeleton, std::vector<double>(to.character.skeleton.size(), 0.0),
                     bind);
  const Mat3 into = bind[to.arm.forearm].linear().transpose();
  std::string text =
      "[[rig.hinge]]  # 0 is the straight arm in which the muscles are made\nname = " +
      quoted(elbow) + "\nbody = " + quoted(to.name_of(to.arm.forearm)) + "\naxis = [" +
      metres(into * to.fit.hinge_axis, ", ") +
      "]\nat_bind = " + number_text(to.fit.at_bind / kDegree) + "\n";
  if (to.fit.roll != 0.0) {
    text += "roll = " + number_text(to.fit.roll / kDegree) +
            "  # as its animations have it\nalong = [" + metres(into * to.fit.along, ", ") + "]\n";
  }
  return text + "range = [0, 140]\n" + forearm_text(to) + "\n";
}

}  // namespace

bool is_too_thick(const ArmFit& fit) {
  return kLeastFill * fit.size.room > kMostMuscle * std::pow(fit.across, 3) * fit.own_size.room;
}

void leave_fat(bool is_hard, Target& to) {
  double volume = 0.0, own = 0.0;
  for (const TriMesh& muscle : to.from.muscles) {
    volume += enclosed_volume(mapped_muscle(to, muscle));
    own += enclosed_volume(muscle);
  }
  const double most = is_hard ? 0.0 : kMostMuscle * own * std::pow(to.fit.across, 3);
  const double enough = std::max(most, kLeastFill * own / to.fit.own_size.room * to.fit.size.room);
  const double thinner = std::sqrt(enough / volume);
  if (!(thinner < 1.0)) return;
  for (double& ratio : to.fit.girth.ratio) ratio *= thinner;
}

void add_arm(Target& to, NewArms& out) {
  add_bones(to, out);
  add_muscles(to, out);
  out.lengths.push_back(to.fit.across);
  const std::string elbow = "elbow_" + to.side, shoulder = "shoulder_" + to.side;
  Pose bind;
  forward_kinematics(to.character.skeleton, std::vector<double>(to.character.skeleton.size(), 0.0),
                     bind);
  const Mat3 humerus = bind[to.arm.humerus].linear();
  const Eigen::AngleAxisd raised(
      Mat3(humerus.transpose() * to.fit.hang.linear().transpose() * humerus));
  out.rig += shoulder_text(to, shoulder, raised.angle(), raised.axis());
  out.rig += hinge_text(to, elbow);
  const auto [upper, fore] = thickness_of(to);
  out.thickness = std::min({out.thickness, upper, fore});
  out.slender =
      out.slender || upper < kSlender * to.fit.along_upper || fore < kSlender * to.fit.along_fore;
  const std::string degrees = number_text(to.fit.at_bind / kDegree);
  out.keys += (out.keys.empty() ? "" : ", ") + shoulder + " = [[1, " +
              number_text(raised.angle() / kDegree) + "]], " + elbow + " = [[1, " + degrees +
              "], [36, 120], [37, 120], [72, " + degrees + "]]";
}

namespace {

std::string clip_text(const NewArms& written, const Character& character) {
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
std::string contact_text(const ContactSettings& of_template, const NewArms& written) {
  const auto line = [&](const char* key, double of) {
    return std::string(key) + " = " + metres(of * written.thickness) + "\n";
  };
  char note[120];
  std::snprintf(note, sizeof note, "[contact]  # the template's, by the thinnest segment: %.2f\n",
                written.thickness);
  return note + line("margin", of_template.margin) +
         "max_depth = " + metres(of_template.max_depth * written.section) +
         "  # by the thinnest section\n" + line("gap", of_template.gap) +
         line("spacing", of_template.spacing) + "\n";
}

// Within the reach of a person's skin there lie, in a slender arm, muscles of its other side: with
// them its skin would be drawn off it.
std::string skin_text(const NewArms& written) {
  const std::string text =
      "[skin]  # the character's own, moved by the muscles\nkind = \"skinned\"\n" +
      (written.hands.empty() ? ""
                             : "ignore = [" + written.hands + "]  # fingers bend, it does not\n");
  if (!written.slender) return text + "\n";
  return text + "reach = " + metres(SkinSettings{}.reach * written.thickness) +
         "  # by the thinnest segment\n\n";
}

}  // namespace

double NewArms::size() const {
  return std::accumulate(lengths.begin(), lengths.end(), 0.0) / lengths.size();
}

std::string scene_text(const std::string& name, const fs::path& character_file, double scale,
                       const Character& character, const ContactSettings& contact,
                       const NewArms& arms, const std::string& views) {
  char size[80];
  std::snprintf(size, sizeof size, "size = %.3g  # of the template's arm, by its length\n",
                arms.size());
  return "# Twelve muscles an arm on " + character_file.filename().string() +
         ", made by `thew new`: metres, seconds, newtons. Yours to edit.\n[scene]\nname = " +
         quoted(name) + "\n" + size +
         "fps = 24\nframes = \"1-72\"\nsettle = 2.0\ngravity = [0, -9.81, 0]\n\n[rig]\nfile = " +
         quoted(character_file.string()) + "\n" +
         (scale == 1.0 ? "" : "scale = " + number_text(scale) + "\n") + "\n" + arms.rig +
         clip_text(arms, character) + arms.muscles + skin_text(arms) + contact_text(contact, arms) +
         arms.fingers + "[render]\nsize = [960, 720]\n\n" + views +
         "# As float32 writes it, some 1e-6 of a thin muscle a metre from the origin; with\n"
         "# [output] precision = \"double\" 1e-13 is met.\n[[bound]]\nvolume_error = 1e-5\n";
}

}  // namespace thew::tools
