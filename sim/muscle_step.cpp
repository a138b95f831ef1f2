// SPDX-License-Identifier: Apache-2.0
#include "sim/muscle_step.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <span>

#include "muscles/activation.h"
#include "muscles/volume.h"
#include "muscles/zone.h"
#include "rig/vectorise.h"

namespace thew {
namespace {

// Rest shape of the springs is drawn a little tighter than the carried shape: springs under tension
// do not wrinkle, and the multiplier supplies the rest of the volume.
constexpr double kTightness = 0.98;

// Share of a muscle's force that its surface carries; the rest runs through the inside, which a
// surface model does not have.
constexpr double kSurfaceShare = 0.01;

// "Target shape": every spring rests at its length in the carried shape. "Weights alone": along the
// fibres rest lengths follow the path, across them they keep the rest shape's.
void set_rest_lengths(const Muscle& muscle, const Rows& tight, MuscleState& state) {
  const Springs& springs = muscle.springs;
  if (!muscle.shape.held.empty()) {
    state.rest_length = springs.rest_length;
    return;
  }
  if (muscle.swells) {
    spring_lengths(springs, tight, state.rest_length);
    return;
  }
  state.rest_length.resize(springs.nodes.size());
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double stretch =
        0.5 * (stretch_at(muscle.shape, state.pose, a) + stretch_at(muscle.shape, state.pose, b));
    const double along = springs.fibre_share[k];  // cos^2 to the fibres
    state.rest_length[k] =
        springs.rest_length[k] * std::sqrt(along * stretch * stretch + 1.0 - along);
  }
}

// Tension (Hill) as a shortening of the fibres' springs: each of the `abreast` springs that cross a
// section carries its part.
void activate(const Muscle& muscle, double activation, double path_velocity, MuscleState& state) {
  if (muscle.settings.f_max <= 0.0 || activation <= 0.0) return;
  const Springs& springs = muscle.springs;
  const double belly = muscle.shape.belly[1] - muscle.shape.belly[0];
  const double fibre = muscle.settings.fibre_length;
  const double tension =
      kSurfaceShare * muscle_tension(muscle.settings.f_max, activation,
                                     1.0 + state.pose.change / fibre, path_velocity / fibre);
  double abreast = 0.0;
  for (int k = 0; k < springs.structural; ++k) {
    abreast += springs.fibre_share[k] * springs.rest_length[k] / belly;
  }
  for (int k = 0; k < springs.structural; ++k) {
    const double shortening = tension / abreast * springs.fibre_share[k] / springs.stiffness[k];
    state.rest_length[k] = std::max(state.rest_length[k] - shortening, 0.2 * state.rest_length[k]);
  }
}

}  // namespace

void carry_muscle(const Muscle& muscle, const Pose& pose, double activation, double h,
                  MuscleState& state) {
  const double length_before = state.path_length;
  state.target_velocity.swap(state.target);  // the target before
  state.pose = carry_pose(muscle.shape, pose);
  state.path_length = state.pose.path_length;
  Rows& tight = state.seen;  // scratch here
  carried_positions(muscle.shape, state.pose, muscle.swells, state.target, kTightness,
                    muscle.swells ? &tight : nullptr);
  for (size_t i = 0; i < state.target.size(); ++i) {
    state.target_velocity[i] = (state.target[i] - state.target_velocity[i]) * (1.0 / h);
  }
  state.rest_before.swap(state.rest_length);
  set_rest_lengths(muscle, tight, state);
  activate(muscle, activation, (state.path_length - length_before) / h, state);
}

THEW_VECTORISED
void predict(const Muscle& muscle, double h, MuscleState& state) {
  state.start = state.x;
  for (size_t i = 0; i < state.x.size(); ++i) {
    state.x[i] = muscle.driven[i] ? state.target[i] : state.start[i] + h * state.target_velocity[i];
  }
}

