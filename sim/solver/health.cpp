// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/health.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"
#include "rig/text.h"
#include "rig/vectorise.h"
#include "sim/solver/levels.h"
#include "sim/solver/rungs.h"

namespace thew::sim {
namespace {

constexpr double kBox = 10.0;        // times the rig's extent
constexpr double kStretch = 10.0;    // of a spring over its present rest length
constexpr double kReversed = 0.05;   // of all edges: if more are reversed, the surface is checked
constexpr double kTurnedOver = 0.5;  // of the surface
constexpr double kEnergy = 2.0;      // times the energy that went in

double squared(const Point& r) { return dot(r, r); }

double extent_of(const Model& model, const State& state) {
  double extent = model.lengths.least_rig_size;
  for (const Transform& body : state.pose) extent = std::max(extent, body.translation().norm());
  return extent;
}

// The collider of the contact that bears the largest force, -1 where none does.
int strongest_contact(const Muscle& muscle, const MuscleState& now) {
  double most = 0.0;
  int other = -1;
  for (size_t c = 0; c < now.normal_multiplier.size(); ++c) {
    const double force = now.normal_multiplier[c] * muscle.contact_stiffness[now.contacts[c].node];
    if (force > most) most = force, other = now.contacts[c].other;
  }
  return other;
}

StepDiagnosis diagnosis_at(const Model& model, const State& state, int m, int node, Cause cause,
                           double value, double limit) {
  const Muscle& muscle = model.muscles[m];
  const int other = strongest_contact(muscle, state.muscles[m]);
  return {"muscle \"" + muscle.name + "\"", node, cause, value, limit, m, other};
}

int frame_at(const Model& model, double time) {
  const double frames = std::max(time, 0.0) * model.fps;
  return model.first_frame + static_cast<int>(std::lround(frames));
}

std::string text_of(const Model& model, double time, const StepDiagnosis& diagnosis, int substeps) {
  std::string when = "frame " + std::to_string(frame_at(model, time));
  if (time < 0.0) when = "settling, " + std::to_string(-time) + " s before " + when;
  if (diagnosis.node < 0) return when + ": " + diagnosis.part;
  if (diagnosis.substep > 0) {
    when +=
        " (substep " + std::to_string(diagnosis.substep) + " of " + std::to_string(substeps) + ")";
  }
  const CauseText& text = cause_text(diagnosis.cause);
  const auto figure = [&](double value) { return number_text(value) + " " + text.unit; };
  return when + ": " + diagnosis.part + ", node " + std::to_string(diagnosis.node) + ": " +
         text.quantity + " is " + figure(diagnosis.value) + ", the limit is " +
         figure(diagnosis.limit) + "; " + text.remedy;
}

double stretch_energy(double stiffness, double length, double rest) {
  return 0.5 * stiffness * (length - rest) * (length - rest);
}

// J, of the edges at x.
double edge_energy(const Springs& springs, const std::vector<double>& rest_length,
                   const Points& x) {
  double sum = 0.0;
  for (int k = 0; k < springs.structural; ++k) {
    const auto& [a, b] = springs.nodes[k];
    sum += stretch_energy(springs.stiffness[k], norm(x[a] - x[b]), rest_length[k]);
  }
  return sum;
}

// J, an upper bound of the energy of all muscles after the step: kEnergy times the sum of what they
// had, what the rig adds by moving them, what gravity adds and what the blow of a bone adds. To
// this comes the energy of all edges at twice their length, so that the bound is never too low.
double energy_limit(const Model& model, double h, const State& state) {
  double fastest = model.contact.settings.max_depth / h;  // m/s, out of an overlap
  for (const BoneState& bone : state.bones) fastest = std::max(fastest, bone.displacement / h);
  for (const MuscleState& muscle : state.muscles) {
    for (const Point& v : muscle.target_velocity) fastest = std::max(fastest, norm(v));
  }
  double most = 0.0;
  Points guess;
  for (int m = 0; m < state.count(); ++m) {
    const Muscle& muscle = model.muscles[m];
    const MuscleState& now = state.muscles[m];
    const Springs& springs = muscle.springs;
    guess = now.start;
    for (size_t i = 0; i < guess.size(); ++i) {
      guess[i] = muscle.driven[i] ? now.target[i] : guess[i] + h * now.target_velocity[i];
      const double fall = std::abs(dot(to_point(model.gravity), now.x[i] - now.start[i]));
      most += kEnergy * muscle.mass[i] *
              (0.5 * squared(now.frame_before.v[i]) + fall + fastest * fastest);
    }
    most += kEnergy * (edge_energy(springs, now.rest_length, guess) +
                       edge_energy(springs, now.frame_before.rest_length, now.frame_before.x));
    for (int k = 0; k < springs.structural; ++k) {
      most += stretch_energy(springs.stiffness[k], 2.0 * springs.rest_length[k],
                             springs.rest_length[k]);
    }
  }
  return most;
}

Point area_vector(const Points& x, const Triangle& t) {
  const Point u = x[t[1]] - x[t[0]], v = x[t[2]] - x[t[0]];
  return Point{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0],
               0.0};
}

// Share [0 to 1] of the surface whose normal at x is more than a right angle from the carried
// shape's.
double turned_over(const Muscle& muscle, const Points& x, const Points& target) {
  double all = 0.0, over = 0.0;
  for (const Triangle& t : muscle.rest.triangles) {
    const Point there = area_vector(target, t);
    const double area = norm(there);
    all += area;
    if (dot(area_vector(x, t), there) < 0.0) over += area;
  }
  return all > 0.0 ? over / all : 0.0;
}

// A quick check without square roots. True only if all nodes are surely within the limits.
THEW_VECTORISED
bool are_within(const MuscleState& now, double reach, double fastest, double h) {
  constexpr double kLess = 1.0 - 1e-12;
  const double most = std::min(kLess * fastest * fastest, 1e300);
  const double farthest = kLess * reach * reach, longest = most * h * h;
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (!(squared(now.x[i]) <= farthest && squared(now.x[i] - now.start[i]) <= longest &&
          squared(now.v[i]) <= most)) {
      return false;
    }
  }
  return true;
}

