// SPDX-License-Identifier: Apache-2.0
//
// The paper's semi-implicit Euler, eqs 9-14, with the weights in the denominator (method.md, mend
// 1): v+ = v + h f / m - lambda d, x+ = x + h v+, d = W dV/dx / m. All that changes a velocity is a
// force at the old positions, so linear and angular momentum change by what contact gives alone.
#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "muscles/weights.h"
#include "rig/vectorise.h"
#include "sim/drive.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

constexpr double kDashpot = 1e-4;  // s, damping of a spring over its stiffness
constexpr double kMargin = 0.8;    // of the stable step
constexpr int kContactRounds = 60;
constexpr int kLookEvery = 12;  // substeps, for touches that may close before the next look

// Always inlined: across two instruction sets vectors are passed in different registers.
[[gnu::always_inline]] inline double sum3(const Row& a) { return (a[0] + a[1]) + a[2]; }
[[gnu::always_inline]] inline double dot3(const Row& a, const Row& b) { return sum3(a * b); }
[[gnu::always_inline]] inline Row yzx(const Row& a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline Row cross3(const Row& a, const Row& b) {
  return yzx(a * yzx(b) - yzx(a) * b);
}

// A contact within a frame: a plane that goes from one place to another, normal . x = from + t way.
// One line of the cache; what a substep adds is in Held.
struct Touch {
  Row normal;
  double from, way;     // m, the gap included
  double pushed = 0.0;  // N s so far, all along the normal
  int node;
  bool held = false;    // in this substep
  bool shared = false;  // its node has another one
};
static_assert(sizeof(Touch) == 64);
using Touches = std::vector<Touch, AlignedAllocator<Touch>>;

// Over or under a face of a bone (not beside an edge) its own normal counts, so that nothing is
// left inside a plane.
Touch touch_of(const Model& model, const State& state, const Pose& pose_before,
               const Contact& contact, const Vec3& node) {
  const int muscles = static_cast<int>(model.muscles.size());
  const auto& b = contact.barycentric;
  Vec3 normal = contact.normal;
  Row before, after;
  if (contact.other < muscles) {
    const Triangle& t = model.muscles[contact.other].surface.triangles[contact.triangle];
    const Rows& x = state.muscles[contact.other].seen;
    before = after = b[0] * x[t[0]] + b[1] * x[t[1]] + b[2] * x[t[2]];
  } else {
    const Bone& bone = model.bones[contact.other - muscles];
    const Triangle& t = bone.surface.triangles[contact.triangle];
    const std::vector<Vec3>& y = bone.in_body.vertices;
    const Vec3 point = b[0] * y[t[0]] + b[1] * y[t[1]] + b[2] * y[t[2]];
    before = to_row(pose_before[bone.body] * point);
    after = to_row(state.pose[bone.body] * point);
    const Rows& y_now = state.bones[contact.other - muscles].x;
    const Vec3 face = face_normal(bone.surface, y_now, contact.triangle);
    const Vec3 away = node - to_vec(after);
    const bool inside = std::min({b[0], b[1], b[2]}) > 1e-9;
    if (inside || std::abs(away.dot(face)) >= 0.999 * away.norm() - 1e-7) normal = face;
  }
  const double from = normal.dot(to_vec(before)) + model.scene.contact.settings.gap;
  return {.normal = to_row(normal),
          .from = from,
          .way = normal.dot(to_vec(after - before)),
          .node = contact.node};
}

Touches touches_of(const Model& model, int m, double begin, const State& state) {
  Touches touches;
  if (state.muscles[m].contacts.empty()) return touches;
  std::vector<double> joints;
  Pose pose_before;
  joints_at(model, begin, joints);
  forward_kinematics(model.skeleton, joints, pose_before);
  for (const Contact& contact : state.muscles[m].contacts) {
    const Vec3 node = to_vec(state.muscles[m].x[contact.node]);
    touches.push_back(touch_of(model, state, pose_before, contact, node));
    const size_t last = touches.size() - 1;
    if (last > 0 && touches[last - 1].node == contact.node) {  // they come by node
      touches[last - 1].shared = touches[last].shared = true;
    }
  }
  return touches;
}

struct Held {
  Touch* touch;
  double across;  // m, part of the multiplier's direction that the plane bears
  double kick;    // m/s, in this substep
};
struct Near {
  std::vector<Touch*> all, shared;  // these have nodes of others as well
  std::vector<Held> held;           // in this substep
};

// Those that may close within `span` (s) from the part `t` of the frame on, were all twice as fast
// as now.
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
}