void update_zone(const Muscle& muscle, double h, MuscleState& state) {
  if (!muscle.settings.zone) return;
  std::vector<int> loaded;
  Vec3 load = Vec3::Zero();
  for (size_t c = 0; c < state.contacts.size(); ++c) {
    if (state.push[c] <= 0.0) continue;
    const int node = state.contacts[c].node;
    if (loaded.empty() || loaded.back() != node) loaded.push_back(node);
    load += state.push[c] * muscle.contact_stiffness[node] * state.contacts[c].normal;
  }
  const ZoneSettings& zone = *muscle.settings.zone;
  if (loaded.empty()) {
    state.zone_radius = 0.0;
    state.weights = muscle.weights;
    return;
  }
  const double softness = SpringMaterial{}.young / muscle.settings.material.young;
  state.zone_radius = grown_radius(zone, std::max(state.zone_radius, zone.smallest_radius),
                                   softness * load.norm(), h);
  state.weights = zone_weights(muscle.rest, loaded, load.normalized(), zone, state.zone_radius);
  double sum = 0.0;
  for (size_t i = 0; i < state.weights.size(); ++i) {
    if (muscle.driven[i]) state.weights[i] = 0.0;
    sum += state.weights[i];
  }
  if (!(sum > 0.0)) state.weights = muscle.weights;
}

const Surface& other_surface(const Model& model, const Contact& contact) {
  return model.surfaces[contact.other].surface;
}

const Rows& other_seen(const State& state, const Contact& contact) {
  return contact.other < state.count() ? state.muscles[contact.other].seen
                                       : state.bones[contact.other - state.count()].x;
}

Row contact_point(const Model& model, const Contact& contact, const Rows& other) {
  const Triangle& t = other_surface(model, contact).triangles[contact.triangle];
  const auto& b = contact.barycentric;
  return b[0] * other[t[0]] + b[1] * other[t[1]] + b[2] * other[t[2]];
}

double contact_gap(const Model& model, const State& state, const Contact& contact, const Row& x,
                   double wanted) {
  const Rows& other = other_seen(state, contact);
  const Triangle& t = other_surface(model, contact).triangles[contact.triangle];
  const Row d = x - contact.barycentric[0] * other[t[0]] - contact.barycentric[1] * other[t[1]] -
                contact.barycentric[2] * other[t[2]];
  return contact.normal.x() * d[0] + contact.normal.y() * d[1] + contact.normal.z() * d[2] -
         (wanted + contact.offset);
}

bool is_shared(const Model& model, const Contact& contact) {
  return contact.other < static_cast<int>(model.muscles.size()) && !contact.of_face;
}

double volume_compliance(const Muscle& muscle) {
  constexpr double kBulk = 1e5;  // Pa
  return muscle.rest_volume / kBulk;
}

THEW_VECTORISED
void see(MuscleState& state) {
  state.seen.resize(state.x.size());
  double squared = 0.0;
  for (size_t i = 0; i < state.x.size(); ++i) {
    const Row d = state.x[i] - state.seen[i];
    squared = std::max(squared, dot(d, d));
    state.seen[i] = state.x[i];
  }
  state.moved = std::sqrt(squared);
}

bool is_solved(const Model& model, int iterations, const State& state) {
  constexpr int kMost = 20000;
  if (model.fidelity) {
    const auto& all = model.fidelity->muscles;
    return std::all_of(all.begin(), all.end(),
                       [&](const auto& muscle) { return iterations >= muscle.iterations; });
  }
  if (iterations < model.solver.iterations) return false;
  if (model.solver.integrator != Integrator::kQuasiStatic) return true;
  for (int m = 0; m < state.count(); ++m) {
    const double moved = state.muscles[m].moved;
    if (moved <= model.lengths.converged) continue;
    if (iterations < kMost) return false;
    char numbers[200];
    std::snprintf(
        numbers, sizeof numbers,
        "\" at %.4f s: an iteration still moves a node by %.3g m after %d of them; let it "
        "move with inertia, by local_global",
        state.time, moved, iterations);
    throw Error(ExitCode::kSolver, "muscle \"" + model.muscles[m].name + numbers);
  }
  return true;
}

