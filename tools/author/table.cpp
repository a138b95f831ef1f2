// SPDX-License-Identifier: Apache-2.0
#include "tools/author/table.h"

#include <algorithm>
#include <array>

#include "rig/math.h"
#include "rig/text.h"
#include "tools/author/hand.h"

namespace thew::tools {
namespace {

struct Record {
  std::string muscle, record, body, source;
  std::vector<double> values;
  std::string place;  // "muscles.csv:12"

  double at(size_t i) const {
    if (i < values.size()) return values[i];
    throw Error(ErrorCode::kInput, place + ": " + muscle + ", " + record + " needs " +
                                       std::to_string(i + 1) + " numbers; add the missing ones");
  }
  Vec3 vec(size_t i) const { return {at(i), at(i + 1), at(i + 2)}; }
};

std::vector<std::string> split(const std::string& line, char separator) {
  std::vector<std::string> cells(1);
  for (char c : line) {
    if (c == separator) {
      cells.emplace_back();
    } else if (c != '\r') {
      cells.back() += c;
    }
  }
  return cells;
}

constexpr size_t kFirstValue = 3, kValues = 7;

std::vector<Record> read_records(const std::filesystem::path& file) {
  std::vector<Record> records;
  const std::vector<std::string> lines = split(read_whole(file, 1 << 20), '\n');
  for (size_t i = 1; i < lines.size(); ++i) {  // the first is the header
    if (lines[i].empty()) continue;
    const std::vector<std::string> cells = split(lines[i], ',');
    const std::string place = file.filename().string() + ":" + std::to_string(i + 1);
    if (cells.size() != kFirstValue + kValues + 1) {
      throw Error(ErrorCode::kInput, place + ": " + std::to_string(cells.size()) +
                                         " cells instead of 11; a source has no comma");
    }
    Record record{cells[0], cells[1], cells[2], cells.back(), {}, place};
    for (size_t k = 0; k < kValues && !cells[kFirstValue + k].empty(); ++k) {
      const auto value = parse_number(cells[kFirstValue + k]);
      if (!value) {
        throw Error(ErrorCode::kInput,
                    place + ": \"" + cells[kFirstValue + k] + "\" is no number; correct it");
      }
      record.values.push_back(*value);
    }
    records.push_back(std::move(record));
  }
  return records;
}

PathPoint path_point(const Record& record, const Skeleton& skeleton, const Vec3& position) {
  if (record.body == "base") {  // arm26's trunk: humerus = base + (-.017545, -.007, .17)
    return {find_body(skeleton, "scapula"), position + Vec3(0.007995, -0.027, -0.161)};
  }
  if (record.body == "r_ulna_radius_hand") {  // arm26's forearm, as the ulna's frame
    return {find_body(skeleton, "ulna"), position};
  }
  const int body = find_body(skeleton, record.body);
  if (body >= 0) {
    PathPoint point{body, position};
    if (record.record == "point" && record.values.size() > 3) {
      if (skeleton.parent[body] < 0) {
        throw Error(ErrorCode::kInput, record.place + ": \"" + record.body +
                                           "\" hangs on no joint; leave out the share of its turn");
      }
      share_turn(skeleton.parent[body], record.at(3), rest_pose(skeleton), point);
    }
    return point;
  }
  throw Error(ErrorCode::kInput, record.place + ": body \"" + record.body + "\" is not in the arm" +
                                     did_you_mean(record.body, skeleton.body_names));
}

// The axis of the first joint that a segment crosses, from its proximal end.
Vec3 axis_of_segment(const MusclePath& path, int segment, const Skeleton& skeleton,
                     const std::string& place) {
  const bool is_there = segment >= 0 && segment + 1 < static_cast<int>(path.points.size());
  int body = is_there ? path.points[segment + 1].body : -1;
  while (body >= 0 && skeleton.parent[body] != path.points[segment].body) {
    body = skeleton.parent[body];
  }
  if (body >= 0) return skeleton.joint_axes[body];
  throw Error(ErrorCode::kInput, place + ": segment " + std::to_string(segment) +
                                     " of the points above crosses no joint; correct its number");
}

WeightProfile weight_profile(const Record& record) {
  if (record.values.empty()) return preset_profile(record.body);
  WeightProfile profile{{}};
  for (size_t i = 0; i < record.values.size(); i += 2) {
    profile.keys.push_back({record.at(i), record.at(i + 1)});
  }
  return profile;
}

void add_record(const Record& record, const Skeleton& skeleton, TableMuscle& muscle) {
  const std::string& what = record.record;
  if (what == "force") {
    muscle.f_max = record.at(0);
  } else if (what == "fibre_tendon") {
    muscle.fibre_length = record.at(0);
  } else if (what == "volume") {
    muscle.volume = record.at(0) * 1e-6;  // cm^3
  } else if (what == "belly") {
    muscle.belly = {record.at(0), record.at(1)};
  } else if (what == "twist_from") {
    muscle.twist_from = record.at(0);
  } else if (what == "mesh") {
    muscle.around = static_cast<int>(record.at(0));
    muscle.rings = static_cast<int>(record.at(1));
  } else if (what == "point") {
    muscle.path.points.push_back(path_point(record, skeleton, record.vec(0)));
  } else if (what == "wrap") {
    const PathPoint centre = path_point(record, skeleton, record.vec(1));
    const int segment = static_cast<int>(record.at(0));
    muscle.path.wraps.push_back({segment, centre.body, centre.position,
                                 axis_of_segment(muscle.path, segment, skeleton, record.place),
                                 record.at(4), record.at(5)});
  } else if (what == "beside") {
    for (size_t i = static_cast<size_t>(record.at(0)); i < muscle.path.points.size(); ++i) {
      muscle.path.points[i].position += record.vec(1);
    }
  } else if (what == "tendon") {
    muscle.tendon_radius = {record.at(0), record.at(1)};
  } else if (what == "before") {
    muscle.before = record.values;
  } else if (what == "after") {
    muscle.after = record.values;
  } else if (what == "weights") {
    muscle.weights = weight_profile(record);
  } else if (what == "section") {  // centre, area, width and thickness, its turn from z to x
    const SinCos turn = sin_cos(record.at(6) * kDegree);
    muscle.sections.push_back(
        {record.vec(0), record.at(3), record.at(4) / record.at(5), {turn.sin, 0.0, turn.cos}});
  } else {
    throw Error(ErrorCode::kInput, record.place + ": unknown record \"" + what + "\"; correct it");
  }
}

// A body that turns about an axis through `origin`, in its parent's frame (m).
void add_body(int parent, const FingerBone& bone, const Vec3& origin, Skeleton& skeleton) {
  Transform in_parent = Transform::Identity();
  in_parent.translation() = origin;
  skeleton.parent.push_back(parent);
  skeleton.body_names.push_back(bone.body);
  skeleton.joint_in_parent.push_back(in_parent);
  skeleton.joint_names.push_back(bone.joint);
  skeleton.joint_types.push_back(bone.joint.empty() ? Skeleton::JointType::kFixed
                                                    : Skeleton::JointType::kRevolute);
  skeleton.joint_axes.push_back(bone.axis.normalized());
  skeleton.lower.push_back(bone.lower * kDegree);
  skeleton.upper.push_back(bone.upper * kDegree);
  skeleton.visuals.emplace_back();
}

// The fingers' bones; what they hang on is the hand or the bone before.
void add_fingers(Skeleton& skeleton) {
  const int hand = find_body(skeleton, "hand");
  const Pose rest = rest_pose(skeleton);
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();
  std::array<int, 5> last;  // body of each finger
  last.fill(hand);
  for (const FingerBone& bone : finger_bones()) {
    const std::vector<Vec3>& points = fingers()[bone.finger].points;
    const bool is_first = last[bone.finger] == hand;
    const Vec3 from = is_first ? Vec3(rest[hand].translation()) : humerus + points[bone.part - 1];
    add_body(last[bone.finger], bone, humerus + points[bone.part] - from, skeleton);
    last[bone.finger] = skeleton.size() - 1;
  }
}

}  // namespace

Skeleton arm_skeleton() {
  Skeleton skeleton;
  const auto add = [&](const std::string& body, const std::string& joint, const Vec3& origin,
                       const Vec3& axis, double lower, double upper) {
    add_body(skeleton.size() - 1, {body, joint, 0, 0, axis, lower, upper}, origin, skeleton);
  };
  // Holzbaur, Murray, Delp 2005, as in arm26 and myo_sim.
  add("scapula", "", Vec3::Zero(), Vec3::UnitZ(), 0, 0);
  add("humerus", "shoulder_elevation", {-0.00955, -0.034, 0.009}, {-0.0589, 0.0023, 0.99826}, -90,
      180);
  add("ulna", "elbow", {0.0061, -0.2904, -0.0123}, {0.0494, 0.0366, 0.9981}, 0, 130);
  add("radius", "forearm_rotation", {0.0004, -0.0115, 0.02}, {-0.0172, 0.9927, -0.1197}, -90, 90);
  add("hand", "wrist_flexion", {0.022, -0.2571, 0.0273}, {1, 0, 0}, -70, 70);
  add_fingers(skeleton);
  return skeleton;
}

Pose rest_pose(const Skeleton& skeleton) {
  Pose pose;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), pose);
  return pose;
}

std::vector<TableMuscle> read_muscle_table(const std::filesystem::path& file,
                                           const Skeleton& skeleton) {
  std::vector<TableMuscle> muscles;
  for (const Record& record : read_records(file)) {
    auto muscle = std::find_if(muscles.begin(), muscles.end(),
                               [&](const TableMuscle& m) { return m.name == record.muscle; });
    if (muscle == muscles.end()) {
      muscles.emplace_back().name = record.muscle;
      muscle = muscles.end() - 1;
    }
    add_record(record, skeleton, *muscle);
  }
  return muscles;
}

}  // namespace thew::tools
