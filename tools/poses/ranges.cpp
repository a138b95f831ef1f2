// SPDX-License-Identifier: Apache-2.0
#include "tools/poses/ranges.h"

#include <algorithm>
#include <random>

#include "rig/math.h"
#include "rig/text.h"
#include "sim/scene/values.h"
#include "tools/base/options.h"

namespace thew::tools {
namespace {

using sim::Key;
using sim::KeyType;

constexpr int kMostPoses = 100000;
constexpr sim::Key kKeys[] = {
    {.name = "scene", .type = KeyType::kText, .meaning = "", .need = sim::Need::kRequired},
    {.name = "unit", .type = KeyType::kWord, .meaning = "", .words = {"deg", "rad"}},
    {.name = "joints", .type = KeyType::kTable, .meaning = ""},
    {.name = "grid", .type = KeyType::kTable, .meaning = ""},
    {.name = "random", .type = KeyType::kInteger, .meaning = "", .range = {0, kMostPoses}},
    {.name = "seed", .type = KeyType::kInteger, .meaning = "", .range = {0, 1000000000}},
    {.name = "frames", .type = KeyType::kText, .meaning = ""}};
constexpr sim::Section kRanges{"", "", "", kKeys};
constexpr sim::Range kValue = {-1e4, 1e4};

[[noreturn]] void refuse_poses(const std::string& what) { throw Error(ErrorCode::kUsage, what); }

PoseRanges::Joint* find_joint(PoseRanges& ranges, const std::string& name) {
  const auto found = std::find_if(ranges.joints.begin(), ranges.joints.end(),
                                  [&](const auto& joint) { return joint.name == name; });
  return found == ranges.joints.end() ? nullptr : &*found;
}

void add_grid(const PoseRanges& ranges, const std::vector<int>& place,
              std::vector<std::vector<double>>& poses, const std::vector<double>& rest) {
  double count = 1.0;
  for (const auto& joint : ranges.joints) count *= joint.grid;
  if (count > kMostPoses) refuse_poses("the grid has more than 100,000 poses; give fewer values");
  for (int k = 0; k < static_cast<int>(count); ++k) {
    std::vector<double> pose = rest;
    int left = k;
    for (size_t j = ranges.joints.size(); j-- > 0;) {
      const auto& [low, high] = ranges.joints[j].range;
      const int n = ranges.joints[j].grid, i = left % n;
      left /= n;
      pose[place[j]] = n == 1 ? 0.0 : low + (high - low) * i / (n - 1);
    }
    poses.push_back(std::move(pose));
  }
}

void stand_alone(sim::Scene& scene) {
  scene.solver.integrator = "quasi_static";
  scene.solver.tolerance.reset();
  for (sim::SceneMuscle& muscle : scene.muscles) {
    muscle.activation.clear();                            // keyed by frames
    if (muscle.by_joint) muscle.by_joint->speed.clear();  // a pose has none
  }
}

}  // namespace

PoseRanges read_ranges(const std::filesystem::path& file) {
  sim::TomlValue root = sim::read_toml(file);
  PoseRanges ranges;
  ranges.scene = file.parent_path() / text_of(require(root, kRanges["scene"]));
  const double unit = read_word(root, kRanges["unit"]) == "deg" ? kDegree : 1.0;
  read(root, kRanges["random"], ranges.random);
  read(root, kRanges["seed"], ranges.seed);
  if (const sim::TomlValue* frames = find(root, kRanges["frames"])) {
    ranges.frames = text_of(*frames);
  }
  if (sim::TomlValue* joints = find(root, kRanges["joints"])) {
    sim::TomlValue& table = entries_of(*joints);
    for (size_t j = 0; j < table.items.size(); ++j) {
      PoseRanges::Joint joint{table.keys[j], table.items[j].location};
      const auto& ends = items_of(table.items[j], "a range, [lowest, highest]", 2, 2);
      for (int k = 0; k < 2; ++k) joint.range[k] = unit * number_of(ends[k], kValue);
      if (joint.range[1] < joint.range[0]) refuse(ends[1], "give no less than the first");
      ranges.joints.push_back(joint);
    }
  }
  if (sim::TomlValue* grid = find(root, kRanges["grid"])) {
    ranges.has_grid = true;
    sim::TomlValue& table = entries_of(*grid);
    for (size_t j = 0; j < table.items.size(); ++j) {
      PoseRanges::Joint* joint = find_joint(ranges, table.keys[j]);
      if (!joint) refuse(table.items[j], "give " + table.keys[j] + " a range in [joints] as well");
      joint->grid = integer_of(table.items[j], {1, kMostPoses});
    }
  }
  refuse_unknown_keys(root);
  return ranges;
}

std::vector<int> moving_joints(const rig::Skeleton& skeleton) {
  std::vector<int> bodies;
  for (int b = 0; b < skeleton.size(); ++b) {
    if (skeleton.joint_types[b] != rig::Skeleton::JointType::kFixed) bodies.push_back(b);
  }
  return bodies;
}

std::vector<std::vector<double>> sample_poses(const PoseRanges& ranges,
                                              const rig::Skeleton& skeleton,
                                              const sim::Scene& scene) {
  const std::vector<int> moving = moving_joints(skeleton);
  std::vector<std::string> names;
  for (const int body : moving) names.push_back(skeleton.joint_names[body]);
  std::vector<int> place;  // of each given joint in a pose
  for (const PoseRanges::Joint& joint : ranges.joints) {
    const auto found = std::find(names.begin(), names.end(), joint.name);
    if (found == names.end()) {
      refuse_poses(joint.location + ": the rig has no joint \"" + joint.name + "\"" +
                   rig::did_you_mean(joint.name, names));
    }
    place.push_back(static_cast<int>(found - names.begin()));
  }
  std::vector<std::vector<double>> poses;
  const std::vector<double> rest(moving.size(), 0.0);
  if (ranges.has_grid) add_grid(ranges, place, poses, rest);
  std::mt19937 random(static_cast<unsigned>(ranges.seed));
  for (int k = 0; k < ranges.random; ++k) {
    poses.push_back(rest);
    for (size_t j = 0; j < place.size(); ++j) {
      const auto& [low, high] = ranges.joints[j].range;
      poses.back()[place[j]] = low + (high - low) * (random() / 4294967296.0);
    }
  }
  if (!ranges.frames.empty()) {
    std::vector<double> joints;
    for (const int frame : parse_frames(ranges.frames, scene.first_frame, scene.last_frame)) {
      sample_clip(scene.clip, skeleton, (frame - scene.first_frame) / scene.fps, joints);
      poses.emplace_back();
      for (const int body : moving) poses.back().push_back(joints[body]);
    }
  }
  if (poses.empty()) refuse_poses("no pose is asked for; give random, grid or frames");
  return poses;
}

bool moves_all_bodies(const sim::Scene& scene) {
  return !scene.character.animation.empty() || !scene.character.motion.empty();
}

std::vector<int> take_frames(const PoseRanges& ranges, sim::Scene& scene) {
  if (ranges.has_grid || ranges.random > 0 || !ranges.joints.empty()) {
    refuse_poses(
        scene.clip_location +
        ": an animation moves all bodies, and its poses are its frames; give frames alone, "
        "or the scene keys in its place");
  }
  if (ranges.frames.empty()) refuse_poses("no pose is asked for; give frames of the animation");
  stand_alone(scene);
  return parse_frames(ranges.frames, scene.first_frame, scene.last_frame);
}

void set_poses(const std::vector<std::vector<double>>& poses, const rig::Skeleton& skeleton,
               sim::Scene& scene) {
  rig::Clip clip;
  clip.interpolation = rig::Clip::Interpolation::kLinear;
  for (const int body : moving_joints(skeleton)) clip.joints.push_back(skeleton.joint_names[body]);
  for (size_t p = 0; p < poses.size(); ++p) {
    clip.times.push_back(static_cast<double>(p) / scene.fps);
    clip.values.push_back(poses[p]);
  }
  scene.clip = std::move(clip);
  scene.first_frame = 1;
  scene.last_frame = static_cast<int>(poses.size());
  stand_alone(scene);
}

}  // namespace thew::tools