// What a spring has against leaving the carried shape's edge vectors.
void add_shape_forces(const Muscle& muscle, const Rows& target, const Rows& x, Rows& f) {
  const Springs& springs = muscle.springs;
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const Row force = muscle.settings.material.shape * springs.stiffness[k] *
                      (x[a] - x[b] - (target[a] - target[b]));
    f[a] -= force;
    f[b] += force;
  }
}

struct VolumeSums {
  double volume = 0.0;    // m^3
  double rate = 0.0;      // dV/dx . v, m^3/s
  double weighted = 0.0;  // dV/dx . d
};

// v += h f / m; with `kVolume` also the sums, in the same pass.
template <bool kVolume>
[[gnu::always_inline]] inline VolumeSums kick_nodes(const Muscle& muscle, const Row& gravity,
                                                    double h, const Rows& target, double damping,
                                                    MuscleState& now) {
  const double guide = muscle.settings.guide;
  const bool has_path = muscle.shape.held.empty();
  const Row origin = now.x.empty() ? Row{} : now.x[0];
  Row volume = {}, rate = {}, weighted = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    Row v = now.v[i];
    if (muscle.driven[i]) {
      v = now.target_velocity[i];
    } else {
      Row acceleration = gravity + now.inverse_mass[i] * now.forces[i] - damping * v;
      if (has_path)
        acceleration += guide * (target[i] - now.x[i]) + damping * now.target_velocity[i];
      v += h * acceleration;
    }
    now.v[i] = v;
    if (!kVolume) continue;
    const Row g = now.gradient[i];
    volume += (now.x[i] - origin) * g;
    rate += v * g;
    weighted += now.mobility[i] * (g * g);
  }
  return {sum3(volume) / 3.0, sum3(rate), sum3(weighted)};  // V = x . dV/dx / 3
}

THEW_VECTORISED
VolumeSums kick_with_volume(const Muscle& muscle, const Row& gravity, double h, const Rows& target,
                            double damping, MuscleState& now) {
  return kick_nodes<true>(muscle, gravity, h, target, damping, now);
}

THEW_VECTORISED
void kick_plainly(const Muscle& muscle, const Row& gravity, double h, const Rows& target,
                  MuscleState& now) {
  kick_nodes<false>(muscle, gravity, h, target, muscle.settings.damping, now);
}

// The multiplier's direction d = W dV/dx / m, from which contacts then take what they bear: of all
// nodes, or only of those that two planes may bear a part of; a pass through memory is not free.
THEW_VECTORISED
void set_direction(bool whole, const Near& near, MuscleState& now) {
  for (const Touch* touch : near.shared) {
    now.direction[touch->node] = now.mobility[touch->node] * now.gradient[touch->node];
  }
  for (size_t i = 0; whole && i < now.x.size(); ++i) {
    now.direction[i] = now.mobility[i] * now.gradient[i];
  }
}

THEW_VECTORISED
void advance(double h, double lambda, bool whole, MuscleState& now) {
  const size_t count = now.x.size();
  if (lambda == 0.0) {
    for (size_t i = 0; i < count; ++i) now.x[i] += h * now.v[i];
  } else if (whole) {
    for (size_t i = 0; i < count; ++i) {
      now.v[i] -= lambda * now.direction[i];
      now.x[i] += h * now.v[i];
    }
  } else {
    for (size_t i = 0; i < count; ++i) {
      now.v[i] -= lambda * now.mobility[i] * now.gradient[i];
      now.x[i] += h * now.v[i];
    }
  }
}

// Stops the nodes that would cross a plane by the part `t` of the frame, under `lambda`; from then
// on the multiplier no longer moves them across. True where there was one.
THEW_VECTORISED
bool close_contacts(double h, double t, double lambda, bool has_volume, bool whole, Near& near,
                    MuscleState& now, VolumeSums& sums) {
  const size_t before = near.held.size();
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
    near.held.push_back({touch, 0.0, -open / h});
    Held& held = near.held.back();
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
  return near.held.size() > before;
}

