// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "muscles/muscle.h"
#include "sim/scene/model_def.h"
#include "skin/contact/explicit_contact.h"

namespace thew::sim {

/// How the volume's multiplier is found: a row of a table. The product's is exact; linear,
/// printed, penalty and none are yardsticks (volume_yardsticks.cpp).
struct VolumeRule {
  bool exact = false;       ///< an implicit step ends at the volume to the last bit
  bool wants_even = false;  ///< `even` below is asked for: dV/dx . d of even weights
  /// Substeps of an explicit step that are exact; the others are linear.
  enum class Exact { kNever, kLast, kEach } substeps = Exact::kNever;
  /// Moves x along `direction` towards the muscle's volume. False where it cannot be reached.
  bool (*restore)(const Muscle& muscle, const Points& direction, double even, Points& x) = nullptr;
  /// lambda of a linear explicit substep of h (s); null: there is none. 0 where `reached` is false.
  double (*lambda)(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                   bool& reached) = nullptr;
  double bulk = 0.0;  ///< Pa, of a compliant volume; 0: it does not give way
};
const VolumeRule& rule_of(VolumeMethod method);

/// Along `direction` to the muscle's volume, to the last bit: the cubic's root nearest 0.
bool restore_exactly(const Muscle& muscle, const Points& direction, Points& x);

// The yardsticks.
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
/// Pa, of the penalty.
inline constexpr double kPenaltyBulk = 1e5;
/// m^3 / Pa of a bulk stiffness.
double volume_compliance(const Muscle& muscle, double bulk);

}  // namespace thew::sim
