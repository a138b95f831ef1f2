// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/volume_rule.h"

#include "muscles/volume.h"
#include "rig/vectorise.h"

namespace thew::sim {
namespace {

bool restore(const Muscle& muscle, const Points& direction, double, Points& x) {
  return restore_exactly(muscle, direction, x);
}

using Exact = VolumeRule::Exact;
// By VolumeMethod. A substep that is not the exact one is linear.
constexpr VolumeRule kRules[] = {
    {false, false, Exact::kNever, leave_volume, nullptr, 0.0},
    {false, true, Exact::kNever, restore_as_printed, printed_lambda, 0.0},
    {false, false, Exact::kNever, restore_linearly, linear_lambda, 0.0},
    {false, false, Exact::kNever, restore_by_penalty, penalty_lambda, kPenaltyBulk},
    {true, false, Exact::kLast, restore, linear_lambda, 0.0},
    {true, false, Exact::kEach, restore, linear_lambda, 0.0}};

}  // namespace

const VolumeRule& rule_of(VolumeMethod method) { return kRules[static_cast<int>(method)]; }

THEW_VECTORISED
bool restore_exactly(const Muscle& muscle, const Points& direction, Points& x) {
  const VolumeCubic cubic = volume_along(x, direction, muscle.rest.triangles);
  const VolumeRoot root = nearest_root(cubic, muscle.rest_volume);
  for (size_t i = 0; i < x.size(); ++i) x[i] += root.s * direction[i];
  return root.reached;
}

}  // namespace thew::sim