THEW_VECTORISED
bool restore_volume(const Muscle& muscle, VolumeMethod method, const Rows& direction,
                    double printed_denominator, Rows& x) {
  if (method == VolumeMethod::kNone) return true;
  const VolumeCubic cubic = volume_along(x, direction, muscle.rest.triangles);
  VolumeRoot root;
  if (method == VolumeMethod::kExact) {
    root = nearest_root(cubic, muscle.rest_volume);
  } else {
    double denominator = method == VolumeMethod::kPrinted ? printed_denominator : cubic.c1;
    if (method == VolumeMethod::kPenalty) denominator += volume_compliance(muscle);
    root.reached = denominator != 0.0;
    if (root.reached) root.s = (muscle.rest_volume - cubic.c0) / denominator;
  }
  for (size_t i = 0; i < x.size(); ++i) x[i] += root.s * direction[i];
  return root.reached;
}

void zone_targets(const Muscle& muscle, const Rows& target, std::vector<double>& before) {
  before = muscle.zones.rest_before;
  if (!muscle.swells) return;
  volumes_before(muscle.zones, target, muscle.rest.triangles, before);
  const double scale = muscle.rest_volume / before.back();
  for (double& volume : before) volume *= scale;
}

void restore_zones(const Muscle& muscle, MuscleState& now) {
  now.zone_fallbacks += !restore_zones(muscle.zones, muscle.rest.triangles, now.zone_targets,
                                       now.zone_directions, now.zone_scratch, now.x);
}

namespace {

constexpr int kFinishRounds = 30;

// Moves the nodes of muscle m that penetrate out along their contacts' normals, which `freed` then
// leave alone. True where there was one beyond rounding.
bool push_out(const Model& model, State& state, int m, bool with_muscles, double gap,
              std::span<Rows> freed) {
  MuscleState& now = state.muscles[m];
  bool moves = false;
  for (const Contact& contact : now.contacts) {
    const bool soft = is_shared(model, contact);
    if (soft && !with_muscles) continue;
    Row& x = now.x[contact.node];
    const Row n = to_row(contact.normal);
    const double open = contact_gap(model, state, contact, x, gap);
    if (open >= (with_muscles ? 0.0 : -kNodeRounding)) continue;
    moves = true;
    x -= (soft ? 0.5 : 1.0) * open * n;
    for (Rows& direction : freed) {
      Row& z = direction[contact.node];
      z -= dot(n, z) * n;
    }
  }
  return moves;
}

}  // namespace

void finish_muscle(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const double gap = model.contact.settings.gap;
  const bool exact = model.solver.volume == VolumeMethod::kExact;
  // The directions without what contact holds, that of the whole last.
  const bool zoned = !now.zone_directions.empty();
  const std::span<Rows> freed =
      zoned ? std::span(now.zone_directions) : std::span(&now.gradient, 1);
  freed.back() = now.direction;
  // Rounds, since the volume moves other nodes into bone; two soft surfaces share the way, once.
  bool moves = push_out(model, state, m, true, gap, freed);
  for (int round = 0; exact && (moves || round == 0) && round < kFinishRounds; ++round) {
    if (zoned) restore_zones(muscle, now);
    if (!restore_volume(muscle, model.solver.volume, freed.back(), 0.0, now.x)) {
      now.unreached += !restore_volume(muscle, model.solver.volume, now.direction, 0.0, now.x);
      moves = false;
      break;
    }
    moves = push_out(model, state, m, false, gap, freed);
  }
  // Pinched between two there is no end to the rounds: the volume has the last word.
  if (exact && moves) restore_volume(muscle, model.solver.volume, now.direction, 0.0, now.x);
  for (size_t i = 0; i < now.x.size(); ++i) now.v[i] = (now.x[i] - now.start[i]) * (1.0 / h);
  const double volume = enclosed_volume(now.x, muscle.rest.triangles);
  const double error = std::abs(volume / muscle.rest_volume - 1.0);
  now.volume_error = error;
  now.substep_volume_error = std::max(now.substep_volume_error, error);
}

}  // namespace thew
