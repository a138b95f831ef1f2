// SPDX-License-Identifier: Apache-2.0
#include "sim/explicit_contact.h"

#include <algorithm>
#include <cmath>

#include "rig/vectorise.h"
#include "sim/drive.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

Touch touch_of(const Model& model, const State& state, const Pose& pose_before,
               const Contact& contact) {
  const int muscles = static_cast<int>(model.muscles.size());
  const Vec3& normal = contact.normal;
  Row before, after;
  if (contact.other < muscles) {
    before = after = contact_point(model, contact, other_seen(state, contact));
  } else {
    const Bone& bone = model.bones[contact.other - muscles];
    const Triangle& t = bone.surface.triangles[contact.triangle];
    const std::vector<Vec3>& y = bone.in_body.vertices;
    const auto& b = contact.barycentric;
    const Vec3 point = b[0] * y[t[0]] + b[1] * y[t[1]] + b[2] * y[t[2]];
    before = to_row(pose_before[bone.body] * point);
    after = to_row(state.pose[bone.body] * point);
  }
  const double from =
      normal.dot(to_vec(before)) + model.scene.contact.settings.gap + contact.offset;
  return {.normal = to_row(normal),
          .from = from,
          .way = normal.dot(to_vec(after - before)),
          .node = contact.node};
}

}  // namespace

Touches touches_of(const Model& model, int m, double begin, const State& state) {
  Touches touches;
  if (state.muscles[m].contacts.empty()) return touches;
  std::vector<double> joints;
  Pose pose_before;
  joints_at(model, begin, joints);
  forward_kinematics(model.skeleton, joints, pose_before);
  for (const Contact& contact : state.muscles[m].contacts) {
    touches.push_back(touch_of(model, state, pose_before, contact));
    const size_t last = touches.size() - 1;
    if (last > 0 && touches[last - 1].node == contact.node) {  // they come by node
      touches[last - 1].shared = touches[last].shared = true;
    }
  }
  return touches;
}

THEW_VECTORISED
void look_for_near(double t, double frame, double span, const MuscleState& now, Touches& touches,
                   Near& near) {
  near.all.clear();
  near.shared.clear();
  if (touches.empty()) return;
  Row most = {};
  for (const Row& v : now.v) most = v * v > most ? v * v : most;
  const double fastest = std::sqrt(sum3(most));
  for (Touch& touch : touches) {
    const double open = dot3(touch.normal, now.x[touch.node]) - touch.from - t * touch.way;
    if (open >= span * (2.0 * fastest + std::abs(touch.way) / frame)) continue;
    near.all.push_back(&touch);
    if (touch.shared) near.shared.push_back(&touch);
  }
  near.held.resize(near.all.size());
}

THEW_VECTORISED
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole, Near& near,
                    MuscleState& now, VolumeSums& sums) {
  const size_t before = near.holds;
  size_t holds = before;
  double rate = sums.rate, weighted = sums.weighted;  // in registers: each waits for the one before
  for (Touch* touch : near.all) {
    if (touch->held) continue;
    const int i = touch->node;
    const Row n = touch->normal;
    Row v = now.v[i];
    if (lambda != 0.0) v -= lambda * now.direction[i];
    const double open = dot3(n, now.x[i] + h * v) - touch->from - t * touch->way;
    if (open >= 0.0) continue;
    touch->held = true;
    Held& held = near.held[holds++];
    held = {touch, 0.0, -open / h};
    now.v[i] += held.kick * n;
    if (!has_volume) continue;
    const bool stored = whole || touch->shared;
    const double slope = dot3(n, now.gradient[i]);
    held.across = stored ? dot3(n, now.direction[i]) : now.mobility[i] * slope;
    rate += slope * held.kick;
    weighted -= slope * held.across;
    if (stored) now.direction[i] -= held.across * n;
  }
  sums.rate = rate;
  sums.weighted = weighted;
  near.holds = holds;
  return holds > before;
}

// Books what the planes gave: their own kicks, and what they bear of the multiplier's force, given
// back beforehand where advance() goes along all of d.
THEW_VECTORISED
void release_contacts(double lambda, bool whole, const Muscle& muscle, Near& near,
                      MuscleState& now) {
  Row impulse = {}, angular = {};
  for (size_t k = 0; k < near.holds; ++k) {
    const auto& [touch, across, kick] = near.held[k];
    const double given = muscle.mass[touch->node] * (kick + lambda * across);
    touch->pushed += given;
    if (!whole) now.v[touch->node] += lambda * across * touch->normal;
    const Row push = given * touch->normal;
    impulse += push;
    angular += cross3(now.x[touch->node], push);
    touch->held = false;
  }
  near.holds = 0;
  now.impulse += to_vec(impulse);
  now.angular_impulse += to_vec(angular);
}

}  // namespace thew
