// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/state.h"

namespace thew::sim {

/// An integrator, as a row of a table. begin, iterate and finish work on muscle m in a step of h
/// seconds and write only that muscle, so that muscles may be worked on in parallel.
struct IntegratorSteps {
  void (*begin)(const Model& model, int m, double h, State& state);
  void (*iterate)(const Model& model, int m, State& state);
  void (*finish)(const Model& model, int m, double h, State& state);
  /// Whether no more iterations are needed after so many of all muscles. May throw NoSolution.
  bool (*is_solved)(const Model& model, int iterations, const State& state);
};
const IntegratorSteps& steps_of(Integrator integrator);

/// The first guess of a step: free nodes move with the carried shape, driven nodes lie on it. A
/// guess by inertia made the muscle sag and fold (notes.md).
void predict(const Muscle& muscle, double h, MuscleState& state);

/// Automatic deformation zone (eq. 15 of the paper, mended by pi): sets the weights around the
/// nodes that bore a contact force in the step before. Its radius (m) grows with the load (N), the
/// faster the softer the material. Without load the weights are the authored ones.
void update_zone(const Muscle& muscle, double h, MuscleState& state);

/// Copies x to previous_iterate, which the other muscles read, and sets the residual: the longest
/// displacement of a node since the last call.
void update_previous_iterate(MuscleState& state);

/// The inputs that the contacts of muscle m are solved with. They refer to model and state.
ContactSolve contact_solve(const Model& model, int m, const State& state);

/// Ends a step of the implicit integrators. Nodes that still penetrate are pushed out along their
/// contacts' normals, and the volume is restored exactly along the directions that contact leaves
/// free, by turns. Sets velocity and volume error.
void finish_muscle(const Model& model, int m, double h, State& state);

/// The volumes (m^3) that a muscle's zones are to have, as the sums before each cut and, last, the
/// whole. A muscle whose belly swells has its rest volume divided as its carried shape `target`
/// divides it, others as their rest shape does.
void zone_targets(const Muscle& muscle, const Points& target, std::vector<double>& before);

/// Moves x along the zones' directions until the zones have their targets. Where that fails x stays
/// and zone_fallbacks counts it. The whole volume still has to be restored afterwards, since this
/// does not reach it to the last bit.
void restore_zones(const Muscle& muscle, MuscleState& now);

/// Sets the relative error of a volume (m^3), and the largest of the frame.
void note_volume(const Muscle& muscle, double volume, SolverMeasures& measures);

/// Implicit Euler by block descent on a prefactored matrix (Liu, Bargteil, O'Brien, Kavan 2013),
/// the volume as a scalar Schur complement in the metric of that matrix. quasi_static: the same
/// without inertia and drag.
void begin_local_global(const Model& model, int m, double h, State& state);
void iterate_local_global(const Model& model, int m, State& state);

/// Extended position-based dynamics (Macklin, Mueller, Chentanez 2016), the springs one by one.
void begin_xpbd(const Model& model, int m, double h, State& state);
void iterate_xpbd(const Model& model, int m, State& state);

/// The paper's semi-implicit Euler, eqs 9-14, with the weights in the denominator. A step of h
/// seconds is divided into explicit_substeps(), by a bound of the springs' spectrum. Within h the
/// rig moves along a straight line. Its velocity jumps from one step to the next, which shakes the
/// muscle; more steps shake it less (notes.md). Error(kUsage) where more than 20,000 would be
/// needed.
int explicit_substeps(const Model& model, int m, double h);
/// The same however many they are: a whole number.
double stable_explicit_substeps(const Model& model, int m, double h);
void begin_explicit(const Model& model, int m, double h, State& state);
void iterate_explicit(const Model& model, int m, State& state);
void finish_explicit(const Model& model, int m, double h, State& state);

}  // namespace thew::sim
