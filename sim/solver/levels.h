// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// Substeps of a frame, at least.
int substeps_of(const Model& model);
/// Whether muscle m takes part in the iteration that follows the first `done` ones of a step.
bool iterates(const Model& model, int m, int done);
bool is_quasi_static(const Model& model, int m);

/// Sets the level of each muscle for a step of h seconds. After drive_bones().
void choose_levels(const Model& model, double h, State& state);

/// Moves x along the weighted gradient of the volume to the muscle's exact volume; with even
/// weights where that cannot reach it. False where neither does; x has then been moved all the
/// same.
bool restore_volume(const Muscle& muscle, VolumeWork& work, Points& x);
/// Sets x to the carried shape of the pose, with the profile added, at the exact volume. False as
/// of restore_volume().
bool set_carried_shape(const Muscle& muscle, const CarriedPose& pose, const CarriedProfile& profile,
                       VolumeWork& work, Points& x);
/// Sets a muscle of level kGeometric to its carried shape in state.pose at its exact volume, with
/// the velocities of a step of h seconds.
void set_geometric_muscle(const Model& model, int m, double h, State& state);

}  // namespace thew::sim
