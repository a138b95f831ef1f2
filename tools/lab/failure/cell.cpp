// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/failure/cell.h"

#include <algorithm>
#include <cmath>

#include "muscles/volume.h"

namespace thew::tools {
namespace {

// In the order of Mechanism.
constexpr MechanismText kMechanisms[] = {
    {"", "none", "", ""},
    {"", "not run",
     "Explicit steps must follow the fastest spring, and that takes more parts than a cell of "
     "this map may.",
     "An explicit bake divides its frames as often as the springs' spectrum asks, and refuses "
     "beyond a number, with the integrator to take instead."},
    {"N", "flies off",
     "The step is longer than what is explicit in the method follows: each step overshoots by "
     "more than the one before, until positions are no numbers or nodes leave the rig.",
     "The health check ends the step before anything is written, names muscle, node and "
     "quantity, and divides the frame; explicit takes its parts from the springs' spectrum."},
    {"T", "torn",
     "Nodes are driven or thrown apart faster than the springs take their "
     "neighbours along, until an edge is ten times as long as at rest.",
     "The health check ends the step at ten lengths and divides the frame."},
    {"O", "turned over",
     "Opposite sides pass through each other: what holds the volume is content with a surface "
     "that is inside out in half of its parts, or that encloses nothing.",
     "The health check ends the step when half of the surface is turned or no volume is left, "
     "and divides the frame; a muscle that fails in all divisions is carried by its bones for "
     "that frame."},
    {"B", "passes into an obstacle",
     "The obstacle goes deeper in one step than a contact can be found from.",
     "The step is divided until it goes no deeper than contact can follow; where no division "
     "helps (it overlaps from the start), the bake ends and says where."},
    {"S", "no solution",
     "The equations of the step have no solution that the solver can find: a volume that no "
     "motion of the free nodes reaches, or a body that nothing holds and that so has no rest.",
     "It says which, with the muscle's name; quasi_static wants a muscle that bones hold."},
    {"E", "gains energy",
     "Energy grows while nothing moves: what corrects positions puts more into the springs than "
     "damping takes out.",
     "Its velocities know of the volume's correction, and the health check bounds the energy by "
     "what rig, gravity and springs can have given."},
    {"V", "loses volume",
     "Nothing, or too little, holds the volume against the load, and the shape it has been "
     "pressed into is one that it does not come back from.",
     "The exact multiplier gives the volume back in every step."},
    {"F", "stays folded",
     "Triangles were inverted, and springs are as content with the mirror image as with the "
     "shape: they know lengths, not sides.",
     "Contact of a muscle with itself and parting move what crosses; a muscle with a path has "
     "the carried shape to go back to, which this body by itself has not."},
    {"f", "folds, and comes back",
     "Under the load the surface is shorter than its springs, which buckle between nodes; it "
     "smooths out as the load goes.",
     "A muscle with a path shortens its springs with it, so that they do not buckle."},
    {"M", "does not come to rest",
     "What a step undoes the next one does again, or damping is too weak for the time at rest.",
     "Settling goes on until the fastest node is slow, and a bake warns if it did not come to "
     "that."},
    {"P", "ends elsewhere",
     "The step is too coarse for the way: it arrives at another shape or place than a finer one.",
     "solver.tolerance chooses what a muscle needs by its measured error, and the chart says how "
     "far each step is off."},
    {"~", "keeps its volume softly",
     "The volume is held by a stiffness and not by a constraint, so that a load presses some of "
     "it out.",
     "The exact multiplier holds it to rounding, at the cost of one pass over the triangles."}};

int inverted_triangles(const std::vector<Triangle>& triangles, const Points& x) {
  std::vector<Vec3> normals, sums(x.size(), Vec3::Zero());
  for (const Triangle& t : triangles) {
    const Vec3 a = to_vec(x[t[0]]);
    normals.push_back((to_vec(x[t[1]]) - a).cross(to_vec(x[t[2]]) - a));
    for (const int i : t) sums[i] += normals.back();
  }
  int inverted = 0;
  for (size_t k = 0; k < triangles.size(); ++k) {
    Vec3 around = -3.0 * normals[k];
    for (const int i : triangles[k]) around += sums[i];
    inverted += normals[k].dot(around) < 0.0;
  }
  return inverted;
}

// By what the criteria say at the end, then on the way.
Mechanism mechanism_of(const MapCell& cell) {
  if (cell.growth > 10.0) return Mechanism::kEnergy;
  if (!(cell.last_volume < kMapLost)) return Mechanism::kVolumeLost;
  if (cell.last_inverted > 0) return Mechanism::kFolded;
  if (cell.speed > kMapSpeed) return Mechanism::kMoving;
  if (cell.distance > kMapDistance) return Mechanism::kElsewhere;
  if (cell.growth > kMapGrowth) return Mechanism::kEnergy;
  if (cell.volume_error > kMapVolume) return Mechanism::kVolumeSoft;
  return cell.inverted > 0 ? Mechanism::kFoldedThere : Mechanism::kNone;
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  constexpr const char* kNames[] = {"accurate", "degraded", "recovered", "diverged", "not run"};
  return kNames[static_cast<int>(verdict)];
}

const MechanismText& mechanism_text(Mechanism mechanism) {
  return kMechanisms[static_cast<int>(mechanism)];
}

CellWatch::CellWatch(std::vector<Triangle> triangles, double rest_volume, int frames_a_phase)
    : triangles_(std::move(triangles)), rest_volume_(rest_volume), phase_(frames_a_phase) {}

void CellWatch::see(int frame, const Points& x, double energy, MapCell& cell) {
  const bool rests = (frame - 1) / phase_ % 2 == 1;
  floor_ = std::max(floor_, 1e-6 * energy);
  if (frame % phase_ == 0 && !rests) at_rest_ = std::max(energy, floor_);
  if (rests) cell.growth = std::max(cell.growth, energy / at_rest_);
  cell.last_volume = std::abs(enclosed_volume(x, triangles_) / rest_volume_ - 1.0);
  cell.last_inverted = inverted_triangles(triangles_, x);
  cell.volume_error = std::max(cell.volume_error, cell.last_volume);
  cell.inverted = std::max(cell.inverted, cell.last_inverted);
}

void judge_cell(const Points& finest, const Points& last, double size, MapCell& cell) {
  if (last.empty()) return;  // it did not come to its end, and why is known
  if (!finest.empty()) {
    double sum = 0.0;
    for (size_t i = 0; i < last.size(); ++i) {
      sum += (to_vec(last[i]) - to_vec(finest[i])).squaredNorm();
    }
    cell.distance = std::sqrt(sum / static_cast<double>(last.size())) / size;
  }
  const bool ends_well = cell.last_volume <= kMapVolume && cell.last_inverted == 0 &&
                         cell.speed <= kMapSpeed && cell.distance <= kMapDistance;
  const bool always_well =
      cell.volume_error <= kMapVolume && cell.inverted == 0 && cell.growth <= kMapGrowth;
  cell.verdict = cell.growth > 10.0 || !(cell.last_volume < kMapLost) ? Verdict::kDiverged
                 : !ends_well                                         ? Verdict::kDegraded
                 : always_well                                        ? Verdict::kAccurate
                                                                      : Verdict::kRecovered;
  cell.mechanism = mechanism_of(cell);
}

}  // namespace thew::tools
