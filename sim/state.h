// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "sim/model.h"

namespace thew {

/// All of a muscle that a step reads of the step before, and a failed one takes back; a bake's
/// parts hold it whole. Rows are by node.
struct MuscleMotion {
  Rows x;                           ///< m
  Rows v;                           ///< m/s
  Rows target;                      ///< the carried shape now, m; driven nodes are on it
  std::vector<double> rest_length;  ///< of the springs, now, m
  double path_length = 0.0;         ///< m, see CarriedPose
  std::vector<Contact> contacts;    ///< a step to come reads of them which they are
  std::vector<double> push;         ///< by contact: force over the contact stiffness, m
  Rows grip;                        ///< the same of friction; empty without
  double zone_radius = 0.0;         ///< m, of the automatic deformation zone
  std::vector<double> weights;      ///< of the volume correction: the authored ones, or the zone's
  int rested = 0;                   ///< steps in a row before which it moved next to nothing
  Level level = Level::kDynamic;    ///< of the step
  bool shaped = false;              ///< kGeometric: it is where it belongs in the pose
  // Measures of the last frame.
  double volume_error = 0.0;            ///< relative, at the end of its last step
  double substep_volume_error = 0.0;    ///< relative, largest of all steps and substeps
  int unreached = 0;                    ///< substeps in which the volume could not be reached
  int weight_fallbacks = 0;             ///< iterations in which even weights had to stand in
  int zone_fallbacks = 0;               ///< iterations in which the whole volume alone was held
  Vec3 impulse = Vec3::Zero();          ///< N s, given by contact since the start (explicit)
  Vec3 angular_impulse = Vec3::Zero();  ///< N m s, about the origin
};

/// What searches for contacts leave to the next: it shortens them, and on a surface that crosses
/// itself may tell what they find. Saved with the motion; after a failed step it starts anew.
struct MuscleSearches {
  ContactMemory memory, face_memory;
  Followed followed;
};

struct MuscleState : MuscleMotion, MuscleSearches {
  Level highest = Level::kDynamic;   ///< of the steps since it was last remembered
  std::int64_t node_iterations = 0;  ///< under a tolerance, since the start; carrying counts as one
  CarriedPose pose;
  Rows target_velocity;              ///< m/s
  std::vector<double> rest_before;   ///< rest lengths a step before
  RingSprings::BySlot rest_by_slot;  ///< of the rings, now
  Bvh bvh;
  MuscleMotion frame_before;  ///< to go back to
  // Scratch, kept so that a step does not allocate.
  std::vector<Contact> contacts_before, pressing;
  std::vector<double> push_before;
  Rows grip_before;
  Rows start;          ///< x when the step began
  Rows apart;          ///< by contact: the node from its point when the step began (friction)
  Rows seen;           ///< x when the iteration began, as the others see it
  double moved = 0.0;  ///< m, the most that a node moved in the iteration before
  Rows base;           ///< what of the right-hand side stays the same in a step, N
  Rows forces, gradient, weighted, direction;
  std::vector<double> zone_targets;   ///< m^3, see zone_targets()
  std::vector<Rows> zone_directions;  ///< by cut, then the whole's
  ZoneScratch zone_scratch;
  std::vector<double> mobility;  ///< weight over mass, 1/kg
  RowPairs pairs;
  SkylineFactor factor;
  std::vector<double> diagonal, factored_diagonal;  ///< added to the springs' matrix, N/m
  double step = 0.0;                                ///< s (xpbd)
  std::vector<double> inverse_mass;                 ///< 1/kg (xpbd: 0 where driven)
  std::vector<double> length_multiplier;            ///< by spring, N s^2 (xpbd)
  Rows shape_multiplier;                            ///< by spring, N s^2 (xpbd)
  double volume_multiplier = 0.0;                   ///< Pa s^2 (xpbd)
};

struct BoneState {
  Rows x;
  Followed followed;
  Bvh bvh;
  bool fitted = true;  ///< the tree is of x
  double moved = 0.0;  ///< m, the most that a node moved in the last step
};

/// All that goes from one frame to the next.
struct State {
  double time = 0.0;       ///< s, 0 at the first frame
  Pose pose, pose_before;  ///< of the step's end and beginning
  std::vector<double> joints;
  std::vector<char> body_moved;  ///< by body, in this step
  std::vector<Affine> bodies;    ///< of a character, stretch included
  std::vector<MuscleState> muscles;
  std::vector<BoneState> bones;
  SkinState skin;
  SkinMotion skin_before;   ///< to go back to
  Pose frame_pose;          ///< the same
  bool taken_back = false;  ///< the bones' surfaces stand where a failed step has moved them

  int count() const { return static_cast<int>(muscles.size()); }
};

/// At rest in the bind pose.
State initial_state(const Model& model);

/// Time, motion and searches as plain numbers, and back: a state that has gone through them takes
/// every step to come to the same bytes. What else a step reads it finds anew.
std::vector<double> pack_state(const State& state);
void unpack_state(const Model& model, const std::vector<double>& packed, State& state);
/// Searches begin anew, as those of the first step.
void forget_searches(State& state);

}  // namespace thew
