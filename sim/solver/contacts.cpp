// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/contacts.h"

#include <algorithm>
#include <cmath>

#include "sim/solver/rungs.h"
#include "skin/contact/face_contact.h"
#include "skin/contact/self_contact.h"
#include "skin/contact/sweep.h"

namespace thew::sim {

namespace {

void add_collider(const Model& model, int c, const Bvh& bvh, const Points& x,
                  const std::vector<char>* free_nodes, std::vector<Collider>& colliders) {
  const ContactSurface& it = model.surfaces[c];
  colliders.push_back({&it.surface, &bvh, &x, free_nodes});
  colliders.back().rigid_points = &it.rigid_points;
  colliders.back().thickness = it.thickness;
  if (!it.thicknesses.empty()) colliders.back().thicknesses = &it.thicknesses;
}

}  // namespace

std::vector<Collider> muscles_of(const Model& model, const State& state) {
  std::vector<Collider> colliders;
  set_muscles(model, state, colliders);
  return colliders;
}

void set_muscles(const Model& model, const State& state, std::vector<Collider>& colliders) {
  colliders.clear();
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    add_collider(model, m, now.bvh, now.x, &model.muscles[m].free_nodes, colliders);
  }
}

std::vector<Collider> colliders_of(const Model& model, const State& state) {
  std::vector<Collider> colliders;
  set_colliders(model, state, colliders);
  return colliders;
}

void set_colliders(const Model& model, const State& state, std::vector<Collider>& colliders) {
  set_muscles(model, state, colliders);
  for (const BoneState& bone : state.bones) {
    add_collider(model, static_cast<int>(colliders.size()), bone.bvh, bone.x, nullptr, colliders);
  }
}

void set_felt(const Model& model, const State& state, std::vector<Collider>& colliders) {
  set_colliders(model, state, colliders);
  size_t kept = 0;
  for (size_t c = 0; c < colliders.size(); ++c) {
    if (model.skin_feels[c]) colliders[kept++] = colliders[c];
  }
  colliders.resize(kept);
}

void set_props(const Model& model, State& state) {
  constexpr double kReach = 0.05;  // m, of a man
  // Of the gap that contact keeps: as near as it leaves flesh in a fast press, so that the skin
  // finds room between.
  constexpr double kGap = 0.1;
  std::vector<Collider>& colliders = state.props.colliders;
  colliders.clear();
  if (below_skin(model) == model.colliders() || !model.contact.enabled) return;
  set_colliders(model, state, colliders);
  colliders.erase(colliders.begin(), colliders.begin() + below_skin(model));
  state.props.gap = kGap * model.contact.settings.gap;
  state.props.reach = kReach * model.size;
}

namespace {

// Refits the tree of a collider.
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

MotionHistory& followed(State& state, int c) {
  return c < state.count() ? state.muscles[c].followed : state.bones[c - state.count()].followed;
}

}  // namespace

void update_colliders(const Model& model, State& state) {
  if (!model.contact.enabled) return;
  set_colliders(model, state, state.colliders);
  for (int c = 0; c < model.colliders(); ++c) {
    Collider& it = state.colliders[c];
    it.box = box_of(*it.x);
    it.soft = c < state.count();
    it.previous_iterate = it.soft ? &state.muscles[c].previous_iterate : it.x;
    if (it.soft) it.start = &state.muscles[c].start;
    const int body = model.surfaces[c].body;
    if (!it.soft && model.bones[c - state.count()].bends()) {
      it.start = &state.bones[c - state.count()].start;
      it.bent = state.bones[c - state.count()].bent;
    }
    if (it.soft || !state.body_moved[body] || state.pose_before.size() != state.pose.size())
      continue;
    it.to_start = state.pose_before[body] * state.pose[body].inverse();
    it.from_start = it.to_start.inverse();
  }
}

