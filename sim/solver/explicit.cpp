// SPDX-License-Identifier: Apache-2.0
//
// The paper's semi-implicit Euler, eqs 9-14, with the weights in the denominator (without them
// the error grows): v+ = v + h f / m - lambda d, x+ = x + h v+, d = W dV/dx / m. What changes a
// velocity is a force at the old positions, so linear and angular momentum change by what contact
// gives alone.
#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "muscles/weights.h"
#include "rig/text.h"
#include "rig/vectorise.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/volume_rule.h"

namespace thew::sim {
namespace {

constexpr double kDashpot = 1e-4;  // s, damping of a spring over its stiffness
constexpr double kMargin = 0.95;   // of the stable step, by a bound of the spectrum (Gershgorin)
constexpr int kContactRounds = 60;
constexpr double kMostSubsteps = 20000;  // minutes a frame, and more than any tissue asks for
constexpr int kLookEvery = 5;  // substeps, for touches that may close before the next look

// What a spring has against leaving the carried shape's edge vectors.
void add_shape_forces(const Muscle& muscle, const Points& target, const Points& x, Points& f) {
  const Springs& springs = muscle.springs;
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const Point force = muscle.settings.material.shape * springs.stiffness[k] *
                        (x[a] - x[b] - (target[a] - target[b]));
    f[a] -= force;
    f[b] += force;
  }
}

// A muscle within a step.
struct Body {
  MuscleState& now;
  ExplicitWork& work;
  VolumeWork& volume;
};

struct Kick {
  const Muscle& muscle;
  const Points& target;
  Point gravity;
  double h, damping;
  Point volume = {}, rate = {}, weighted = {};  // sums so far
};

// v + h f / m of order[first, last) in place of f, since others' forces still need v. With
// `kVolume` also the sums, in the same pass.
template <bool kVolume>
[[gnu::always_inline]] inline void kick_nodes(const std::vector<int>& order, size_t first,
                                              size_t last, const Body& body, Kick& kick) {
  const Muscle& muscle = kick.muscle;
  const MuscleState& now = body.now;
  ExplicitWork& work = body.work;
  const bool has_path = muscle.shape.fixed_to.empty();
  const double h = kick.h, damping = kick.damping, guide = muscle.settings.guide;
  const Point gravity = kick.gravity, origin = now.x[0];
  const char* const driven = muscle.driven.data();
  const double *const inverse_mass = work.inverse_mass.data(), *const mobility =
                                                                   work.mobility.data();
  const Point *const x = now.x.data(), *const v_before = now.v.data(),
                     *const g = body.volume.gradient.data();
  Point* const f = work.forces.data();
  Point volume = kick.volume, rate = kick.rate, weighted = kick.weighted;
  for (size_t k = first; k < last; ++k) {
    const int i = order[k];
    Point v = v_before[i];
    if (driven[i]) {
      v = now.target_velocity[i];
    } else {
      Point acceleration = gravity + inverse_mass[i] * f[i] - damping * v;
      if (has_path) {
        acceleration += guide * (kick.target[i] - x[i]) + damping * now.target_velocity[i];
      }
      v += h * acceleration;
    }
    f[i] = v;
    if (!kVolume) continue;
    volume += (x[i] - origin) * g[i];
    rate += v * g[i];
    weighted += mobility[i] * (g[i] * g[i]);
  }
  kick.volume = volume;
  kick.rate = rate;
  kick.weighted = weighted;
}

THEW_VECTORISED
void kick_with_volume(const std::vector<int>& order, size_t first, size_t last, const Body& body,
                      Kick& kick) {
  kick_nodes<true>(order, first, last, body, kick);
}

THEW_VECTORISED
void kick_plainly(const std::vector<int>& order, size_t first, size_t last, const Body& body,
                  Kick& kick) {
  kick_nodes<false>(order, first, last, body, kick);
}

// Forces and what they do to the velocities, block by block, so that what the one wrote is still
// near when the other reads it. With `has_volume` also the sums.
VolumeSums kick_all(const RingSprings::BySlot& rest_length, bool has_volume, const Body& body,
                    Kick kick) {
  auto& [now, work, volume] = body;
  const RingSprings& rings = kick.muscle.rings;
  constexpr size_t kBlock = 64;  // slices: x, v, f and dV/dx of 256 nodes are 32 KiB
  const size_t slices = rings.slices.size();
  const bool has_shape = kick.muscle.settings.material.shape > 0.0;
  const size_t block = has_shape ? slices : kBlock;
  const auto end_of = [&](size_t s) {
    return s < slices ? static_cast<size_t>(rings.slices[s].at) : rings.order.size();
  };
  for (size_t s = 0; s < slices; s += block) {
    const size_t last = std::min(slices, s + block);
    ring_forces(rings, rest_length, {s, last}, now.x, now.v, kDashpot, work.forces,
                has_volume ? &volume.gradient : nullptr);
    if (has_shape) add_shape_forces(kick.muscle, kick.target, now.x, work.forces);
    (has_volume ? kick_with_volume : kick_plainly)(rings.order, end_of(s), end_of(last), body,
                                                   kick);
  }
  now.v.swap(work.forces);
  // V = x . dV/dx / 3
  return {sum3(kick.volume) / 3.0, sum3(kick.rate), sum3(kick.weighted)};
}

// The multiplier's direction d = W dV/dx / m, from which contacts then take what they bear: of all
// nodes, or only of those that two planes may bear a part of; a pass through memory is not free.
THEW_VECTORISED
void set_direction(bool whole, const Body& body) {
  auto& [now, work, volume] = body;
  for (const ContactPlane* touch : work.near.shared) {
    volume.direction[touch->node] = work.mobility[touch->node] * volume.gradient[touch->node];
  }
  for (size_t i = 0; whole && i < now.x.size(); ++i) {
    volume.direction[i] = work.mobility[i] * volume.gradient[i];
  }
}

THEW_VECTORISED
void advance(double h, double lambda, bool whole, const Body& body) {
  auto& [now, work, volume] = body;
  const size_t count = now.x.size();
  if (lambda == 0.0) {
    for (size_t i = 0; i < count; ++i) now.x[i] += h * now.v[i];
  } else if (whole) {
    for (size_t i = 0; i < count; ++i) {
      now.v[i] -= lambda * volume.direction[i];
      now.x[i] += h * now.v[i];
    }
  } else {
    for (size_t i = 0; i < count; ++i) {
      now.v[i] -= lambda * work.mobility[i] * volume.gradient[i];
      now.x[i] += h * now.v[i];
    }
  }
}

ExplicitNodes nodes_of(const Body& body) {
  auto& [now, work, volume] = body;
  return {now.x, now.v, volume.gradient, volume.direction, work.mobility};
}

// Without the weights.
double even_denominator(const Muscle& muscle, const Points& gradient) {
  Point even = {};
  for (size_t i = 0; i < gradient.size(); ++i) {
    if (!muscle.driven[i]) even += 1.0 / muscle.mass[i] * (gradient[i] * gradient[i]);
  }
  return sum3(even);
}

double exact_lambda(const Muscle& muscle, double h, const Body& body) {
  auto& [now, work, volume] = body;
  work.predicted.resize(now.x.size());
  for (size_t i = 0; i < now.x.size(); ++i) work.predicted[i] = now.x[i] + h * now.v[i];
  const VolumeRoot root = nearest_root(
      volume_along(work.predicted, volume.direction, muscle.rest.triangles), muscle.rest_volume);
  if (!root.reached) ++now.unreached;
  return -root.s / h;
}

struct Substep {
  double h, t;  // s, and the part of the frame where it ends
  bool last, exactly, whole;
};

// Closes contacts and finds the multiplier under which they hold. Those that a linear multiplier
// closes are the next substep's.
double solve_multiplier(const Muscle& muscle, const VolumeRule& rule, const Substep& at,
                        const Body& body, VolumeSums& sums) {
  MuscleState& now = body.now;
  const ExplicitNodes nodes = nodes_of(body);
  const auto close = [&](double lambda) {
    return close_contacts(at.h, at.t, lambda, rule.lambda != nullptr, at.whole, body.work.near,
                          nodes, sums);
  };
  const auto linear = [&](const auto& lambda) {
    const double even = rule.wants_even ? even_denominator(muscle, nodes.gradient) : 0.0;
    bool reached = true;
    const double found = lambda(muscle, at.h, sums, even, reached);
    now.unreached += !reached;
    return found;
  };
  bool closed = close(0.0);
  if (!rule.lambda) return 0.0;
  if (!at.exactly) return linear(rule.lambda);
  // The linear multiplier, which needs no pass, finds nearly all that the exact one will close.
  bool looks = at.last && sums.weighted > 0.0;
  for (int round = 0; looks && round < kContactRounds; ++round)
    looks = close(linear(linear_lambda));
  double lambda = 0.0;
  for (int round = 0; (round == 0 || closed) && round < kContactRounds; ++round) {
    lambda = exact_lambda(muscle, at.h, body);
    closed = at.last && close(lambda);
  }
  return lambda;
}

// Weighted forces do not cancel: where no bone holds the body, their net part would move it.
bool drifts(const Muscle& muscle, const MuscleState& now) {
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end()) return false;
  return muscle.settings.zone || std::any_of(now.weights.begin(), now.weights.end(),
                                             [&](double w) { return w != now.weights[0]; });
}