// Books what the planes gave: their own kicks, and what they bear of the multiplier's force, given
// back beforehand where advance() goes along all of d.
THEW_VECTORISED
void release_contacts(double lambda, bool whole, const Muscle& muscle, Near& near,
                      MuscleState& now) {
  Row impulse = {}, angular = {};
  for (const auto& [touch, across, kick] : near.held) {
    const double given = muscle.mass[touch->node] * (kick + lambda * across);
    touch->pushed += given;
    if (!whole) now.v[touch->node] += lambda * across * touch->normal;
    const Row push = given * touch->normal;
    impulse += push;
    angular += cross3(now.x[touch->node], push);
    touch->held = false;
  }
  near.held.clear();
  now.impulse += to_vec(impulse);
  now.angular_impulse += to_vec(angular);
}

// Without the weights.
double printed_denominator(const Muscle& muscle, const MuscleState& now) {
  Row even = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (!muscle.driven[i]) even += 1.0 / muscle.mass[i] * (now.gradient[i] * now.gradient[i]);
  }
  return sum3(even);
}

double linear_lambda(double rest_volume, double h, double denominator, const VolumeSums& sums,
                     MuscleState& now) {
  if (!(denominator > 0.0)) {
    ++now.unreached;
    return 0.0;
  }
  return ((sums.volume - rest_volume) / h + sums.rate) / denominator;
}

double exact_lambda(const Muscle& muscle, double h, MuscleState& now) {
  Rows& predicted = now.weighted;  // scratch here
  predicted.resize(now.x.size());
  for (size_t i = 0; i < now.x.size(); ++i) predicted[i] = now.x[i] + h * now.v[i];
  const VolumeRoot root = nearest_root(
      volume_along(predicted, now.direction, muscle.rest.triangles), muscle.rest_volume);
  if (!root.reached) ++now.unreached;
  return -root.s / h;
}

// Weighted forces do not cancel: where no bone holds the body, their net part would move it.
bool drifts(const Muscle& muscle, const MuscleState& now) {
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end()) return false;
  return muscle.settings.zone || std::any_of(now.weights.begin(), now.weights.end(),
                                             [&](double w) { return w != now.weights[0]; });
}

// Drag then slows the deformation alone, not the flight.
void keep_momentum(const Muscle& muscle, double h, MuscleState& now, VolumeSums& sums) {
  remove_net_motion(now.x, muscle.mass, now.direction);
  Rows& drag = now.weighted;  // scratch here
  drag.resize(now.x.size());
  for (size_t i = 0; i < drag.size(); ++i) drag[i] = -h * muscle.settings.damping * now.v[i];
  remove_net_motion(now.x, muscle.mass, drag);
  Row weighted = {}, rate = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.v[i] += drag[i];
    weighted += now.direction[i] * now.gradient[i];
    rate += now.v[i] * now.gradient[i];
  }
  sums.weighted = sum3(weighted);
  sums.rate = sum3(rate);
}

void note_volume(const Muscle& muscle, double volume, MuscleState& now) {
  now.volume_error = std::abs(volume / muscle.rest_volume - 1.0);
  now.substep_volume_error = std::max(now.substep_volume_error, now.volume_error);
}

// dV/dx . W dV/dx / m over the compliance, 1/s^2, at rest.
double penalty_frequency_squared(const Muscle& muscle) {
  Rows x, gradient;
  for (const Vec3& p : muscle.rest.vertices) x.push_back(to_row(p));
  volume_gradient(x, muscle.rest.triangles, gradient);
  double sum = 0.0;
  for (size_t i = 0; i < x.size(); ++i) {
    sum += muscle.weights[i] / muscle.mass[i] * sum3(gradient[i] * gradient[i]);
  }
  return sum / volume_compliance(muscle);
}

}  // namespace

int explicit_substeps(const Model& model, int m, double h) {
  const Muscle& muscle = model.muscles[m];
  double squared = (1.0 + muscle.settings.material.shape) *
                       highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven) +
                   muscle.settings.guide;
  if (model.volume == VolumeMethod::kPenalty) squared += penalty_frequency_squared(muscle);
  const double omega = std::sqrt(squared);
  const double zeta = 0.5 * kDashpot * omega;  // damping ratio of the fastest mode
  const double stable = 2.0 / omega * (std::sqrt(1.0 + zeta * zeta) - zeta);
  return std::max(1, static_cast<int>(std::ceil(h / (kMargin * stable))));
}

