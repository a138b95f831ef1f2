// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

/// A tree of bodies. Body i is attached to body parent[i] < i by a joint of its own; parent is -1
/// for the root.
struct Skeleton {
  enum class JointType { kFixed, kRevolute, kPrismatic };
  struct Visual {
    std::string mesh_file;  ///< absolute path
    Transform in_body = Transform::Identity();
    Vec3 scale = Vec3::Ones();
  };
  std::vector<std::string> body_names;
  std::vector<int> parent;
  /// Frame of the joint in the parent body, at joint value 0.
  std::vector<Transform> joint_in_parent;
  std::vector<std::string> joint_names;  ///< empty for the root
  std::vector<JointType> joint_types;
  std::vector<Vec3> joint_axes;      ///< unit, in the joint's frame
  std::vector<double> lower, upper;  ///< range of the joint value, rad or m
  std::vector<std::vector<Visual>> visuals;
  /// m, in the body, where it meets its parent; empty: in the origins of the frames.
  std::vector<Vec3> pivots;

  int size() const { return static_cast<int>(body_names.size()); }
};

/// The index of the body, or of the body whose joint has that name; -1 if there is none.
int find_body(const Skeleton& skeleton, const std::string& name);
int find_joint(const Skeleton& skeleton, const std::string& name);

/// One world transform per body.
using Pose = std::vector<Transform>;

/// World transforms of all bodies, parents first. `joint_values` has one value for each body (rad
/// or m); those of fixed joints are ignored.
void forward_kinematics(const Skeleton& skeleton, const std::vector<double>& joint_values,
                        Pose& pose);

/// The value (rad from -pi to pi, or m) of a body's joint in a pose, whatever posed it; of a turn
/// about other axes as well, the part about its own. 0 of a fixed joint.
double joint_value(const Skeleton& skeleton, const Pose& pose, int body);

/// The name nearest to `word` by edit distance, for "did you mean"; "" if more than a third of the
/// letters differ in all of them.
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace thew::rig
