// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/muscle.h"

namespace thew::muscles {

/// What of a carried muscle goes from step to step.
struct CarriedMotion {
  Points target;                    ///< the carried shape now, m; driven nodes are on it
  std::vector<double> rest_length;  ///< of the springs, now, m
  double path_length = 0.0;         ///< m, see CarriedPose
};
/// What each step finds anew.
struct CarriedStep {
  CarriedPose pose;
  Points target_velocity;           ///< m/s
  std::vector<double> rest_before;  ///< rest lengths a step before, m
  Points tight;                     ///< the carried shape that springs rest in, m
  CarryWork carry;
};

/// Carries the muscle's shape along its path in the pose: targets, their velocities over h (s),
/// rest lengths of the springs, and `activation` (0..1).
void carry_muscle(const Muscle& muscle, const Pose& pose, double activation, double h,
                  CarriedMotion& motion, CarriedStep& step);

}  // namespace thew::muscles