// Drag then slows the deformation alone, not the flight.
void keep_momentum(const Muscle& muscle, double h, const Body& body, VolumeSums& sums) {
  auto& [now, work, volume] = body;
  remove_net_motion(now.x, muscle.mass, volume.direction);
  Points& drag = work.drag;
  drag.resize(now.x.size());
  for (size_t i = 0; i < drag.size(); ++i) drag[i] = -h * muscle.settings.damping * now.v[i];
  remove_net_motion(now.x, muscle.mass, drag);
  Point weighted = {}, rate = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    now.v[i] += drag[i];
    weighted += volume.direction[i] * volume.gradient[i];
    rate += now.v[i] * volume.gradient[i];
  }
  sums.weighted = sum3(weighted);
  sums.rate = sum3(rate);
}

// dV/dx . W dV/dx / m over the compliance, 1/s^2, at rest.
double volume_frequency_squared(const Muscle& muscle, double bulk) {
  Points gradient;
  volume_gradient(to_points(muscle.rest.vertices), muscle.rest.triangles, gradient);
  double sum = 0.0;
  for (size_t i = 0; i < gradient.size(); ++i) {
    sum += muscle.weights[i] / muscle.mass[i] * sum3(gradient[i] * gradient[i]);
  }
  return sum / volume_compliance(muscle, bulk);
}

