// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// An integrator: a row of a table. Each function is of muscle m in a step of h (s).
struct IntegratorSteps {
  void (*begin)(const Model& model, int m, double h, State& state);
  void (*iterate)(const Model& model, int m, State& state);
  void (*finish)(const Model& model, int m, double h, State& state);
  /// After so many iterations of all muscles.
  bool (*is_solved)(const Model& model, int iterations, const State& state);
};
const IntegratorSteps& steps_of(Integrator integrator);

/// The step's first guess: moved with the carried shape, driven nodes on it (an inertial
/// guess sags and folds).
void predict(const Muscle& muscle, double h, MuscleState& state);

/// Automatic deformation zone (eq. 15, mended): weights about the nodes that contact pushed in the
/// step before; the zone grows with the load, the faster the softer the material. Without load, the
/// authored.
void update_zone(const Muscle& muscle, double h, MuscleState& state);

/// Shows the others where the muscle is now; `moved` is then what moved since.
void remember_iterate(MuscleState& state);

/// What the contacts of muscle m are solved with.
ContactSolve contact_solve(const Model& model, int m, const State& state);

/// Moves the nodes that still penetrate out along their contacts' normals, then restores the volume
/// exactly, along the directions that contact leaves free. Sets velocity and volume error.
void finish_muscle(const Model& model, int m, double h, State& state);

/// Volumes (m^3) before the cuts of a muscle's zones, then all: as the carried shape `target`
/// divides the rest volume where the muscle is drawn to that shape, else as the rest shape does.
void zone_targets(const Muscle& muscle, const Points& target, std::vector<double>& before);

/// Brings the volumes of the zones to their targets along their directions; where that fails x
/// stays, and it is counted. Then the whole volume is to be restored as ever, to the last bit.
void restore_zones(const Muscle& muscle, MuscleState& now);

void note_volume(const Muscle& muscle, double volume, SolverMeasures& measures);

/// Implicit Euler by block descent on a prefactored matrix (Liu, Bargteil, O'Brien, Kavan 2013),
/// the volume as a scalar Schur complement in the metric of that matrix. quasi_static: the same
/// without inertia and drag.
void begin_local_global(const Model& model, int m, double h, State& state);
void iterate_local_global(const Model& model, int m, State& state);

/// Extended position-based dynamics (Macklin, Mueller, Chentanez 2016), the springs one by one.
void begin_xpbd(const Model& model, int m, double h, State& state);
void iterate_xpbd(const Model& model, int m, State& state);

/// The paper's semi-implicit Euler, eqs 9-14 with the weights in the denominator, in as many parts
/// of h (s) as the spectrum asks for. Within h the rig moves along a straight line: where its
/// velocity jumps from one h to the next the muscle is shaken, and more substeps shake it less.
int explicit_substeps(const Model& model, int m, double h);
void begin_explicit(const Model& model, int m, double h, State& state);
void iterate_explicit(const Model& model, int m, State& state);
void finish_explicit(const Model& model, int m, double h, State& state);

}  // namespace thew::sim
