// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rig/types.h"

namespace thew::sim {

/// Why a step is refused.
enum class Cause {
  kNone,
  kNoSolution,  ///< the solver threw NoSolution
  kDistance,    ///< a node is too far from the rig's root
  kSpeed,       ///< a node is too fast
  kEdge,        ///< an edge is too long
  kVolume,      ///< the muscle encloses no volume
  kTurnedOver,  ///< more than half of the surface is inside out
  kEnergy,      ///< more than rig, gravity and springs can have given
  kTunnelling,  ///< a node would go too deep into a bone in one step
  kJump         ///< the same, and no shorter step mends it
};
/// Texts for one cause: the quantity that is checked, its unit, what happened to the muscle (for
/// the report), and what the user can do.
struct CauseText {
  const char *quantity, *unit, *effect, *remedy;
};
const CauseText& cause_text(Cause cause);

/// A quantity of the cause that is beyond its limit, and where.
struct StepDiagnosis {
  std::string part;  ///< muscle "NAME", or skin; the whole message where node is -1
  int node = -1;
  Cause cause = Cause::kNoSolution;
  double value = 0.0, limit = 0.0;  ///< in the unit of cause_text()
  int muscle = -1;                  ///< index; -1: the fault is of no muscle
  int other = -1;   ///< the collider that presses most on that muscle, or was entered; -1: none
  int substep = 0;  ///< of the frame, counted from 1; 0 where the skin failed
  double displacement = 0.0;  ///< m, of kTunnelling: the node's against the bone, in the step
  int divisor = 0;            ///< of kTunnelling: how many times shorter the step has to be
};

/// Thrown by an integrator that finds no solution for a muscle (its index).
class NoSolution : public Error {
 public:
  NoSolution(int muscle, const std::string& message)
      : Error(ErrorCode::kSolver, message), muscle(muscle) {}
  int muscle;
};

}  // namespace thew::sim