void step_explicit(const Model& model, int m, double time, double frame, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const VolumeMethod method = model.volume;
  const bool has_volume = method != VolumeMethod::kNone;
  const bool has_path = muscle.shape.held.empty();
  const bool removes = has_volume && drifts(muscle, now);
  const int substeps = explicit_substeps(model, m, frame);
  const double h = frame / substeps;
  const Row gravity = to_row(model.scene.gravity);
  Touches touches = touches_of(model, m, time - frame, state);
  now.x = now.start;
  now.gradient.resize(now.x.size());
  now.direction.resize(now.x.size());
  now.mobility.resize(now.x.size());
  now.inverse_mass.resize(now.x.size());
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.inverse_mass[i] = 1.0 / muscle.mass[i];
    now.mobility[i] = now.weights[i] / muscle.mass[i];
  }
  RingSprings rings;  // a copy only where rest lengths change inside the frame
  std::vector<double> rest_length(now.rest_length.size());
  Rows target = now.target;
  Near near;
  if (has_path) rings = muscle.rings;
  for (int step = 1; step <= substeps; ++step) {
    const double t = static_cast<double>(step) / substeps;
    for (size_t k = 0; has_path && k < rest_length.size(); ++k) {
      rest_length[k] = now.rest_before[k] + t * (now.rest_length[k] - now.rest_before[k]);
    }
    for (size_t i = 0; has_path && i < target.size(); ++i) {
      target[i] = now.target[i] - (frame - step * h) * now.target_velocity[i];
    }
    if (has_path) set_rest_lengths(rest_length, rings);
    ring_forces(has_path ? rings : muscle.rings, now.x, now.v, kDashpot, now.forces,
                has_volume ? &now.gradient : nullptr);
    if (muscle.settings.material.shape > 0.0) add_shape_forces(muscle, target, now.x, now.forces);
    if (step % kLookEvery == 1 || step == substeps) {
      look_for_near(t - 1.0 / substeps, frame, kLookEvery * h, now, touches, near);
    }
    VolumeSums sums;
    const bool exactly = method == VolumeMethod::kExactAlways ||
                         (method == VolumeMethod::kExact && step == substeps);
    const bool whole = removes || exactly;
    if (has_volume) {
      const double drag = removes ? 0.0 : muscle.settings.damping;
      sums = kick_with_volume(muscle, gravity, h, target, drag, now);
      if (step > 1) note_volume(muscle, sums.volume, now);
      set_direction(whole, near, now);
      if (removes) keep_momentum(muscle, h, now, sums);
    } else {
      kick_plainly(muscle, gravity, h, target, now);
    }
    double lambda = 0.0;
    bool closed = close_contacts(h, t, 0.0, has_volume, whole, near, now, sums);
    if (has_volume && !exactly) {  // contacts that this closes are the next substep's
      const bool printed = method == VolumeMethod::kPrinted;
      const double denominator = printed ? printed_denominator(muscle, now) : sums.weighted;
      lambda = method == VolumeMethod::kPenalty
                   ? h * (sums.volume - muscle.rest_volume) / volume_compliance(muscle)
                   : linear_lambda(muscle.rest_volume, h, denominator, sums, now);
    }
    // The linear multiplier, which needs no pass, finds nearly all that the exact one will close.
    const bool looks_ahead = exactly && step == substeps && sums.weighted > 0.0;
    for (int round = 0; looks_ahead && round < kContactRounds; ++round) {
      lambda = linear_lambda(muscle.rest_volume, h, sums.weighted, sums, now);
      if (!close_contacts(h, t, lambda, true, whole, near, now, sums)) break;
    }
    for (int round = 0; exactly && (round == 0 || closed) && round < kContactRounds; ++round) {
      lambda = exact_lambda(muscle, h, now);
      closed = step == substeps && close_contacts(h, t, lambda, true, whole, near, now, sums);
    }
    release_contacts(lambda, whole, muscle, near, now);
    advance(h, lambda, whole, now);
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) now.x[i] = now.target[i];  // without the substeps' rounding
  }
  if (has_path && (method == VolumeMethod::kExact || method == VolumeMethod::kExactAlways)) {
    restore_volume(muscle, VolumeMethod::kExact, now.direction, 0.0,
                   now.x);  // which that has moved
  }
  for (size_t c = 0; c < touches.size(); ++c) {
    now.push[c] = touches[c].pushed / (frame * contact_stiffness(muscle, touches[c].node));
  }
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace thew
