// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::rig {

/// A tree of bodies; body i hangs on body parent[i] < i (-1: the root) by its own joint.
struct Skeleton {
  enum class JointType { kFixed, kRevolute, kPrismatic };
  struct Visual {
    std::string mesh_file;  ///< absolute path
    Transform in_body = Transform::Identity();
    Vec3 scale = Vec3::Ones();
  };
  std::vector<std::string> body_names;
  std::vector<int> parent;
  std::vector<Transform> joint_in_parent;  ///< the joint's frame in the parent body, at rest
  std::vector<std::string> joint_names;    ///< empty for the root
  std::vector<JointType> joint_types;
  std::vector<Vec3> joint_axes;      ///< unit, in the joint's frame
  std::vector<double> lower, upper;  ///< rad or m
  std::vector<std::vector<Visual>> visuals;

  int size() const { return static_cast<int>(body_names.size()); }
};

/// -1 where there is none.
int find_body(const Skeleton& skeleton, const std::string& name);
int find_joint(const Skeleton& skeleton, const std::string& name);

/// One world transform per body.
using Pose = std::vector<Transform>;

/// Forward kinematics, iterative. joint_values: one per body (rad or m), unused ones ignored.
void forward_kinematics(const Skeleton& skeleton, const std::vector<double>& joint_values,
                        Pose& pose);

/// Name in `names` nearest to `word` by edit distance, or "" if none is near: "did you mean".
std::string nearest_name(const std::string& word, const std::vector<std::string>& names);

}  // namespace thew::rig
