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
constexpr int kContactRounds = 12;

double sum3(const Row& a) { return (a[0] + a[1]) + a[2]; }
double dot3(const Row& a, const Row& b) { return sum3(a * b); }
Row cross3(const Row& a, const Row& b) { return to_row(to_vec(a).cross(to_vec(b))); }

// A contact within a frame: a plane that goes from one place to another.
struct Touch {
  int node;
  Row normal, before, after;
  double pushed = 0.0;  // N s so far
  bool held = false;    // in this substep
};

// On a face of a bone its own normal counts, so that nothing is left inside a plane.
Touch touch_of(const Model& model, const State& state, const Pose& pose_before,
               const Contact& contact) {
  const int muscles = static_cast<int>(model.muscles.size());
  const auto& b = contact.barycentric;
  Touch touch{contact.node, to_row(contact.normal), Row{}, Row{}};
  if (contact.other < muscles) {
    const Triangle& t = model.muscles[contact.other].surface.triangles[contact.triangle];
    const Rows& x = state.muscles[contact.other].seen;
    touch.before = touch.after = b[0] * x[t[0]] + b[1] * x[t[1]] + b[2] * x[t[2]];
    return touch;
  }
  const Bone& bone = model.bones[contact.other - muscles];
  const Triangle& t = bone.surface.triangles[contact.triangle];
  const std::vector<Vec3>& y = bone.in_body.vertices;
  const Vec3 point = b[0] * y[t[0]] + b[1] * y[t[1]] + b[2] * y[t[2]];
  touch.before = to_row(pose_before[bone.body] * point);
  touch.after = to_row(state.pose[bone.body] * point);
  if (std::min({b[0], b[1], b[2]}) > 1e-9) {
    touch.normal =
        to_row(face_normal(bone.surface, state.bones[contact.other - muscles].x, contact.triangle));
  }
  return touch;
}

std::vector<Touch> touches_of(const Model& model, int m, double begin, const State& state) {
  std::vector<Touch> touches;
  if (state.muscles[m].contacts.empty()) return touches;
  std::vector<double> joints;
  Pose pose_before;
  joints_at(model, begin, joints);
  forward_kinematics(model.skeleton, joints, pose_before);
  for (const Contact& contact : state.muscles[m].contacts) {
    touches.push_back(touch_of(model, state, pose_before, contact));
  }
  return touches;
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
  double even = 0.0;      // dV/dx . dV/dx / m: the printed denominator
};

// v += h f / m; with `kVolume` also d and the sums, in the same pass.
template <bool kVolume>
[[gnu::always_inline]] inline VolumeSums kick_nodes(const Muscle& muscle, const Row& gravity,
                                                    double h, const Rows& target,
                                                    MuscleState& now) {
  const double guide = muscle.settings.guide, damping = muscle.settings.damping;
  const Row origin = now.x.empty() ? Row{} : now.x[0];
  Row volume = {}, rate = {}, weighted = {}, even = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    Row v = now.v[i];
    const double per_mass = 1.0 / muscle.mass[i];
    if (muscle.driven[i]) {
      v = now.target_velocity[i];
    } else {
      v += h * (gravity + guide * (target[i] - now.x[i]) + damping * (now.target_velocity[i] - v) +
                per_mass * now.forces[i]);
    }
    now.v[i] = v;
    if (!kVolume) continue;
    const Row g = now.gradient[i];
    const Row d = now.weights[i] * per_mass * g;  // the weights are 0 where driven
    now.direction[i] = d;
    volume += (now.x[i] - origin) * g;
    rate += v * g;
    weighted += d * g;
    if (!muscle.driven[i]) even += per_mass * (g * g);
  }
  return {sum3(volume) / 3.0, sum3(rate), sum3(weighted), sum3(even)};  // V = x . dV/dx / 3
}

THEW_VECTORISED
VolumeSums kick_with_volume(const Muscle& muscle, const Row& gravity, double h, const Rows& target,
                            MuscleState& now) {
  return kick_nodes<true>(muscle, gravity, h, target, now);
}

THEW_VECTORISED
void kick_plainly(const Muscle& muscle, const Row& gravity, double h, const Rows& target,
                  MuscleState& now) {
  kick_nodes<false>(muscle, gravity, h, target, now);
}

THEW_VECTORISED
void advance(double h, double lambda, MuscleState& now) {
  if (lambda == 0.0) {
    for (size_t i = 0; i < now.x.size(); ++i) now.x[i] += h * now.v[i];
    return;
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.v[i] -= lambda * now.direction[i];
    now.x[i] += h * now.v[i];
  }
}

// One substep's contacts and multiplier; `t` in 0..1 is its end in the frame.
struct Substep {
  const Muscle& muscle;
  double h, t, gap;
  bool has_volume;
  std::vector<Touch>& touches;
  MuscleState& now;
  VolumeSums sums;

  double opening(const Touch& touch, const Row& v) const {
    const Row point = touch.before + t * (touch.after - touch.before);
    return dot3(touch.normal, now.x[touch.node] + h * v - point) - gap;
  }

