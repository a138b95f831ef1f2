// SPDX-License-Identifier: Apache-2.0
#include "tools/export/motion.h"

#include <Eigen/Geometry>

namespace thew::tools {

std::optional<Transform> rigid_fit(const std::vector<Vec3>& rest, const std::vector<Vec3>& frame) {
  constexpr double kClose = 2e-7;  // m, rounding at 2 m from the origin
  using Columns = Eigen::Map<const Eigen::Matrix3Xd>;
  const auto columns = [](const std::vector<Vec3>& values) {
    return Columns(values.front().data(), 3, static_cast<Eigen::Index>(values.size()));
  };
  const Eigen::Matrix4d fit = Eigen::umeyama(columns(rest), columns(frame), false);
  Transform transform = Transform::Identity();
  transform.linear() = Eigen::Quaterniond(fit.topLeftCorner<3, 3>().eval()).normalized().matrix();
  transform.translation() = fit.topRightCorner<3, 1>();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    if (!((transform * rest[v] - frame[v]).norm() <= kClose)) return {};
  }
  return transform;
}

std::vector<RigidMotion> rigid_motions(const Shot& shot) {
  std::vector<RigidMotion> motions(shot.meshes.size());
  std::vector<char> moves(motions.size(), 0);
  std::vector<std::vector<Vec3>> first;
  Shot quiet = shot;
  quiet.progress = ProgressStyle::kNone;
  std::size_t frames = 0;
  for_each_frame(quiet, [&](const ShotFrame& frame) {
    if (first.empty()) first = frame.positions;
    for (std::size_t m = 0; m < motions.size(); ++m) {
      moves[m] |= frame.positions[m] != first[m];
      if (motions[m].size() < frames) continue;  // an earlier frame is not rigid
      const auto fit = rigid_fit(shot.mesh(m).rest.vertices, frame.positions[m]);
      if (fit) motions[m].push_back(*fit);
    }
    ++frames;
  });
  for (std::size_t m = 0; m < motions.size(); ++m) {
    if (!moves[m] || motions[m].size() < frames) motions[m].clear();
  }
  return motions;
}

}  // namespace thew::tools
