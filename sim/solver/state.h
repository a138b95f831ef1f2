// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "muscles/carry.h"
#include "sim/scene/model.h"
#include "sim/solver/step_diagnosis.h"
#include "sim/solver/workspace.h"
#include "skin/contact/contact_memory.h"
#include "skin/contact/multipliers.h"

namespace thew::sim {

/// A muscle's nodes, and what its solver keeps from step to step. Points are by node.
struct NodeMotion {
  Points x;                       ///< m
  Points v;                       ///< m/s
  double zone_radius = 0.0;       ///< m, of the automatic deformation zone
  std::vector<double> weights;    ///< of the volume correction: the authored ones, or the zone's
  int rested = 0;                 ///< steps in a row before which it moved next to nothing
  Level level = Level::kDynamic;  ///< of the step
  bool shaped = false;            ///< kGeometric: it is where it belongs in the pose
};
/// Measures of the last frame.
struct SolverMeasures {
  double volume_error = 0.0;          ///< relative, at the end of its last step
  double substep_volume_error = 0.0;  ///< relative, largest of all steps and substeps
  int unreached = 0;                  ///< substeps in which the volume could not be reached
  int weight_fallbacks = 0;           ///< iterations in which even weights had to stand in
  int zone_fallbacks = 0;             ///< iterations in which the whole volume alone was held
  ContactImpulse given;               ///< by contact since the start (explicit)
};
/// What stands in for a muscle's solve where that fails, see rungs.h.
enum class Rung { kNone, kSubsteps, kPairLetPass, kCarried };
/// As report.json says it.
inline constexpr const char* kRungs[] = {"none", "substeps", "pair_let_pass", "carried"};
/// Where a muscle stands. Saved with the motion; a step that is taken back does not change it.
struct LadderMotion {
  Rung rung = Rung::kNone;   ///< kPairLetPass or kCarried
  double since = 0.0;        ///< s
  int passes = -1;           ///< kPairLetPass: the collider
  Rung taken = Rung::kNone;  ///< in the last frame
  Cause because = Cause::kNone;
};
/// All of a muscle that a step reads of the step before, and a failed one takes back; a bake's
/// parts hold it whole.
struct MuscleMotion : NodeMotion, CarriedMotion, ContactMotion, SolverMeasures {};

/// What searches for contacts leave to the next: it shortens them, and on a surface that crosses
/// itself may tell what they find. Saved with the motion; after a failed step it starts anew.
struct MuscleSearches {
  ContactMemory memory, face_memory;
  MotionHistory followed;
};

struct MuscleState : MuscleMotion, MuscleSearches, CarriedStep {
  LadderMotion ladder;
  Level next = Level::kDynamic;      ///< chosen, until all have been looked at
  Level highest = Level::kDynamic;   ///< of the steps since it was last remembered
  std::int64_t node_iterations = 0;  ///< under a tolerance, since the start; carrying counts as one
  Bvh bvh;
  MuscleMotion frame_before;      ///< to go back to
  Points start;                   ///< x when the step began
  Points previous_iterate;        ///< x when the iteration began, as the others see it
  double moved = 0.0;             ///< m, the most that a node moved in the iteration before
  ContactMotion touched;          ///< contacts of the step before
  std::vector<Contact> pressing;  ///< those of them that bore a force
  std::vector<int> nearby;        ///< scratch of the search for contacts with itself
  VolumeWork volume;
  IntegratorWork work;
};

struct BoneState {
  Points x;
  MotionHistory followed;
  Bvh bvh;
  bool fitted = true;  ///< the tree is of x
  double moved = 0.0;  ///< m, the most that a node moved in the last step
};

/// All that goes from one frame to the next.
struct State {
  double time = 0.0;       ///< s, 0 at the first frame
  Pose pose, pose_before;  ///< of the step's end and beginning
  std::vector<double> joints;
  std::vector<char> body_moved;        ///< by body, in this step
  std::vector<Affine> bodies;          ///< of a character, stretch included
  std::vector<Affine> bodies_of_clip;  ///< the same, before they are blended with the bind pose
  std::vector<MuscleState> muscles;
  std::vector<BoneState> bones;
  std::vector<Collider> colliders;  ///< of the step: they point into this state
  CandidatePairs near;              ///< of them
  SkinState skin;
  SkinMotion skin_before;   ///< to go back to
  Pose frame_pose;          ///< the same
  bool taken_back = false;  ///< the bones' surfaces stand where a failed step has moved them

  int count() const { return static_cast<int>(muscles.size()); }
};

}  // namespace thew::sim