namespace {

// Finds the contacts of muscle m with the colliders `near` and with itself. Those of the step
// before become previous_contacts; the ones that bore a force are kept longest.
void find_contacts_of(const Model& model, int m, const ContactSettings& settings,
                      const std::vector<int>& near, State& state) {
  MuscleState& now = state.muscles[m];
  std::swap(now.previous_contacts, static_cast<ContactMotion&>(now));
  now.loaded_contacts.clear();
  for (size_t c = 0; c < now.previous_contacts.contacts.size(); ++c) {
    if (now.previous_contacts.normal_multiplier[c] > 0.0)
      now.loaded_contacts.push_back(now.previous_contacts.contacts[c]);
  }
  find_contacts(state.colliders, m, near, settings, now.loaded_contacts, now.memory, now.contacts);
  find_face_contacts(state.colliders, m, near, settings, now.loaded_contacts, now.face_memory,
                     now.contacts);
  if (!model.ignore[m][m] && !ignores_pair(state, m, m)) {
    find_self_contacts(state.colliders[m], m, settings, now.previous_contacts.contacts,
                       now.self_candidates, now.contacts);
  }
  keep_multipliers(now.previous_contacts, model.contact.friction > 0.0, now);
}

}  // namespace

void find_all_contacts(const Model& model, Parallel& parallel, State& state) {
  const auto searches = [&](int m) { return has_forces(state.muscles[m].level); };
  bool any = false;
  for (int m = 0; m < state.count(); ++m) any = any || searches(m);
  if (!model.contact.enabled || !any) return;
  ContactSettings settings = model.contact.settings;
  double thickest = 0.0;
  for (const Collider& collider : state.colliders) {
    thickest = std::max(thickest, collider.thickness);
    if (!collider.thicknesses) continue;
    for (const double at_node : *collider.thicknesses) thickest = std::max(thickest, at_node);
  }
  settings.margin += 2.0 * thickest;
  for (int c = 0; c < model.colliders(); ++c) {
    MotionHistory& body = followed(state, c);
    body.advance(*state.colliders[c].x);
    state.colliders[c].history = &body;
  }
  find_candidate_pairs(state.colliders, settings, state.near_pairs);
  std::vector<std::vector<int>>& near = state.near_pairs.near;
  for (int m = 0; m < state.count(); ++m) {
    if (!searches(m)) continue;
    bool& wanted = state.colliders[m].searched;
    wanted = wanted || !model.ignore[m][m];
    std::erase_if(near[m], [&](int other) {
      return model.ignore[m][other] != 0 || ignores_pair(state, m, other);
    });
    for (const int other : near[m]) wanted = state.colliders[other].searched = true;
  }
  parallel.each(model.colliders(), [&](int c) {
    const Collider& it = state.colliders[c];
    if (!it.searched) return;
    refit(model, c, state);
    MotionHistory& body = followed(state, c);
    note_parts(*it.surface, *it.bvh, *it.x, body.before, body.parts);
  });
  parallel.each(state.count(), [&](int m) {
    if (searches(m)) find_contacts_of(model, m, settings, near[m], state);
  });
}

std::optional<StepDiagnosis> find_tunnelling(const Model& model, State& state) {
  if (!model.contact.enabled || state.pose_before.size() != state.pose.size()) return {};
  const double depth = model.contact.settings.max_depth;
  std::optional<StepDiagnosis> worst;
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    if (!has_forces(now.level)) continue;
    const BodyMotion way = body_motion(now.start, now.x);
    for (size_t b = 0; b < model.bones.size(); ++b) {
      const int c = state.count() + static_cast<int>(b);
      if (model.ignore[m][c] || ignores_pair(state, m, c)) continue;
      if (!may_tunnel(way, state.colliders[c], state.bones[b].displacement, depth)) continue;
      fit_bone(model, static_cast<int>(b), state);
      const Tunnelling tunnelling =
          find_tunnelling(now.start, now.x, model.muscles[m].free_nodes, state.colliders[c], depth,
                          model.lengths.march_step);
      if (tunnelling.inside <= (worst ? worst->value : depth)) continue;
      worst = StepDiagnosis{"muscle \"" + model.muscles[m].name + "\"",
                            tunnelling.node,
                            Cause::kTunnelling,
                            tunnelling.inside,
                            depth,
                            m,
                            c};
      worst->displacement = tunnelling.distance;
      worst->divisor = static_cast<int>(std::ceil(std::min(tunnelling.distance / depth, 1e6)));
    }
  }
  return worst;
}

}  // namespace thew::sim
