// SPDX-License-Identifier: Apache-2.0
#include "tools/author/files.h"

#include <string>

#include "rig/math.h"
#include "rig/text.h"
#include "sim/cache/durable_file.h"
#include "tools/author/bones.h"
#include "tools/author/packing.h"
#include "tools/author/skin.h"
#include "tools/author/table.h"
#include "tools/base/obj_text.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMadeBy = ", metres; made by author_arm, Apache-2.0";
constexpr double kSkinClearance = 0.0029;  // m; the scene asks for 2 mm

std::string urdf_text(const Skeleton& skeleton) {
  std::string text =
      "<?xml version=\"1.0\"?>\n"
      "<!-- Right arm: joints of Holzbaur, Murray, Delp 2005 (arm26, myo_sim); metres, radians.\n"
      "     Made by author_arm. -->\n<robot name=\"arm\">\n";
  for (int i = 0; i < skeleton.size(); ++i) {
    const std::string& body = skeleton.body_names[i];
    text += "  <link name=\"" + body + "\">\n    <visual><geometry><mesh filename=\"bones/" + body +
            ".obj\"/></geometry></visual>\n  </link>\n";
    if (skeleton.parent[i] < 0) continue;
    text += "  <joint name=\"" + skeleton.joint_names[i] + "\" type=\"revolute\">\n" +
            "    <parent link=\"" + skeleton.body_names[skeleton.parent[i]] + "\"/>\n" +
            "    <child link=\"" + body + "\"/>\n    <origin xyz=\"" +
            metres(skeleton.joint_in_parent[i].translation(), " ") + "\"/>\n    <axis xyz=\"" +
            metres(skeleton.joint_axes[i], " ") + "\"/>\n    <limit lower=\"" +
            metres(skeleton.lower[i]) + "\" upper=\"" + metres(skeleton.upper[i]) +
            "\" effort=\"100\" velocity=\"10\"/>\n  </joint>\n";
  }
  return text + "</robot>\n";
}

std::string muscle_text(const TableMuscle& muscle, const Skeleton& skeleton) {
  const auto name_of = [&](int body) { return skeleton.body_names[body]; };
  std::string text = "[[muscle]]\nname = \"" + muscle.name + "\"\nmesh = \"muscles/" + muscle.name +
                     ".obj\"\n" + points_text(muscle.path.points, name_of) +
                     wraps_text(muscle.path.wraps, name_of);
  text += "belly = [" + metres(muscle.belly[0]) + ", " + metres(muscle.belly[1]) + "]\n";
  if (muscle.twist_from > 0.0) text += "twist_from = " + metres(muscle.twist_from) + "\n";
  return text + "weights = " + weights_text(muscle.weights.keys) +
         "\nf_max = " + metres(muscle.f_max) + "\nfibre_length = " + metres(muscle.fibre_length) +
         "\n";
}

// The scenes beside the table are ours but for what stands between these two lines, of which the
// activations are.
constexpr const char* kFirstLine = "# Muscles, written by author_arm from muscles.csv:\n";
constexpr const char* kLastLine = "# end of muscles\n";

// The line of a scene that gives a muscle's activation, or nothing.
std::string activation_line(const std::string& scene, const std::string& muscle) {
  const std::string key = "\nactivation = ";
  const size_t from = scene.find("\nname = \"" + muscle + "\"\n");
  const size_t at = scene.find(key, from);
  if (from == std::string::npos || at == std::string::npos || at > scene.find("\n\n", from)) {
    return "";
  }
  return scene.substr(at + 1, scene.find('\n', at + 1) - at);
}

std::string scene_text(const fs::path& scene, const std::vector<TableMuscle>& muscles,
                       const Skeleton& skeleton) {
  const std::string text = read_whole(scene, 1 << 20);
  const size_t first = text.find(kFirstLine), last = text.find(kLastLine);
  if (first == std::string::npos || last == std::string::npos || last < first) {
    throw Error(ErrorCode::kInput, scene.string() + ": the lines \"" + kFirstLine + "\" and \"" +
                                       kLastLine + "\" are not in it; add them");
  }
  std::string blocks;
  for (const TableMuscle& muscle : muscles) {
    blocks += muscle_text(muscle, skeleton) + activation_line(text, muscle.name) + "\n";
  }
  return text.substr(0, first) + kFirstLine + "\n" + blocks + text.substr(last);
}

}  // namespace

void write_arm(const fs::path& table, const fs::path& folder) {
  const Skeleton skeleton = arm_skeleton();
  const Pose rest = rest_pose(skeleton);
  const std::vector<TableMuscle> muscles = read_muscle_table(table, skeleton);
  const std::vector<BoneShape> bones = arm_bones();
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();

  std::vector<TriMesh> below;
  fs::create_directories(folder / "muscles");
  fs::create_directories(folder / "bones");
  for (const BoneShape& bone : bones) {
    const Vec3 shift = humerus - rest[find_body(skeleton, bone.body)].translation();
    below.push_back(bone_mesh(bone));
    replace_durably(
        folder / "bones" / (bone.body + ".obj"),
        obj_text(bone.body + " in its own frame" + kMadeBy, in_order_of_use(below.back()), shift));
  }
  const std::vector<TriMesh> meshes = pack_muscles(muscles, skeleton, bones);
  for (size_t m = 0; m < muscles.size(); ++m) {
    const std::string& name = muscles[m].name;
    replace_durably(
        folder / "muscles" / (name + ".obj"),
        obj_text(name + " at rest in the root's frame" + std::string(kMadeBy), meshes[m], humerus));
  }
  below.insert(below.end(), meshes.begin(), meshes.end());
  replace_durably(folder / "skin.obj",
                  obj_text("skin at rest in the root's frame" + std::string(kMadeBy),
                           arm_skin(below, kSkinClearance), humerus));
  replace_durably(folder / "arm.urdf", urdf_text(skeleton));
  for (const char* scene : {"arm.toml", "curl.toml", "turn.toml", "reach.toml", "still.toml"}) {
    replace_durably(folder / scene, scene_text(table.parent_path() / scene, muscles, skeleton));
  }
}

}  // namespace thew::tools
