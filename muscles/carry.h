// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/muscle.h"

namespace thew::muscles {

/// State of a carried muscle that goes from step to step.
struct CarriedMotion {
  Points target;  ///< m, the carried shape at the end of the step; driven nodes lie on it
  std::vector<double> rest_length;  ///< m, of the springs, at the end of the step
  double path_length = 0.0;         ///< m, see CarriedPose
};
/// Results that each step computes anew.
struct CarriedStep {
  double activation = 0.0;  ///< 0..1, of the step
  CarriedPose pose;
  Points target_velocity;                  ///< m/s
  std::vector<double> rest_length_before;  ///< m, rest lengths at the end of the step before
  Points tightened;  ///< m, the carried shape drawn tighter, in which the springs have their rest
                     ///< lengths, m
  CarryWork carry;
};

/// Carries the shape of the muscle along its path in `pose`: sets target positions, their mean
/// velocities over the step of h (s), and the rest lengths of the springs, shortened by
/// `activation` (0..1).
void carry_muscle(const Muscle& muscle, const Pose& pose, double activation, double h,
                  CarriedMotion& motion, CarriedStep& step);

}  // namespace thew::muscles
