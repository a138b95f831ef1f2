// SPDX-License-Identifier: Apache-2.0
#include "rig/skeleton.h"

#include <algorithm>
#include <cassert>
#include <numeric>

#include "rig/math.h"

namespace thew::rig {
namespace {

int index_of(const std::vector<std::string>& names, const std::string& name) {
  if (name.empty()) return -1;  // the root's joint has no name
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? -1 : static_cast<int>(found - names.begin());
}

Transform joint_motion(Skeleton::JointType type, const Vec3& axis, double value) {
  Transform motion = Transform::Identity();
  if (type == Skeleton::JointType::kRevolute) motion.linear() = rotation_about(axis, value);
  if (type == Skeleton::JointType::kPrismatic) motion.translation() = value * axis;
  return motion;
}

// Levenshtein 1966, one row of the table at a time.
int edit_distance(const std::string& a, const std::string& b) {
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 1; i <= a.size(); ++i) {
    int diagonal = row[0];
    row[0] = static_cast<int>(i);
    for (size_t j = 1; j <= b.size(); ++j) {
      const int replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

int find_body(const Skeleton& skeleton, const std::string& name) {
  return index_of(skeleton.body_names, name);
}

int find_joint(const Skeleton& skeleton, const std::string& name) {
  return index_of(skeleton.joint_names, name);
}

void forward_kinematics(const Skeleton& skeleton, const std::vector<double>& joint_values,
                        Pose& pose) {
  assert(joint_values.size() == skeleton.body_names.size());
  pose.resize(skeleton.body_names.size());
  for (int i = 0; i < skeleton.size(); ++i) {
    assert(skeleton.parent[i] < i);
    const Transform local =
        skeleton.joint_in_parent[i] *
        joint_motion(skeleton.joint_types[i], skeleton.joint_axes[i], joint_values[i]);
    pose[i] = skeleton.parent[i] < 0 ? local : pose[skeleton.parent[i]] * local;
  }
}

double joint_value(const Skeleton& skeleton, const Pose& pose, int body) {
  const int parent = skeleton.parent[body];
  if (parent < 0 || skeleton.joint_types[body] == Skeleton::JointType::kFixed) return 0.0;
  const Transform in_joint = (pose[parent] * skeleton.joint_in_parent[body]).inverse() * pose[body];
  const Vec3& axis = skeleton.joint_axes[body];
  if (skeleton.joint_types[body] == Skeleton::JointType::kPrismatic) {
    return axis.dot(in_joint.translation());
  }
  const Eigen::Quaterniond turn(in_joint.linear());
  const double sign = turn.w() < 0.0 ? -1.0 : 1.0;
  return 2.0 * arc_tan2(sign * axis.dot(turn.vec()), sign * turn.w());
}

std::string nearest_name(const std::string& word, const std::vector<std::string>& names) {
  std::string nearest;
  // A third of the letters may be wrong; at least one, so that short names are helped too.
  int limit = std::max(1, static_cast<int>(word.size()) / 3) + 1;
  for (const std::string& name : names) {
    const int distance = edit_distance(word, name);
    if (!name.empty() && distance < limit && distance < static_cast<int>(name.size())) {
      limit = distance;
      nearest = name;
    }
  }
  return nearest;
}

}  // namespace thew::rig
