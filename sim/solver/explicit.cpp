// SPDX-License-Identifier: Apache-2.0
//
// The paper's semi-implicit Euler, eqs 9-14, with the weights in the denominator (without them
// the error grows): v+ = v + h f / m - lambda d, x+ = x + h v+, d = W dV/dx / m. All forces are
// taken at the old positions, so that linear and angular momentum of a free body change by its
// contacts' impulses alone.
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

constexpr double kDashpot = 1e-4;      // s, damping of a spring over its stiffness
constexpr double kMargin = 0.95;       // of the largest stable step, by Gershgorin's bound
constexpr int kContactRounds = 60;     // limit of the rounds in which contact and multiplier settle
constexpr double kMostOfStep = 20000;  // of a step: minutes a frame, and more than tissue needs
constexpr int kSearchInterval = 5;  // substeps, for which the contacts that may close are collected

// The forces by which springs resist any departure from their vectors in the carried shape.
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

// A muscle and its scratch within a step.
struct Body {
  MuscleState& now;
  ExplicitWork& work;
  VolumeWork& volume;
};

// The inputs of a change of velocity, and the volume's sums over the nodes so far.
struct Kick {
  const Muscle& muscle;
  const Points& target;
  Point gravity;
  double h, damping;
  Point volume = {}, rate = {}, weighted = {};
};

// Replaces f by v + h f / m for the nodes order[first, last). v itself stays, since the forces of
// other nodes still need it. With `kVolume` the volume's sums are added in the same pass.
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

// Forces and new velocities, block by block, so that the forces are still in the cache when the
// velocities are computed. With `has_volume` also the sums of the volume.
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

// Sets the multiplier's direction d = W dV/dx / m, from which contacts then take their normals out:
// of all nodes, or only of the nodes that two contact planes may share, which saves a pass over
// memory.
THEW_VECTORISED
void set_direction(bool all_nodes, const Body& body) {
  auto& [now, work, volume] = body;
  for (const ContactPlane* touch : work.near.shared) {
    volume.direction[touch->node] = work.mobility[touch->node] * volume.gradient[touch->node];
  }
  for (size_t i = 0; all_nodes && i < now.x.size(); ++i) {
    volume.direction[i] = work.mobility[i] * volume.gradient[i];
  }
}

THEW_VECTORISED
void advance(double h, double lambda, bool all_nodes, const Body& body) {
  auto& [now, work, volume] = body;
  const size_t count = now.x.size();
  if (lambda == 0.0) {
    for (size_t i = 0; i < count; ++i) now.x[i] += h * now.v[i];
  } else if (all_nodes) {
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

// dV/dx . dV/dx / m, the denominator under even weights.
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
  double h, t;  // s, and the fraction of the step where it ends
  bool last, exactly, all_nodes;
};

// Closes contacts and finds the multiplier lambda under which they stay closed. Contacts that a
// linear multiplier would close are left to the next substep.
double solve_multiplier(const Muscle& muscle, const VolumeRule& rule, const Substep& at,
                        const Body& body, VolumeSums& sums) {
  MuscleState& now = body.now;
  const ExplicitNodes nodes = nodes_of(body);
  const auto close = [&](double lambda) {
    return close_contacts(at.h, at.t, lambda, rule.lambda != nullptr, at.all_nodes, body.work.near,
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
  // The linear multiplier needs no pass over the nodes and finds nearly all contacts that the exact
  // one will close.
  bool may_close = at.last && sums.weighted > 0.0;
  for (int round = 0; may_close && round < kContactRounds; ++round)
    may_close = close(linear(linear_lambda));
  double lambda = 0.0;
  for (int round = 0; (round == 0 || closed) && round < kContactRounds; ++round) {
    lambda = exact_lambda(muscle, at.h, body);
    closed = at.last && close(lambda);
  }
  return lambda;
}

// Whether the weighted forces of the volume would move the muscle as a whole: they do not
// cancel, and no driven node takes them up.
bool drifts(const Muscle& muscle, const MuscleState& now) {
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 1) != muscle.driven.end()) return false;
  return muscle.settings.zone || std::any_of(now.weights.begin(), now.weights.end(),
                                             [&](double w) { return w != now.weights[0]; });
}

// Takes the net force and torque out of the multiplier's direction and of the drag, so that drag
// slows the deformation and not the flight of the body.
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

// Sets rest lengths and targets at the fraction t [0 to 1] of the step. Only a muscle with a path
// has any that change.
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

double stable_explicit_substeps(const Model& model, int m, double h) {
  const Muscle& muscle = model.muscles[m];
  double squared = (1.0 + muscle.settings.material.shape) * muscle.highest_frequency_squared +
                   muscle.settings.guide;
  const double bulk = rule_of(model.solver.volume).bulk;
  if (bulk > 0.0) squared += volume_frequency_squared(muscle, bulk);
  const double omega = std::sqrt(squared);
  const double zeta = 0.5 * kDashpot * omega;  // damping ratio of the fastest mode
  const double stable = 2.0 / omega * (std::sqrt(1.0 + zeta * zeta) - zeta);
  return std::max(1.0, std::ceil(h / (kMargin * stable)));
}

int explicit_substeps(const Model& model, int m, double h) {
  const Muscle& muscle = model.muscles[m];
  const double substeps = stable_explicit_substeps(model, m, h);
  if (substeps <= kMostOfStep) return static_cast<int>(substeps);
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
    if (step % kSearchInterval == 1 || last) {
      find_near_planes(t - 1.0 / substeps, work.frame, kSearchInterval * h, now.x, now.v,
                       work.touches, work.near);
    }
    const bool exactly = rule.substeps == VolumeRule::Exact::kEach ||
                         (rule.substeps == VolumeRule::Exact::kLast && last);
    const bool all_nodes = removes || exactly;
    const double drag = removes ? 0.0 : muscle.settings.damping;
    VolumeSums sums = kick_all(has_path ? work.rest_by_slot : muscle.rings.rest_length, has_volume,
                               body, {muscle, work.target, gravity, h, drag});
    if (has_volume) {
      if (step > 1) note_volume(muscle, sums.volume, now);
      set_direction(all_nodes, body);
      if (removes) keep_momentum(muscle, h, body, sums);
    }
    const double lambda =
        solve_multiplier(muscle, rule, {h, t, last, exactly, all_nodes}, body, sums);
    release_contacts(lambda, all_nodes, muscle.mass, work.near, nodes, now.contact_impulse);
    advance(h, lambda, all_nodes, body);
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
