// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// A frame is as many steps.
int substeps_of(const Model& model);
/// Whether muscle m takes part in an iteration of a step, after so many that are done.
bool iterates(const Model& model, int m, int done);
bool is_quasi_static(const Model& model, int m);

/// Sets how each muscle is treated in this step; the bones are where they go.
void choose_levels(const Model& model, double h, State& state);

/// Moves x to the exact volume. False where no motion along the volume's gradient reaches it.
bool reach_volume(const Muscle& muscle, VolumeWork& work, Points& x);
/// The carried shape with its profile at the exact volume, into x; the same.
bool place_carried(const Muscle& muscle, const CarriedPose& pose, const CarriedProfile& profile,
                   VolumeWork& work, Points& x);
/// kGeometric: puts the muscle where it belongs in state.pose and restores its volume.
void shape_muscle(const Model& model, int m, double h, State& state);

}  // namespace thew::sim
