// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/copies.h"

#include <string>

namespace thew::tools {
namespace {

void add_skeleton(const Skeleton& one, const Vec3& shift, const std::string& mark, Skeleton& all) {
  const int by = all.size();
  for (int b = 0; b < one.size(); ++b) {
    const bool is_root = one.parent[b] < 0;
    all.body_names.push_back(one.body_names[b] + mark);
    all.parent.push_back(is_root ? 0 : one.parent[b] + by);
    all.joint_in_parent.push_back(one.joint_in_parent[b]);
    if (is_root) all.joint_in_parent.back().pretranslate(shift);
    all.joint_names.push_back(one.joint_names[b] + mark);
    all.joint_types.push_back(one.joint_types[b]);
    all.joint_axes.push_back(one.joint_axes[b]);
    all.lower.push_back(one.lower[b]);
    all.upper.push_back(one.upper[b]);
    all.visuals.emplace_back();
  }
}

}  // namespace

ModelDef copies_of(const ModelDef& one, int count, double apart) {
  ModelDef all = one;
  all.skin.mesh = {};
  for (int k = 1; k < count; ++k) {
    const Vec3 shift(0.0, 0.0, k * apart);
    const int by = all.skeleton.size();
    const std::string mark = "#" + std::to_string(k);
    add_skeleton(one.skeleton, shift, mark, all.skeleton);
    for (size_t j = 0; j < one.clip.joints.size(); ++j) {
      all.clip.joints.push_back(one.clip.joints[j] + mark);
      for (size_t key = 0; key < all.clip.values.size(); ++key) {
        all.clip.values[key].push_back(one.clip.values[key][j]);
      }
    }
    for (MuscleDef muscle : one.muscles) {
      muscle.name += mark;
      for (Vec3& p : muscle.mesh.vertices) p += shift;
      for (PathPoint& point : muscle.path.points) {
        point.body += by;
        if (point.with >= 0) point.with += by;
      }
      for (WrapCylinder& wrap : muscle.path.wraps) wrap.body += by;
      for (int& body : muscle.fixed_to) body += body < 0 ? 0 : by;
      all.muscles.push_back(std::move(muscle));
    }
    for (Bone bone : one.bones) {
      bone.name += mark;
      bone.body += by;
      all.bones.push_back(std::move(bone));
    }
    for (const auto& [a, b] : one.contact.ignore)
      all.contact.ignore.push_back({a + mark, b + mark});
    for (const std::string& self : one.contact.self) all.contact.self.push_back(self + mark);
    for (const auto& [name, metres] : one.contact.thickness) {
      all.contact.thickness.push_back({name + mark, metres});
    }
  }
  return all;
}

}  // namespace thew::tools
