// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/state.h"

namespace thew {

/// Carries the muscle's shape along its path in state.pose: targets, their velocities over h (s),
/// rest lengths of the springs, activation.
void carry_muscle(const Muscle& muscle, const Pose& pose, double activation, double h,
                  MuscleState& state);

/// The step's first guess: moved with the carried shape, driven nodes on it (an inertial
/// guess sags and folds).
void predict(const Muscle& muscle, double h, MuscleState& state);

/// Automatic deformation zone (eq. 15, mended): weights about the nodes that contact pushed in the
/// step before; the zone grows with the load, the faster the softer the material. Without load, the
/// authored.
void update_zone(const Muscle& muscle, double h, MuscleState& state);

/// Whether the other side is soft too, and goes half of the way.
bool is_shared(const Model& model, const Contact& contact);
/// What a contact is with, and where it is seen.
const Surface& other_surface(const Model& model, const Contact& contact);
const Rows& other_seen(const State& state, const Contact& contact);
/// Its point (m) there, the other's nodes at `other`.
Row contact_point(const Model& model, const Contact& contact, const Rows& other);
/// Signed gap (m) of a contact beyond `wanted`, with the other surface where it is seen.
double contact_gap(const Model& model, const State& state, const Contact& contact, const Row& x,
                   double wanted);

/// Moves the nodes that still penetrate out along their contacts' normals, then restores the volume
/// exactly, along the directions that contact leaves free. Sets velocity and volume error.
void finish_muscle(const Model& model, int m, double h, State& state);

/// Moves x along `direction` so that the volume is the muscle's own (none: stays; penalty: as far
/// as it is stiff; printed: over `printed_denominator`, without the weights; linear; exact). False
/// where it cannot be reached.
bool restore_volume(const Muscle& muscle, VolumeMethod method, const Rows& direction,
                    double printed_denominator, Rows& x);

/// Volumes (m^3) before the cuts of a muscle's zones, then all: as the carried shape `target`
/// divides the rest volume where the muscle is drawn to that shape, else as the rest shape does.
void zone_targets(const Muscle& muscle, const Rows& target, std::vector<double>& before);

/// Brings the volumes of the zones to now.zone_targets along now.zone_directions; where that fails
/// x stays, and it is counted. Then the whole volume is to be restored as ever, to the last bit.
void restore_zones(const Muscle& muscle, MuscleState& now);

/// Compliance (m^3 / Pa) of the volume under VolumeMethod::kPenalty.
double volume_compliance(const Muscle& muscle);

/// Implicit Euler by block descent on a prefactored matrix (Liu, Bargteil, O'Brien, Kavan 2013),
/// the volume as a scalar Schur complement in the metric of that matrix. quasi_static: the same
/// without inertia and drag.
void begin_local_global(const Model& model, int m, double h, State& state);
void iterate_local_global(const Model& model, int m, State& state);

/// Shows the others where the muscle is now; `moved` is then what moved since.
void see(MuscleState& state);

/// After so many iterations of all muscles: those asked for or, quasi_static, as many more as it
/// takes until no node moves. Error(kSolver) with muscle, time and motion where none are enough.
bool is_solved(const Model& model, int iterations, const State& state);

/// Extended position-based dynamics (Macklin, Mueller, Chentanez 2016), the springs one by one.
void begin_xpbd(const Model& model, int m, double h, State& state);
void iterate_xpbd(const Model& model, int m, State& state);

/// The paper's semi-implicit Euler, eqs 9-14 with the weights in the denominator, in as many parts
/// of h (s) as the spectrum asks for. Within h the rig moves along a straight line: where its
/// velocity jumps from one h to the next the muscle is shaken, and more substeps shake it less.
int explicit_substeps(const Model& model, int m, double h);
void step_explicit(const Model& model, int m, double h, State& state);

}  // namespace thew
