// SPDX-License-Identifier: Apache-2.0
#include "rig/character_limbs.h"

#include "rig/character.h"
#include "rig/math.h"

namespace thew::rig {

void pose_forearm(const Skeleton& skeleton, const Forearm& forearm, Pose& pose) {
  const Mat3 rest = pose[skeleton.parent[forearm.body]].linear() *
                    skeleton.joint_in_parent[forearm.body].linear();
  const Vec3& axis = skeleton.joint_axes[forearm.body];
  const Vec3 along = forearm.wrist.normalized();
  const Mat3 turn = rest.transpose() * pose[forearm.body].linear();
  // The forearm's turn is split: the hinge bends its axis as near to where it is as it can, the
  // smallest rotation does the remainder of that, and what is left is a roll about the axis.
  const Vec3 now = turn * along, a = axis.cross(along), b = axis.cross(now);
  const Mat3 hinge = rotation_about(axis, arc_tan2(axis.dot(a.cross(b)), a.dot(b)));
  const Mat3 bent = least_turn(hinge * along, now) * hinge;
  const Eigen::Quaterniond rolled(Mat3(bent.transpose() * turn));
  const double roll = 2.0 * arc_tan2(rolled.vec().dot(along), rolled.w());
  Transform& ulna = pose[forearm.ulna];
  ulna = pose[forearm.body];
  ulna.linear() = rest * bent;
  Transform& radius = pose[forearm.radius];
  radius.linear() =
      ulna.linear() * rotation_about((forearm.wrist - forearm.head).normalized(), roll);
  radius.translation() = ulna * forearm.head - radius.linear() * forearm.head;
}

void pose_scapula(const Scapula& scapula, Pose& pose) {
  const Transform &on = pose[scapula.on], &humerus = pose[scapula.humerus];
  const Vec3 arm = on.linear().transpose() * humerus.linear() *
                   scapula.at_rest.linear().transpose() * scapula.hanging;
  const double elevation = arc_tan2(scapula.hanging.cross(arm).norm(), scapula.hanging.dot(arm));
  // The rate grows evenly up to twice `from`, so that it is smooth where the arm hangs.
  const double beyond = elevation < 2.0 * scapula.from
                            ? elevation * elevation / (4.0 * scapula.from)
                            : elevation - scapula.from;
  Transform& blade = pose[scapula.body];
  blade.linear() = on.linear() * rotation_about(scapula.axis, scapula.share * beyond);
  blade.translation() = humerus.translation() - blade.linear() * scapula.at_rest.translation();
}

void pose_limbs(const Skeleton& skeleton, const std::vector<Forearm>& forearms,
                const std::vector<Scapula>& scapulae, Pose& pose) {
  for (const Forearm& forearm : forearms) pose_forearm(skeleton, forearm, pose);
  for (const Scapula& scapula : scapulae) pose_scapula(scapula, pose);
}

}  // namespace thew::rig
