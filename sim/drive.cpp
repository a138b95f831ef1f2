// SPDX-License-Identifier: Apache-2.0
#include "sim/drive.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "muscles/weights.h"
#include "rig/math.h"
#include "rig/vectorise.h"
#include "sim/character_rig.h"
#include "skin/face_contact.h"
#include "skin/self_contact.h"

namespace thew {

double bind_to_first_ends(const Model& model) {
  if (is_animated(model)) return -0.5 * model.settle;
  std::vector<double> first;
  sample_clip(model.clip, model.skeleton, 0.0, first);
  const bool moves = std::any_of(first.begin(), first.end(), [](double q) { return q != 0.0; });
  return moves ? -0.5 * model.settle : -model.settle;
}

void joints_at(const Model& model, double time, std::vector<double>& joints) {
  sample_clip(model.clip, model.skeleton, std::max(time, 0.0), joints);
  if (time >= 0.0) return;
  const double part = smoothstep(-model.settle, -0.5 * model.settle, time);
  for (double& value : joints) value *= part;
}

namespace {

void pose_bodies(const Model& model, double time, State& state) {
  joints_at(model, time, state.joints);
  forward_kinematics(model.skeleton, state.joints, state.pose);
  if (model.character) drive_character(model, time, state);
}

// The most that a node moves, m.
THEW_VECTORISED
double place_bone(const Bone& bone, const Transform& place, Rows& x) {
  const Row along[3] = {to_row(place.linear().col(0)), to_row(place.linear().col(1)),
                        to_row(place.linear().col(2))};
  const Row origin = to_row(place.translation());
  double squared = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    const Vec3& p = bone.in_body.vertices[i];
    const Row to = p.x() * along[0] + p.y() * along[1] + p.z() * along[2] + origin, d = to - x[i];
    squared = std::max(squared, sum3(d * d));
    x[i] = to;
  }
  return std::sqrt(squared);
}

}  // namespace

double turn_until(const Model& model, double time, const State& state) {
  State then;
  pose_bodies(model, time, then);
  double most = 0.0;
  for (int b = 0; b < model.skeleton.size(); ++b) {
    const int parent = model.skeleton.parent[b];
    if (parent < 0) continue;
    const auto bend = [&](const Pose& pose) -> Mat3 {
      return pose[parent].linear().transpose() * pose[b].linear();
    };
    const Mat3 turn = bend(state.pose).transpose() * bend(then.pose);
    const Vec3 twice_sine(turn(2, 1) - turn(1, 2), turn(0, 2) - turn(2, 0),
                          turn(1, 0) - turn(0, 1));
    most = std::max(most, arc_tan2(0.5 * twice_sine.norm(), 0.5 * (turn.trace() - 1.0)));
  }
  return most;
}

void drive_bones(const Model& model, double time, State& state) {
  state.pose_before = state.pose;
  const Pose& before = state.pose_before;
  pose_bodies(model, time, state);
  const bool anew = before.size() != state.pose.size() || state.taken_back;
  state.taken_back = false;
  state.body_moved.assign(state.pose.size(), 1);
  for (size_t b = 0; b < state.pose.size() && !anew; ++b) {
    state.body_moved[b] = before[b].matrix() != state.pose[b].matrix();
  }
  for (size_t b = 0; b < model.bones.size(); ++b) {
    const Bone& bone = model.bones[b];
    BoneState& now = state.bones[b];
    now.moved = 0.0;
    if (!state.body_moved[bone.body]) continue;
    now.moved = place_bone(bone, state.pose[bone.body], now.x);
    now.fitted = false;
  }
}

double activation_at(const Model& model, int m, double time) {
  WeightProfile curve;
  curve.keys = model.muscles[m].settings.activation;
  if (curve.keys.empty()) return 0.0;
  return profile_weight(curve, model.first_frame + time * model.fps);
}

namespace {

void add_collider(const Model& model, int c, const Bvh& bvh, const Rows& x,
                  const std::vector<char>* free_nodes, std::vector<Collider>& colliders) {
  const ContactSurface& it = model.surfaces[c];
  colliders.push_back({&it.surface, &bvh, &x, free_nodes});
  colliders.back().held_points = &it.held_points;
  colliders.back().thickness = it.thickness;
}

}  // namespace

std::vector<Collider> muscles_of(const Model& model, const State& state) {
  std::vector<Collider> colliders;
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    add_collider(model, m, now.bvh, now.x, &model.muscles[m].free_nodes, colliders);
  }
  return colliders;
}

