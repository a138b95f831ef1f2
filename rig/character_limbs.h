// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "rig/skeleton.h"

namespace thew::rig {

// Bones that characters lack: their bodies follow from the character's own in each pose.

/// A character's forearm, which is one body, as two: the ulna follows the hinge without the body's
/// roll about its length. The radius turns by that roll about the line from its head, which the
/// ulna holds, to the wrist.
struct Forearm {
  int body, ulna, radius;
  Vec3 head, wrist;  ///< m, in the body's frame
};
/// Sets ulna and radius in the pose, from the pose of humerus and forearm.
void pose_forearm(const Skeleton& skeleton, const Forearm& forearm, Pose& pose);

/// A character's shoulder blade: it lies on the body `on`, such as the clavicle, and turns upwards
/// about the shoulder joint as the arm is raised (scapulohumeral rhythm, Inman et al. 1944).
struct Scapula {
  int body, on, humerus;
  Vec3 axis,
      hanging;        ///< unit, in the frame of `on`: of the turn; where the humerus points at rest
  double from;        ///< rad, elevation of the arm from which on it turns
  double share;       ///< of the elevation beyond that
  Transform at_rest;  ///< frame of the humerus in the frame of `on` in the rest pose
};
/// Sets the shoulder blade in the pose, from the pose of `on` and humerus.
void pose_scapula(const Scapula& scapula, Pose& pose);

void pose_limbs(const Skeleton& skeleton, const std::vector<Forearm>& forearms,
                const std::vector<Scapula>& scapulae, Pose& pose);

}  // namespace thew::rig