std::optional<StepDiagnosis> find_bad_node(const Model& model, double h, double extent,
                                           const State& state, int m) {
  const MuscleState& now = state.muscles[m];
  const double reach = kBox * extent;
  // A quasi-static muscle goes from one balance to the next and has no speed to be limited.
  const bool still = is_quasi_static(model, m);
  const double fastest = still ? 1e300 : extent / h;
  if (are_within(now, reach, fastest, h)) return {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    const int node = static_cast<int>(i);
    const double distance = norm(now.x[i]);
    if (!(distance <= reach)) {  // also where it is not a number
      return diagnosis_at(model, state, m, node, Cause::kDistance, distance, reach);
    }
    for (const double speed : {norm(now.x[i] - now.start[i]) / h, norm(now.v[i])}) {
      if (!(speed <= fastest)) {
        return diagnosis_at(model, state, m, node, Cause::kSpeed, speed, fastest);
      }
    }
  }
  return {};
}

// A node of the edge, or the node, that has the most energy.
int most_strained(const Muscle& muscle, const MuscleState& now) {
  const Springs& springs = muscle.springs;
  double most = 0.0;
  int strained = 0;
  const auto note = [&](double energy, int node) {
    if (energy > most) most = energy, strained = node;
  };
  for (int k = 0; k < springs.structural; ++k) {
    const auto& [a, b] = springs.nodes[k];
    note(stretch_energy(springs.stiffness[k], norm(now.x[a] - now.x[b]), now.rest_length[k]), a);
  }
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (muscle.driven[i]) continue;
    note(0.5 * muscle.mass[i] * squared(now.v[i] - now.target_velocity[i]), static_cast<int>(i));
  }
  return strained;
}

std::optional<StepDiagnosis> find_long_edge(const Model& model, const State& state, int m) {
  const Springs& springs = model.muscles[m].springs;
  const MuscleState& now = state.muscles[m];
  for (int k = 0; k < springs.structural; ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double length = norm(now.x[a] - now.x[b]);
    const double limit = kStretch * std::max(now.rest_length[k], springs.rest_length[k]);
    if (!(length <= limit)) return diagnosis_at(model, state, m, a, Cause::kEdge, length, limit);
  }
  return {};
}

// J, of the free nodes' motion relative to the carried shape.
THEW_VECTORISED
double kinetic_energy(const Muscle& muscle, const MuscleState& now) {
  Point sum = {};
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Point v = now.v[i] - now.target_velocity[i];
    if (!muscle.driven[i]) sum += 0.5 * muscle.mass[i] * v * v;
  }
  return sum3(sum);
}

// Checks edges, volume, orientation and energy. The edges are checked first, in one pass; the
// others cost more and are computed only where the edges say that they may be wrong.
std::optional<StepDiagnosis> find_bad_shape(const Model& model, double h, const State& state,
                                            int m) {
  const Muscle& muscle = model.muscles[m];
  const MuscleState& now = state.muscles[m];
  const Springs& springs = muscle.springs;
  const bool has_path = muscle.shape.fixed_to.empty();
  const EdgeStrain strain = strain_of_edges(springs, now.rest_length, now.x, now.target, kStretch);
  if (!strain.within_limit) return find_long_edge(model, state, m);
  const double energy = strain.energy + kinetic_energy(muscle, now);
  if (now.volume_error >= 1.0) {  // an empty muscle, or one of twice its volume
    const double volume = enclosed_volume(now.x, muscle.rest.triangles);
    if (!(volume > 0.0) && enclosed_volume(now.frame_before.x, muscle.rest.triangles) > 0.0) {
      return diagnosis_at(model, state, m, most_strained(muscle, now), Cause::kVolume, volume, 0.0);
    }
  }
  if (has_path && strain.reversed > kReversed * springs.structural) {
    const double over = turned_over(muscle, now.x, now.target);
    const MuscleMotion& before = now.frame_before;
    if (over > kTurnedOver && over > turned_over(muscle, before.x, before.target)) {
      return diagnosis_at(model, state, m, most_strained(muscle, now), Cause::kTurnedOver, over,
                          kTurnedOver);
    }
  }
  if (!(energy <= strain.reference_energy)) {
    const double limit = energy_limit(model, h, state);
    if (!(energy <= limit)) {
      return diagnosis_at(model, state, m, most_strained(muscle, now), Cause::kEnergy, energy,
                          limit);
    }
  }
  return {};
}

}  // namespace