std::vector<Collider> colliders_of(const Model& model, const State& state) {
  std::vector<Collider> colliders = muscles_of(model, state);
  for (const BoneState& bone : state.bones) {
    add_collider(model, static_cast<int>(colliders.size()), bone.bvh, bone.x, nullptr, colliders);
  }
  return colliders;
}

namespace {

// The tree of a collider.
void refit(const Model& model, int c, State& state) {
  if (c < state.count()) {
    refit_bvh(model.surfaces[c].surface, state.muscles[c].x, state.muscles[c].bvh);
    return;
  }
  fit_bone(model, c - state.count(), state);
}

}  // namespace

void fit_bone(const Model& model, int b, State& state) {
  BoneState& bone = state.bones[b];
  const Surface& surface = model.surfaces[state.muscles.size() + b].surface;
  if (!bone.fitted) refit_bvh(surface, bone.x, bone.bvh);
  bone.fitted = true;
}

void refit_all(const Model& model, Parallel& parallel, State& state) {
  parallel.each(model.colliders(), [&](int c) { refit(model, c, state); });
}

namespace {

Followed& followed(State& state, int c) {
  return c < state.count() ? state.muscles[c].followed : state.bones[c - state.count()].followed;
}

// Contacts that go on keep their multipliers, those that hold as one the one that they have.
void keep_pushes(bool friction, MuscleState& now) {
  const std::vector<Contact>&before = now.contacts_before, &after = now.contacts;
  now.push.assign(after.size(), 0.0);
  if (friction) now.grip.assign(after.size(), Row{});
  const auto key = [](const Contact& c) { return std::tuple(c.node, c.other, c.of_face); };
  size_t old = 0;
  for (size_t c = 0; c < after.size(); c = end_of_one(after, c)) {
    while (old < before.size() && key(before[old]) < key(after[c])) ++old;
    if (old == before.size() || key(before[old]) != key(after[c])) continue;
    now.push[c] = now.push_before[pressing_one(now.push_before, old, end_of_one(before, old))];
    if (old < now.grip_before.size()) now.grip[c] = now.grip_before[old];
  }
}

}  // namespace

void find_all_contacts(const Model& model, Parallel& parallel, State& state) {
  ContactSettings settings = model.contact.settings;
  const auto searches = [&](int m) { return has_forces(state.muscles[m].level); };
  bool any = false;
  for (int m = 0; m < state.count(); ++m) any = any || searches(m);
  if (!model.contact.enabled || !any) return;
  std::vector<Collider> colliders = colliders_of(model, state);
  double thickest = 0.0;
  for (const Collider& collider : colliders) thickest = std::max(thickest, collider.thickness);
  settings.margin += 2.0 * thickest;
  for (size_t c = 0; c < colliders.size(); ++c) {
    Followed& body = followed(state, static_cast<int>(c));
    body.go_on(*colliders[c].x);
    colliders[c].followed = &body;
    colliders[c].box = box_of(*colliders[c].x);
  }
  std::vector<std::vector<int>> near = near_pairs(colliders, settings);
  std::vector<char> wanted(colliders.size(), 0);
  for (int m = 0; m < state.count(); ++m) {
    if (!searches(m)) continue;
    if (!model.ignore[m][m]) wanted[m] = 1;
    std::erase_if(near[m], [&](int other) { return model.ignore[m][other] != 0; });
    for (const int other : near[m]) wanted[m] = wanted[other] = 1;
  }
  parallel.each(static_cast<int>(colliders.size()), [&](int c) {
    if (!wanted[c]) return;
    refit(model, c, state);
    const Collider& it = colliders[c];
    Followed& body = followed(state, c);
    note_parts(*it.surface, *it.bvh, *it.x, body.before, body.parts);
  });
  parallel.each(state.count(), [&](int m) {
    MuscleState& now = state.muscles[m];
    if (!searches(m)) return;
    now.contacts_before.swap(now.contacts);
    now.push_before.swap(now.push);
    now.grip_before.swap(now.grip);
    now.pressing.clear();
    for (size_t c = 0; c < now.contacts_before.size(); ++c) {
      if (now.push_before[c] > 0.0) now.pressing.push_back(now.contacts_before[c]);
    }
    find_contacts(colliders, m, near[m], settings, now.pressing, now.memory, now.contacts);
    find_face_contacts(colliders, m, near[m], settings, now.pressing, now.face_memory,
                       now.contacts);
    if (!model.ignore[m][m]) {
      find_self_contacts(colliders[m], m, settings, now.contacts_before, now.contacts);
    }
    keep_pushes(model.contact.friction > 0.0, now);
  });
}

}  // namespace thew
