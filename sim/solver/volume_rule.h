// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/muscle.h"
#include "sim/scene/model_def.h"
#include "skin/contact/explicit_contact.h"

namespace thew::sim {

/// How the volume's multiplier is found, as a row of a table. `exact` is the default of a scene.
/// linear, printed, penalty and none are there to be compared with it (volume_yardsticks.cpp).
struct VolumeRule {
  bool exact = false;       ///< an implicit step ends at the volume to the last bit
  bool wants_even = false;  ///< whether `even` below is used: dV/dx . d under even weights
  /// Which substeps of an explicit step are exact; the others are linear.
  enum class Exact { kNever, kLast, kEach } substeps = Exact::kNever;
  /// Moves x along `direction` towards the muscle's volume. False where it cannot be reached.
  bool (*restore)(const Muscle& muscle, const Points& direction, double even, Points& x) = nullptr;
  /// The multiplier lambda of a linear explicit substep of h seconds, from its sums; null: none.
  /// Returns 0 where it sets `reached` to false.
  double (*lambda)(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                   bool& reached) = nullptr;
  double bulk = 0.0;  ///< Pa, bulk stiffness of a compliant volume; 0: incompressible
};
const VolumeRule& rule_of(VolumeMethod method);

/// Moves x along `direction` to the muscle's volume, to the last bit: by the root nearest 0 of the
/// cubic V(x + s d) = V0. False where there is no root.
bool restore_exactly(const Muscle& muscle, const Points& direction, Points& x);

// The rules for comparison, see VolumeRule.
bool leave_volume(const Muscle& muscle, const Points& direction, double even, Points& x);
bool restore_linearly(const Muscle& muscle, const Points& direction, double even, Points& x);
bool restore_as_printed(const Muscle& muscle, const Points& direction, double even, Points& x);
bool restore_by_penalty(const Muscle& muscle, const Points& direction, double even, Points& x);
double linear_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                     bool& reached);
double printed_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                      bool& reached);
double penalty_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                      bool& reached);
/// Pa, bulk stiffness of the penalty.
inline constexpr double kPenaltyBulk = 1e5;
/// m^3/Pa: rest volume over a bulk stiffness (Pa).
double volume_compliance(const Muscle& muscle, double bulk);

}  // namespace thew::sim
