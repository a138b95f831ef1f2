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
  const bool moves = std::any_of(first.begin(), first.end(), [](double q) { return q != 0.0; }) ||
                     leaves_bind_pose(model);
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

}  // namespace

void pose_bodies(const Model& model, const WayPoint& at, State& state) {
  joints_at(model, at, state.joints);
  forward_kinematics(model.skeleton, state.joints, state.pose);
  if (model.character) drive_character(model, at, state);
  pose_cached(model, at, state);
}

namespace {

void pose_bodies(const Model& model, double time, State& state) {
  pose_bodies(model, way_point(model, time, state.way), state);
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

double turn_between(const Skeleton& skeleton, const Pose& from, const Pose& to,
                    const std::vector<char>& counts) {
  double most = 0.0;
  for (int b = 0; b < skeleton.size(); ++b) {
    const int parent = skeleton.parent[b];
    if (parent < 0 || (!counts.empty() && !counts[b])) continue;
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
  const double most = turn_between(model.skeleton, state.frame_pose, state.pose, model.skin_bends);
  state.pose = state.frame_pose;
  return most;
}

void drive_bones(const Model& model, double time, State& state) {
  state.pose_before = state.pose;
  const Pose& before = state.pose_before;
  const WayPoint at = way_point(model, time, state.way);
  pose_bodies(model, at, state);
  // In the first step, and where a failed try has moved the surfaces, all are moved.
  const bool is_first = before.size() != state.pose.size(), undone = state.undone;
  const bool all_move = is_first || undone;
  state.undone = false;
  state.body_moved.assign(state.pose.size(), 1);
  for (size_t b = 0; b < state.pose.size() && !all_move; ++b) {
    state.body_moved[b] = before[b].matrix() != state.pose[b].matrix();
  }
  for (size_t b = 0; b < model.bones.size(); ++b) {
    const Bone& bone = model.bones[b];
    BoneState& now = state.bones[b];
    now.displacement = now.bent = 0.0;
    if (bone.bends()) {
      if (is_first) place_bent(bone, at, state, now);
      if (undone) place_bent(bone, way_point(model, state.time, state.way), state, now);
      bend_bone(bone, at, state, now);
      continue;
    }
    if (!state.body_moved[bone.body]) continue;
    now.displacement = move_bone(bone, state.pose[bone.body], now.x);
    now.fitted = false;
  }
}

void carry_skin(const Model& model, double time, State& state) {
  if (!model.skin_motion) return;
  const WayPoint at = way_point(model, time, state.way);
  shape_at(*model.skin_motion, at.clip_time, state.skin_shape);
  if (at.share == 1.0)
    return set_carried(model.skin, state.pose, state.skin_shape, 1.0, state.skin);
  state.pose_ahead.swap(state.pose);  // the pose of the clip, of which the state is on the way
  pose_bodies(model, {at.clip_time, 1.0}, state);
  state.pose_ahead.swap(state.pose);
  set_carried(model.skin, state.pose_ahead, state.skin_shape, at.share, state.skin);
}

namespace {

// Moment (N m, or force in N of a slider) of a load's weight, in the sense in which the joint's
// value grows.
double moment_of(const Model& model, const JointActivation& by, const Pose& pose) {
  const Transform& joint = pose[by.body];
  const Vec3 axis = joint.linear() * model.skeleton.joint_axes[by.body];
  const Vec3 force = by.load->mass * model.gravity;
  if (model.skeleton.joint_types[by.body] == Skeleton::JointType::kPrismatic) {
    return axis.dot(force);
  }
  const Vec3 arm = pose[by.load->index] * by.load->at - joint.translation();
  return axis.dot(arm.cross(force));
}

// sum_j a r_j f_max_j = -moment over the muscles j whose moment arm r_j opposes it, all with one a.
double activation_by_load(const Model& model, int m, double value, const Pose& pose) {
  const JointActivation& by = *model.muscles[m].settings.by_joint;
  const double moment = moment_of(model, by, pose), against = moment > 0.0 ? -1.0 : 1.0;
  if (against * keyed_value(by.moment_arm, value) <= 0.0) return 0.0;
  double all = 0.0;
  for (const Muscle& other : model.muscles) {
    const auto& with = other.settings.by_joint;
    if (!with || !with->load || with->body != by.body) continue;
    all += other.settings.f_max * std::max(against * keyed_value(with->moment_arm, value), 0.0);
  }
  return all > 0.0 ? std::min(std::fabs(moment) / all, 1.0) : 0.0;
}

double activation_by_joint(const Model& model, int m, double h, const State& state) {
  const JointActivation& by = *model.muscles[m].settings.by_joint;
  const Skeleton& skeleton = model.skeleton;
  const bool turns = skeleton.joint_types[by.body] == Skeleton::JointType::kRevolute;
  const double unit = turns ? kDegree : 1.0, value = joint_value(skeleton, state.pose, by.body);
  double sum = 0.0;
  if (!by.curve.empty()) sum += keyed_value(by.curve, value / unit);
  if (!by.speed.empty()) {
    double way = 0.0;  // none in the first step
    if (state.pose_before.size() == state.pose.size()) {
      way = value - joint_value(skeleton, state.pose_before, by.body);
    }
    if (turns && std::fabs(way) > kPi) way -= std::copysign(2.0 * kPi, way);
    sum += keyed_value(by.speed, way / (unit * h));
  }
  if (by.load) sum += activation_by_load(model, m, value, state.pose);
  return std::clamp(sum, 0.0, 1.0);
}

double activation_at(const Model& model, int m, double time, double h, const State& state) {
  if (model.muscles[m].settings.by_joint) return activation_by_joint(model, m, h, state);
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
  carry_muscle(muscle, state.pose, activation_at(model, m, time, h, state), h, now, now);
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
