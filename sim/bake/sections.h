// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/carry.h"

namespace thew::sim {

/// Area (m^2) of the section across the belly at u in 0..1.
double section_area_at(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u);

/// Mean area (m^2) of sections across the belly at a pose.
double mean_belly_area(const Muscle& muscle, const CarriedPose& pose, const Points& x);

}  // namespace thew::sim
