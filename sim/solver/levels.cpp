// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/levels.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

bool is_driven(const Model& model, int m, const State& state) {
  const Muscle& muscle = model.muscles[m];
  const auto moves = [&](int body) { return state.body_moved[body] != 0; };
  return !muscle.settings.activation.empty() || muscle.settings.by_joint ||
         std::any_of(muscle.bodies.begin(), muscle.bodies.end(), moves);
}

double fastest(const Points& v) {
  double squared = 0.0;
  for (const Point& r : v) squared = std::max(squared, dot(r, r));
  return std::sqrt(squared);
}

// Whether neither the muscle moves, nor anything that is near enough to touch it before the next
// step. Two steps without motion are asked for, since at the turning point of a swing a muscle
// stands still for one.
bool is_still(const Model& model, int m, double h, const State& state) {
  const double still = model.fidelity->still_distance;
  const auto& contact = model.contact;
  if (state.muscles[m].still_steps < 2) return false;
  if (!contact.enabled) return true;
  const NodeBox own = box_of(state.muscles[m].x);
  const double reach = std::max(contact.settings.margin, contact.settings.max_depth);
  const int count = state.count();
  for (int other = 0; other < model.colliders(); ++other) {
    if (model.ignore[m][other]) continue;
    const bool is_bone = other >= count;
    if (is_bone && !state.body_moved[model.bones[other - count].body]) continue;
    const double displacement =
        is_bone ? state.bones[other - count].displacement : h * fastest(state.muscles[other].v);
    if (!is_bone && displacement <= still && !is_driven(model, other, state)) continue;
    const Points& x = is_bone ? state.bones[other - count].x : state.muscles[other].x;
    if (are_near(own, box_of(x), reach + displacement)) return false;
  }
  return true;
}

// Sets what other muscles read of a muscle that is not stepped any more.
void fall_asleep(const Surface& surface, MuscleState& now) {
  now.v.assign(now.x.size(), Point{});
  now.target_velocity = now.v;
  now.start = now.previous_iterate = now.x;
  refit_bvh(surface, now.x, now.bvh);
  now.memory.others.clear();  // a sleeping muscle does not update them
  now.face_memory.others.clear();
}

}  // namespace

int substeps_of(const Model& model) {
  return model.fidelity ? model.fidelity->substeps : model.solver.substeps;
}

bool iterates(const Model& model, int m, int done) {
  return !model.fidelity || done < model.fidelity->muscles[m].iterations;
}

bool is_quasi_static(const Model& model, int m) {
  return model.fidelity ? model.fidelity->muscles[m].level == Level::kQuasiStatic
                        : model.solver.integrator == Integrator::kQuasiStatic;
}

void choose_levels(const Model& model, double h, State& state) {
  if (!model.fidelity) {
    for (MuscleState& now : state.muscles) now.level = now.highest_level = Level::kDynamic;
    return;
  }
  for (int m = 0; m < state.count(); ++m) {
    if (!has_forces(model.fidelity->muscles[m].level)) continue;
    MuscleState& now = state.muscles[m];
    now.still_steps =
        h * fastest(now.v) <= model.fidelity->still_distance ? std::min(now.still_steps + 1, 2) : 0;
  }
  for (int m = 0; m < state.count(); ++m) {
    const Level level = model.fidelity->muscles[m].level;
    const bool moves =
        is_driven(model, m, state) ||
        (level == Level::kGeometric ? !state.muscles[m].posed : !is_still(model, m, h, state));
    state.muscles[m].chosen_level = moves ? level : Level::kAsleep;
  }
  for (int m = 0; m < state.count();
       ++m) {  // after all are chosen: the choice reads the levels of others
    MuscleState& now = state.muscles[m];
    if (now.chosen_level == Level::kAsleep && now.level != Level::kAsleep) {
      fall_asleep(model.surfaces[m].surface, now);
    }
    now.level = now.chosen_level;
    if (now.level != Level::kAsleep) now.node_iterations += static_cast<std::int64_t>(now.x.size());
    now.highest_level = std::max(now.highest_level, now.level);
  }
}

bool restore_volume(const Muscle& muscle, VolumeWork& work, Points& x) {
  volume_gradient(x, muscle.rest.triangles, work.gradient);
  work.direction.resize(x.size());
  for (const bool even : {false, true}) {  // even weights where the authored ones fail
    for (size_t i = 0; i < x.size(); ++i) {
      const double weight = muscle.driven[i] ? 0.0 : even ? 1.0 : muscle.weights[i];
      work.direction[i] = weight / muscle.mass[i] * work.gradient[i];
    }
    if (restore_exactly(muscle, work.direction, x)) return true;
  }
  return false;
}

bool set_carried_shape(const Muscle& muscle, const CarriedPose& pose, const CarriedProfile& profile,
                       VolumeWork& work, Points& x) {
  profiled_positions(muscle.shape, pose, muscle.swells, profile, x);
  return restore_volume(muscle, work, x);
}

void set_geometric_muscle(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  now.start.swap(now.x);
  carry_pose(muscle.shape, state.pose, now.carry, now.pose);
  now.path_length = now.pose.path_length;
  const CarriedProfile& profile = model.fidelity->muscles[m].profile;
  if (!set_carried_shape(muscle, now.pose, profile, now.volume, now.x)) ++now.unreached;
  for (size_t i = 0; i < now.x.size(); ++i) now.v[i] = (now.x[i] - now.start[i]) * (1.0 / h);
  now.target_velocity = now.v;
  now.previous_iterate = now.x;
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
  now.posed = true;
}

}  // namespace thew::sim
