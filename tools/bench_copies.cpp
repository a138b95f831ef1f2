// SPDX-License-Identifier: Apache-2.0
#include "tools/bench_copies.h"

#include <algorithm>
#include <string>

namespace thew {

Model copies_of(const Model& one, int count, double apart) {
  Model all = one;
  Skeleton& skeleton = all.skeleton;
  const int bodies = one.skeleton.size(), joints = static_cast<int>(one.scene.clip.joints.size());
  for (int k = 1; k < count; ++k) {
    const Vec3 shift(0.0, 0.0, k * apart);
    const int by = k * bodies;
    const std::string mark = "#" + std::to_string(k);
    for (int b = 0; b < bodies; ++b) {
      const bool is_root = one.skeleton.parent[b] < 0;
      skeleton.body_names.push_back(one.skeleton.body_names[b] + mark);
      skeleton.parent.push_back(is_root ? 0 : one.skeleton.parent[b] + by);
      skeleton.joint_in_parent.push_back(one.skeleton.joint_in_parent[b]);
      if (is_root) skeleton.joint_in_parent.back().pretranslate(shift);
      skeleton.joint_names.push_back(one.skeleton.joint_names[b] + mark);
      skeleton.joint_types.push_back(one.skeleton.joint_types[b]);
      skeleton.joint_axes.push_back(one.skeleton.joint_axes[b]);
      skeleton.lower.push_back(one.skeleton.lower[b]);
      skeleton.upper.push_back(one.skeleton.upper[b]);
      skeleton.visuals.push_back(one.skeleton.visuals[b]);
    }
    for (int j = 0; j < joints; ++j) {
      all.scene.clip.joints.push_back(one.scene.clip.joints[j] + mark);
      for (size_t key = 0; key < all.scene.clip.values.size(); ++key) {
        all.scene.clip.values[key].push_back(one.scene.clip.values[key][j]);
      }
    }
    for (Muscle muscle : one.muscles) {
      for (Vec3& p : muscle.rest.vertices) p += shift;
      for (PathPoint& point : muscle.shape.path.points) point.body += by;
      for (WrapCylinder& wrap : muscle.shape.path.wraps) wrap.body += by;
      for (int& body : muscle.bodies) body += by;
      all.muscles.push_back(std::move(muscle));
    }
    for (Bone bone : one.bones) {
      bone.body += by;
      all.bones.push_back(std::move(bone));
    }
  }
  // Colliders are the muscles and then the bones, of all copies.
  const int muscles = static_cast<int>(one.muscles.size()),
            bones = static_cast<int>(one.bones.size());
  all.ignore.assign(all.muscles.size(), std::vector<char>(all.colliders(), 0));
  for (int k = 0; k < count; ++k) {
    for (int m = 0; m < muscles; ++m) {
      const std::vector<char>& own = one.ignore[m];
      std::vector<char>& ignored = all.ignore[k * muscles + m];
      std::copy_n(own.begin(), muscles, ignored.begin() + k * muscles);
      std::copy_n(own.begin() + muscles, bones, ignored.begin() + count * muscles + k * bones);
    }
  }
  return all;
}

}  // namespace thew
