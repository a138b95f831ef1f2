// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "muscles/carry.h"
#include "sim/scene/model.h"
#include "sim/solver/step_diagnosis.h"
#include "sim/solver/workspace.h"
#include "skin/contact/contact_memory.h"
#include "skin/contact/multipliers.h"
#include "skin/contact/parting.h"
#include "skin/contact/unfolding.h"
#include "skin/skin_props.h"

namespace thew::sim {

/// A muscle's nodes, and what its solver keeps from step to step. Arrays have one row a node.
struct NodeMotion {
  Points x;                     ///< m
  Points v;                     ///< m/s
  double zone_radius = 0.0;     ///< m, of the automatic deformation zone
  std::vector<double> weights;  ///< of the volume correction [1]: the authored ones, or the zone's
  int still_steps = 0;  ///< successive steps, 2 at most, without motion (Fidelity::still_distance)
  Level level = Level::kDynamic;  ///< of the step
  bool posed = false;             ///< of kGeometric: x is the carried shape of the present pose
};
/// Measures of the last frame.
struct SolverMeasures {
  double volume_error = 0.0;          ///< relative, at the end of its last step
  double substep_volume_error = 0.0;  ///< relative, largest of all steps and substeps
  int unreached = 0;                  ///< substeps in which the volume could not be reached
  int weight_fallbacks = 0;           ///< iterations in which even weights had to stand in
  int zone_fallbacks = 0;             ///< iterations in which only the whole volume was restored
  ContactImpulse contact_impulse;     ///< N s, of all contacts since the start; explicit only
};
/// What stands in for a muscle's solve where that fails, see rungs.h.
enum class Rung { kNone, kSubsteps, kPairLetPass, kCarried };
/// As report.json says it.
inline constexpr const char* kRungs[] = {"none", "substeps", "pair_let_pass", "carried"};
/// The rung that a muscle is on. Saved with the motion. undo_frame() leaves it as it is.
struct LadderState {
  Rung rung = Rung::kNone;        ///< kPairLetPass or kCarried
  double since = 0.0;             ///< s
  int passes = -1;                ///< of kPairLetPass: the collider whose contact is left out
  Rung frame_rung = Rung::kNone;  ///< what the report says of the last frame
  Cause cause = Cause::kNone;     ///< of frame_rung
};
/// All of a muscle that a step reads of the step before. undo_frame() restores it, and each part of
/// a bake holds it.
struct MuscleMotion : NodeMotion, CarriedMotion, ContactMotion, SolverMeasures {};

/// What a search for contacts leaves to the next one. It shortens the search; on a surface that
/// crosses itself it may also decide which contact is found, so it is saved with the motion. A
/// failed step resets it.
struct MuscleSearches {
  ContactMemory memory, face_memory;
  MotionHistory followed;
};

struct MuscleState : MuscleMotion, MuscleSearches, CarriedStep {
  LadderState ladder;
  Level chosen_level = Level::kDynamic;   ///< for this step, before any level is changed
  Level highest_level = Level::kDynamic;  ///< of all steps since frame_before was set
  std::int64_t node_iterations = 0;  ///< nodes times iterations since the start, under a tolerance;
                                     ///< being carried is one iteration
  Bvh bvh;
  MuscleMotion frame_before;        ///< the motion when the frame began, for undo_frame()
  Points start;                     ///< x when the step began
  Points previous_iterate;          ///< x when the iteration began; the other muscles read this
  double residual = 0.0;            ///< m, the longest displacement of a node in the last iteration
  ContactMotion previous_contacts;  ///< contacts of the step before
  std::vector<Contact> loaded_contacts;  ///< those of previous_contacts that bore a force
  std::vector<int> self_candidates;      ///< scratch of the search for self-contacts
  VolumeWork volume;
  IntegratorWork work;
};

struct BoneState {
  Points x;
  Points start;       ///< of one that bends: x when the step began
  Points shape;       ///< of one that bends: x before the motion of its body
  double bent = 0.0;  ///< m, the longest displacement of a node in the last step by bending alone
  MotionHistory followed;
  Bvh bvh;
  bool fitted = true;         ///< whether the tree is up to date with x
  double displacement = 0.0;  ///< m, the longest of a node in the last step
};

/// Scratch of part_muscles().
struct PartingPair {
  int a = -1, b = -1;  ///< colliders
  std::vector<std::array<int, 2>> crossings;
};
struct PartingWork {
  std::vector<Parting> bodies;      ///< by muscle
  std::vector<char> pushed;         ///< by muscle, the last time that any was
  std::vector<char> moved;          ///< by muscle, since crossings were looked for
  std::vector<FoldWork> folds;      ///< by muscle
  std::vector<Points> before;       ///< by muscle, positions at the end of the solve
  std::vector<PartingPair> pairs;   ///< the first `count` of them
  std::vector<Points> written;      ///< m, by collider, positions as a file would hold them...
  std::vector<Collider> colliders;  ///< ...and the colliders there
  bool changed = false;             ///< whether `before` is set
  int count = 0;
};

/// The way from the bind pose to the pose of a frame that is solved by itself (lone_frame.h): an
/// even motion from the time -length to 0 (s). The pose is held from then on.
struct LoneWay {
  double length = 0.0;     ///< s
  double clip_time = 0.0;  ///< s, the clip's time of the pose
};
/// A pose between the bind pose and one of the clip.
struct WayPoint {
  double clip_time = 0.0;  ///< s
  double share = 1.0;      ///< of the way from the bind pose
};

/// All that changes while a model is simulated. `colliders` points into the state itself: a
/// copy has to set its own, as each step does.
struct State {
  double time = 0.0;  ///< s, 0 at the first frame
  std::optional<LoneWay> way;
  Pose pose, pose_before;  ///< of the step's end and beginning
  std::vector<double> joints;
  std::vector<char> body_moved;        ///< [body] in this step
  std::vector<Affine> bodies;          ///< of a character, stretch included
  std::vector<Affine> bodies_of_clip;  ///< the same, before they are blended with the bind pose
  Pose cached_pose;                    ///< of cached bones, likewise
  Pose pose_ahead;                     ///< scratch of carry_skin()
  Points skin_shape;                   ///< m, of the skin's cache at the step's end
  std::vector<MuscleState> muscles;
  std::vector<BoneState> bones;
  std::vector<Collider> colliders;  ///< of the step; they point into this state and the model
  Props props;                      ///< of the step of the skin, likewise
  CandidatePairs near_pairs;        ///< of the colliders
  PartingWork parting;
  SkinState skin;
  SkinState layer;          ///< of a character: the layer by which its skin moves
  SkinMotion layer_before;  ///< of the layer that moves, when the frame began, for undo_frame()
  Pose frame_pose;          ///< when the frame began, for undo_frame()
  double unfollowed = 0.0;  ///< rad, turn before the first frame that the skin has not followed
  bool undone = false;      ///< the bones' surfaces are still where a failed try has moved them

  int count() const { return static_cast<int>(muscles.size()); }
};

/// The skin layer that moves, and is remembered from step to step.
inline SkinState& layer_of(const Model& model, State& state) {
  return model.skinned ? state.layer : state.skin;
}
inline const SkinState& layer_of(const Model& model, const State& state) {
  return model.skinned ? state.layer : state.skin;
}

}  // namespace thew::sim