const CauseText& cause_text(Cause cause) {
  static constexpr const char* kMotion = "see the motion and the scale of the rig in this frame";
  static constexpr const char* kPath =
      "see its path, its wraps and the joints round it in this frame";
  static constexpr const char* kMaterial = "use more substeps or softer material";
  // By Cause.
  static constexpr CauseText kTexts[] = {
      {"", "", "", ""},
      {"solution", "", "the solver found no solution", kMaterial},
      {"distance from the root", "m", "it left the rig's surroundings", kMotion},
      {"speed", "m/s", "it became faster than any part of the rig", kMotion},
      {"length of an edge", "m", "an edge of it was torn", kMaterial},
      {"enclosed volume", "m^3", "it was emptied", kMaterial},
      {"part of its surface turned inside out", "of 1", "its surface turned inside out", kPath},
      {"energy", "J", "it gained more energy than anything gave it", kMaterial},
      {"way into a bone in one step", "m", "it would have passed into a bone in one step", kMotion},
      {"way into a bone, however short the step", "m",
       "it jumps into a bone, however short the step", kPath}};
  return kTexts[static_cast<int>(cause)];
}

StepFailure::StepFailure(const Model& model, double time, const StepDiagnosis& of, int steps)
    : Error(ErrorCode::kSolver, text_of(model, time, of, steps)),
      diagnosis(of),
      frame(frame_at(model, time)),
      substeps(of.substep > 0 ? steps : 0) {}

namespace {

// Copies the motion that has changed since the last copy to frame_before.
void remember(MuscleState& muscle) {
  MuscleMotion& before = muscle.frame_before;
  switch (muscle.highest_level) {
    case Level::kAsleep:
      break;
    case Level::kGeometric:
      before.x = muscle.x;
      before.v = muscle.v;
      break;
    default:
      before = muscle;
  }
  muscle.highest_level = Level::kAsleep;
}

}  // namespace

void begin_frame(const Model& model, State& state) {
  leave_rungs(model, state);
  for (MuscleState& muscle : state.muscles) {
    muscle.volume_error = muscle.substep_volume_error = 0.0;
    muscle.unreached = muscle.weight_fallbacks = muscle.zone_fallbacks = 0;
    remember(muscle);
  }
  state.layer_before = layer_of(model, state);
  state.frame_pose = state.pose;
}

void undo_frame(const Model& model, State& state) {
  for (MuscleState& muscle : state.muscles) {
    static_cast<MuscleMotion&>(muscle) = muscle.frame_before;
    muscle.followed.x.clear();  // the next search must not assume how far it has moved
    muscle.posed = false;
  }
  static_cast<SkinMotion&>(layer_of(model, state)) = state.layer_before;
  state.pose = state.frame_pose;
  state.undone = true;
}

std::optional<StepDiagnosis> diagnose_solver(
    const std::function<std::optional<StepDiagnosis>()>& step) {
  try {
    return step();
  } catch (const NoSolution& none) {
    StepDiagnosis diagnosis{none.what()};
    diagnosis.muscle = none.muscle;
    return diagnosis;
  }
}

std::optional<StepDiagnosis> diagnose_step(const Model& model, double h, const State& state) {
  const double extent = extent_of(model, state);
  for (int m = 0; m < state.count(); ++m) {
    if (state.muscles[m].level == Level::kAsleep) continue;
    if (auto diagnosis = find_bad_node(model, h, extent, state, m)) return diagnosis;
  }
  for (int m = 0; m < state.count(); ++m) {  // all positions are finite by now
    if (!has_forces(state.muscles[m].level)) continue;
    if (auto diagnosis = find_bad_shape(model, h, state, m)) return diagnosis;
  }
  return {};
}

std::optional<StepDiagnosis> diagnose_skin(const Model& model, const State& state) {
  const double reach = kBox * extent_of(model, state);
  const SkinMotion& skin = layer_of(model, state);
  for (size_t i = 0; i < skin.x.size(); ++i) {
    const auto is_beyond = [&](double value) { return !(value <= reach); };
    for (const Points* rows : {&skin.x, &skin.offset, &skin.slip, &skin.force}) {
      if (i >= rows->size() || !is_beyond(norm((*rows)[i]))) continue;
      return StepDiagnosis{"skin", static_cast<int>(i), Cause::kDistance, norm((*rows)[i]), reach};
    }
    if (i < skin.correction.size() && is_beyond(skin.correction[i])) {
      return StepDiagnosis{"skin", static_cast<int>(i), Cause::kDistance, skin.correction[i],
                           reach};
    }
  }
  return {};
}

}  // namespace thew::sim