// To the part `t` of the frame (s): rest lengths and targets, which a path alone moves.
void carry_within(double t, const RingSprings& rings, const MuscleState& now, ExplicitWork& work) {
  work.rest_length.resize(now.rest_length.size());
  for (size_t k = 0; k < work.rest_length.size(); ++k) {
    work.rest_length[k] =
        now.rest_length_before[k] + t * (now.rest_length[k] - now.rest_length_before[k]);
  }
  for (size_t i = 0; i < work.target.size(); ++i) {
    work.target[i] = now.target[i] - (1.0 - t) * work.frame * now.target_velocity[i];
  }
  lengths_by_slot(rings, work.rest_length, work.rest_by_slot);
}

}  // namespace

int explicit_substeps(const Model& model, int m, double h) {
  const Muscle& muscle = model.muscles[m];
  double squared = (1.0 + muscle.settings.material.shape) * muscle.highest_frequency_squared +
                   muscle.settings.guide;
  const double bulk = rule_of(model.solver.volume).bulk;
  if (bulk > 0.0) squared += volume_frequency_squared(muscle, bulk);
  const double omega = std::sqrt(squared);
  const double zeta = 0.5 * kDashpot * omega;  // damping ratio of the fastest mode
  const double stable = 2.0 / omega * (std::sqrt(1.0 + zeta * zeta) - zeta);
  const double substeps = std::ceil(h / (kMargin * stable));
  if (substeps <= kMostSubsteps) return std::max(1, static_cast<int>(substeps));
  throw Error(
      ErrorCode::kUsage,
      muscle.location + ": muscle \"" + muscle.name +
          "\" is too stiff and light for integrator = \"explicit\": a step of " + number_text(h) +
          " s takes " + number_text(substeps) +
          " substeps; make its material softer or its mesh coarser, or take \"local_global\"");
}

