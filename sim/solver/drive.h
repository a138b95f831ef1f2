// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// At `time` (s): the clip's pose; before 0 on the way to the first one, which takes the first half
/// of scene.settle. A frame that is solved by itself has a way of its own.
WayPoint way_point(const Model& model, double time, const std::optional<LoneWay>& way = {});
/// Joint values there.
void joints_at(const Model& model, double time, std::vector<double>& joints);
/// When that motion ends, s (not above 0).
double bind_to_first_ends(const Model& model);

/// The largest angle (rad) by which a joint turns from one pose to the other, of those of the
/// bodies that `counts`; empty: of all.
double turn_between(const Skeleton& skeleton, const Pose& from, const Pose& to,
                    const std::vector<char>& counts = {});
/// The same of the joints that bend the skin, in the frame that begin_frame() has begun and that
/// ends at `time` (s). The pose of the state is scratch; afterwards it is what it was.
double turn_until(const Model& model, double time, State& state);
/// Sets state.pose, and of a character state.bodies.
void pose_bodies(const Model& model, const WayPoint& at, State& state);
/// Poses the skeleton at `time` (s) and moves the bones' surfaces.
void drive_bones(const Model& model, double time, State& state);
/// Gives the skin layer its cached shape at `time` (s), if it has one.
void carry_skin(const Model& model, double time, State& state);
/// Moves each muscle with the bones, in a step of h seconds that ends at `time` (s): a geometric
/// one becomes its carried shape; one with forces gets its targets, rest lengths and first guess,
/// or is its carried shape where it is on that rung. After drive_bones() and choose_levels().
void drive_muscles(const Model& model, double time, double h, Parallel& parallel, State& state);

}  // namespace thew::sim
