// SPDX-License-Identifier: Apache-2.0
//
// The rules that the exact multiplier is compared with: no volume correction, the paper's linear
// multiplier (eqs 9-14) as it is printed, without the weights in the denominator, and mended, with
// them, and a penalty by bulk stiffness.
#include "muscles/volume.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

// s = (V0 - V) / denominator.
bool move_linearly(const Muscle& muscle, double volume, double denominator, const Points& direction,
                   Points& x) {
  if (denominator == 0.0) return false;
  const double s = (muscle.rest_volume - volume) / denominator;
  for (size_t i = 0; i < x.size(); ++i) x[i] += s * direction[i];
  return true;
}

VolumeCubic along(const Muscle& muscle, const Points& direction, const Points& x) {
  return volume_along(x, direction, muscle.rest.triangles);
}

double lambda_over(const Muscle& muscle, double h, double denominator, const VolumeSums& sums,
                   bool& reached) {
  reached = denominator > 0.0;
  return reached ? ((sums.volume - muscle.rest_volume) / h + sums.rate) / denominator : 0.0;
}

}  // namespace

bool leave_volume(const Muscle&, const Points&, double, Points&) { return true; }

bool restore_linearly(const Muscle& muscle, const Points& direction, double, Points& x) {
  const VolumeCubic cubic = along(muscle, direction, x);
  return move_linearly(muscle, cubic.c0, cubic.c1, direction, x);
}

bool restore_as_printed(const Muscle& muscle, const Points& direction, double even, Points& x) {
  return move_linearly(muscle, along(muscle, direction, x).c0, even, direction, x);
}

bool restore_by_penalty(const Muscle& muscle, const Points& direction, double, Points& x) {
  const VolumeCubic cubic = along(muscle, direction, x);
  return move_linearly(muscle, cubic.c0, cubic.c1 + volume_compliance(muscle, kPenaltyBulk),
                       direction, x);
}

double linear_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double,
                     bool& reached) {
  return lambda_over(muscle, h, sums.weighted, sums, reached);
}

double printed_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double even,
                      bool& reached) {
  return lambda_over(muscle, h, even, sums, reached);
}

double penalty_lambda(const Muscle& muscle, double h, const VolumeSums& sums, double,
                      bool& reached) {
  reached = true;
  return h * (sums.volume - muscle.rest_volume) / volume_compliance(muscle, kPenaltyBulk);
}

double volume_compliance(const Muscle& muscle, double bulk) { return muscle.rest_volume / bulk; }

}  // namespace thew::sim