void begin_explicit(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  ExplicitWork& work = work_of<ExplicitWork>(now.work);
  const size_t nodes = now.start.size();
  now.x = now.start;
  if (work.frame != h) work.substeps = explicit_substeps(model, m, h);
  work.frame = h;
  work.target = now.target;
  for (Points* rows : {&work.forces, &now.volume.gradient, &now.volume.direction}) {
    rows->resize(nodes);
  }
  work.mobility.resize(nodes);
  work.inverse_mass.resize(nodes);
  for (size_t i = 0; i < nodes; ++i) {
    work.inverse_mass[i] = 1.0 / muscle.mass[i];
    work.mobility[i] = now.weights[i] / muscle.mass[i];
  }
  find_contact_planes(contact_solve(model, m, state), now.contacts, work.touches);
}

void iterate_explicit(const Model& model, int m, State& state) {
  const Muscle& muscle = model.muscles[m];
  const VolumeRule& rule = rule_of(model.solver.volume);
  MuscleState& now = state.muscles[m];
  ExplicitWork& work = std::get<ExplicitWork>(now.work);
  const Body body{now, work, now.volume};
  const bool has_volume = rule.lambda != nullptr, has_path = muscle.has_path();
  const bool removes = has_volume && drifts(muscle, now);
  const int substeps = work.substeps;
  const double h = work.frame / substeps;
  const Point gravity = to_point(model.gravity);
  const ExplicitNodes nodes = nodes_of(body);
  for (int step = 1; step <= substeps; ++step) {
    const double t = static_cast<double>(step) / substeps;
    const bool last = step == substeps;
    if (has_path) carry_within(t, muscle.rings, now, work);
    if (step % kLookEvery == 1 || last) {
      find_near_planes(t - 1.0 / substeps, work.frame, kLookEvery * h, now.x, now.v, work.touches,
                       work.near);
    }
    const bool exactly = rule.substeps == VolumeRule::Exact::kEach ||
                         (rule.substeps == VolumeRule::Exact::kLast && last);
    const bool whole = removes || exactly;
    const double drag = removes ? 0.0 : muscle.settings.damping;
    VolumeSums sums = kick_all(has_path ? work.rest_by_slot : muscle.rings.rest_length, has_volume,
                               body, {muscle, work.target, gravity, h, drag});
    if (has_volume) {
      if (step > 1) note_volume(muscle, sums.volume, now);
      set_direction(whole, body);
      if (removes) keep_momentum(muscle, h, body, sums);
    }
    const double lambda = solve_multiplier(muscle, rule, {h, t, last, exactly, whole}, body, sums);
    release_contacts(lambda, whole, muscle.mass, work.near, nodes, now.given);
    advance(h, lambda, whole, body);
  }
}

void finish_explicit(const Model& model, int m, double h, State& state) {
  const Muscle& muscle = model.muscles[m];
  MuscleState& now = state.muscles[m];
  const ContactPlanes& touches = std::get<ExplicitWork>(now.work).touches;
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) now.x[i] = now.target[i];  // without the substeps' rounding
  }
  if (muscle.has_path() && rule_of(model.solver.volume).exact) {
    restore_exactly(muscle, now.volume.direction, now.x);  // that moved it
  }
  for (size_t c = 0; c < touches.size(); ++c) {
    const double pushed = touches[c].impulse;
    now.normal_multiplier[c] =
        pushed == 0.0 ? 0.0 : pushed / (h * muscle.contact_stiffness[touches[c].node]);
  }
  note_volume(muscle, enclosed_volume(now.x, muscle.rest.triangles), now);
}

}  // namespace thew::sim
