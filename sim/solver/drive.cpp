// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/drive.h"

#include <algorithm>
#include <cmath>

#include "muscles/weights.h"
#include "rig/math.h"
#include "rig/vectorise.h"
#include "sim/solver/character_rig.h"
#include "sim/solver/levels.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/rungs.h"

namespace thew::sim {

double bind_to_first_ends(const Model& model) {
  if (is_animated(model)) return -0.5 * model.settle;
  std::vector<double> first;
  sample_clip(model.clip, model.skeleton, 0.0, first);
  const bool moves = std::any_of(first.begin(), first.end(), [](double q) { return q != 0.0; });
  return moves ? -0.5 * model.settle : -model.settle;
}

WayPoint way_point(const Model& model, double time, const std::optional<LoneWay>& way) {
  if (way) return {way->clip_time, time < 0.0 ? std::max(0.0, 1.0 + time / way->length) : 1.0};
  if (time >= 0.0) return {time, 1.0};
  return {0.0, smoothstep(-model.settle, -0.5 * model.settle, time)};
}

namespace {

void joints_at(const Model& model, const WayPoint& at, std::vector<double>& joints) {
  sample_clip(model.clip, model.skeleton, at.clip_time, joints);
  if (at.share == 1.0) return;
  for (double& value : joints) value *= at.share;
}

void pose_bodies(const Model& model, double time, State& state) {
  const WayPoint at = way_point(model, time, state.way);
  joints_at(model, at, state.joints);
  forward_kinematics(model.skeleton, state.joints, state.pose);
  if (model.character) drive_character(model, at, state);
}

// Moves the nodes x to the bone's pose. Returns the longest displacement of a node, m.
THEW_VECTORISED
double move_bone(const Bone& bone, const Transform& pose, Points& x) {
  const Point along[3] = {to_point(pose.linear().col(0)), to_point(pose.linear().col(1)),
                          to_point(pose.linear().col(2))};
  const Point origin = to_point(pose.translation());
  double squared = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3& p = bone.in_body.vertices[i];
    const Point to = p.x() * along[0] + p.y() * along[1] + p.z() * along[2] + origin, d = to - x[i];
    squared = std::max(squared, sum3(d * d));
    x[i] = to;
  }
  return std::sqrt(squared);
}

}  // namespace

void joints_at(const Model& model, double time, std::vector<double>& joints) {
  joints_at(model, way_point(model, time), joints);
}

double turn_between(const Skeleton& skeleton, const Pose& from, const Pose& to) {
  double most = 0.0;
  for (int b = 0; b < skeleton.size(); ++b) {
    const int parent = skeleton.parent[b];
    if (parent < 0) continue;
    const auto bend = [&](const Pose& pose) -> Mat3 {
      return pose[parent].linear().transpose() * pose[b].linear();
    };
    const Mat3 turn = bend(from).transpose() * bend(to);
    const Vec3 twice_sine(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0),
                          turn(1, 0) - turn(0, 1));
    most = std::max(most, arc_tan2(0.5 * twice_sine.norm(), 0.5 * (turn.trace() - 1.0)));
  }
  return most;
}

double turn_until(const Model& model, double time, State& state) {
  pose_bodies(model, time, state);
  const double most = turn_between(model.skeleton, state.frame_pose, state.pose);
  state.pose = state.frame_pose;
  return most;
}

void drive_bones(const Model& model, double time, State& state) {
  state.pose_before = state.pose;
  const Pose& before = state.pose_before;
  pose_bodies(model, time, state);
  // In the first step, and where a failed try has moved the surfaces, all are moved.
  const bool all_move = before.size() != state.pose.size() || state.undone;
  state.undone = false;
  state.body_moved.assign(state.pose.size(), 1);
  for (size_t b = 0; b < state.pose.size() && !all_move; ++b) {
    state.body_moved[b] = before[b].matrix() != state.pose[b].matrix();
  }
  for (size_t b = 0; b < model.bones.size(); ++b) {
    const Bone& bone = model.bones[b];
    BoneState& now = state.bones[b];
    now.displacement = 0.0;
    if (!state.body_moved[bone.body]) continue;
    now.displacement = move_bone(bone, state.pose[bone.body], now.x);
    now.fitted = false;
  }
}

namespace {

double activation_at(const Model& model, int m, double time, const State& state) {
  const auto& keys = model.muscles[m].settings.activation;
  if (keys.empty()) return 0.0;
  if (!state.way) return keyed_value(keys, model.first_frame + time * model.fps);
  const WayPoint at = way_point(model, time, state.way);
  return at.share * keyed_value(keys, model.first_frame + at.clip_time * model.fps);
}

void drive_muscle(const Model& model, int m, double time, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const Level level = now.level;
  if (level == Level::kGeometric) set_geometric_muscle(model, m, h, state);
  if (!has_forces(level)) return;
  carry_muscle(muscle, state.pose, activation_at(model, m, time, state), h, now, now);
  if (!follows_carried_shape(model, now, time)) return predict(muscle, h, now);
  now.level = Level::kGeometric;
  const double before = time > state.time ? time - h : time;  // no time passes in rest_frame()
  follow_carried_shape(model, m, time, before, h, now);
}

}  // namespace

void drive_muscles(const Model& model, double time, double h, Parallel& parallel, State& state) {
  parallel.each(state.count(), [&](int m) { drive_muscle(model, m, time, h, state); });
}

}  // namespace thew::sim