  // The plane stops the node, and the multiplier no longer moves it across.
  void hold(Touch& touch, double open) {
    const int i = touch.node;
    const Row kick = -open / h * touch.normal;
    now.v[i] += kick;
    touch.pushed -= muscle.mass[i] * open / h;
    now.impulse += muscle.mass[i] * kick;
    now.angular_impulse += cross3(now.x[i], muscle.mass[i] * kick);
    if (!has_volume) return;
    const Row across = dot3(touch.normal, now.direction[i]) * touch.normal;
    sums.rate += dot3(now.gradient[i], kick);
    sums.weighted -= dot3(now.gradient[i], across);
    now.direction[i] -= across;
    lost.push_back({&touch, across});
    touch.held = true;
  }
  std::vector<std::pair<Touch*, Row>> lost;  // what the planes bear of the multiplier's force

  // True where another contact closes under `lambda`.
  bool close_contacts(double lambda) {
    bool closed = false;
    for (Touch& touch : touches) {
      const Row d = has_volume ? now.direction[touch.node] : Row{};
      const double open = opening(touch, now.v[touch.node] - lambda * d);
      if (open >= -1e-12 * (touch.held ? 1.0 : 0.0)) continue;
      hold(touch, open);
      closed = true;
    }
    return closed;
  }

  double linear(double rest_volume, double denominator) {
    if (!(denominator > 0.0)) {
      ++now.unreached;
      return 0.0;
    }
    return ((sums.volume - rest_volume) / h + sums.rate) / denominator;
  }

  double exact(double rest_volume) {
    Rows& predicted = now.weighted;  // scratch here
    predicted.resize(now.x.size());
    for (size_t i = 0; i < now.x.size(); ++i) predicted[i] = now.x[i] + h * now.v[i];
    const VolumeRoot root =
        nearest_root(volume_along(predicted, now.direction, muscle.rest.triangles), rest_volume);
    if (!root.reached) ++now.unreached;
    return -root.s / h;
  }

  void bear(double lambda) {
    for (const auto& [touch, across] : lost) {
      const double mass = muscle.mass[touch->node];
      now.impulse += lambda * mass * across;
      now.angular_impulse += cross3(now.x[touch->node], lambda * mass * across);
      touch->pushed += lambda * mass * dot3(across, touch->normal);
    }
  }
};

// Weighted forces do not cancel: where no bone holds the body, their net part would move it.
bool drifts(const Muscle& muscle, const MuscleState& now) {
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end()) return false;
  return std::any_of(now.weights.begin(), now.weights.end(),
                     [&](double w) { return w != now.weights[0]; });
}

void keep_momentum(const Muscle& muscle, MuscleState& now, VolumeSums& sums) {
  remove_net_motion(now.x, muscle.mass, now.direction);
  Row weighted = {};
  for (size_t i = 0; i < now.x.size(); ++i) weighted += now.direction[i] * now.gradient[i];
  sums.weighted = sum3(weighted);
}

void note_volume(const Muscle& muscle, double volume, MuscleState& now) {
  now.volume_error = std::abs(volume / muscle.rest_volume - 1.0);
  now.substep_volume_error = std::max(now.substep_volume_error, now.volume_error);
}

}  // namespace

int explicit_substeps(const Muscle& muscle, double h) {
  const double omega =
      std::sqrt((1.0 + muscle.settings.material.shape) *
                    highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven) +
                muscle.settings.guide);
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
  const int substeps = std::max(model.scene.solver.substeps, explicit_substeps(muscle, frame));
  const double h = frame / substeps;
  const Row gravity = to_row(model.scene.gravity);
  std::vector<Touch> touches = touches_of(model, m, time - frame, state);
  now.x = now.start;
  now.gradient.resize(now.x.size());
  now.direction.resize(now.x.size());
  RingSprings rings;  // a copy only where rest lengths change inside the frame
  std::vector<double> rest_length(now.rest_length.size());
  Rows target = now.target;
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
    Substep sub{muscle, h, t, model.scene.contact.settings.gap, has_volume, touches, now, {}, {}};
    if (has_volume) {
      sub.sums = kick_with_volume(muscle, gravity, h, target, now);
      if (step > 1) note_volume(muscle, sub.sums.volume, now);
      if (removes) keep_momentum(muscle, now, sub.sums);
    } else {
      kick_plainly(muscle, gravity, h, target, now);
    }
    for (Touch& touch : touches) touch.held = false;
    const bool exactly = method == VolumeMethod::kExactAlways ||
                         (method == VolumeMethod::kExact && step == substeps);
    double lambda = 0.0;
    bool closed = sub.close_contacts(0.0);
    for (int round = 0; has_volume && (round == 0 || closed) && round < kContactRounds; ++round) {
      lambda = exactly ? sub.exact(muscle.rest_volume)
                       : sub.linear(muscle.rest_volume, method == VolumeMethod::kPrinted
                                                            ? sub.sums.even
                                                            : sub.sums.weighted);
      closed = sub.close_contacts(lambda);
    }
    sub.bear(lambda);
    advance(h, lambda, now);
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) now.x[i] = now.target[i];  // without the substeps' rounding
  }
  for (size_t c = 0; c < touches.size(); ++c) {
    now.push[c] = touches[c].pushed / (frame * contact_stiffness(muscle, touches[c].node));
  }
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace thew
