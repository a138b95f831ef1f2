// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/lab/base/table.h"

namespace thew::tools {

/// A muscle of the arm at an angle of the elbow: its belly's mean section over that at 0 degrees,
/// and by how much its volume is off (|V/V0 - 1|).
struct ArmSection {
  std::string muscle;
  double degrees = 0.0;
  double rest_area = 0.0;   ///< m^2, mean of the belly's sections at 0 degrees
  double shortening = 0.0;  ///< of the belly, share of its length at 0 degrees
  struct Shown {
    double section = 0.0;  ///< 0: the method has not this muscle
    double volume_error = 0.0;
  };
  Shown ours, ellipsoid, profile, elements;  ///< Scheepers 1997, Aubel 2001, Chen 1992
};

/// The arm's own muscles by Thew. The others have no bones to go round: each muscle is a spindle of
/// the belly's length and volume, whose ends (a tenth of each half is held) come nearer by as much
/// as the path shortens. Elements: the long head of the biceps alone, as in their paper's tests.
std::vector<ArmSection> arm_sections(const std::filesystem::path& scene,
                                     const std::vector<double>& degrees);

/// Muscle by muscle, and the flexors of the upper arm together.
Table sections_of(const std::vector<ArmSection>& rows);

}  // namespace thew::tools
