// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "rig/types.h"

namespace thew::sim {

/// What a step must not leave behind.
enum class Cause {
  kNone,
  kNoSolution,  ///< the solver says so itself
  kDistance,    ///< from the rig's root
  kSpeed,
  kEdge,    ///< torn
  kVolume,  ///< empty
  kTurnedOver,
  kEnergy,       ///< more than anything can have given
  kWayIntoBone,  ///< in one step
  kJump          ///< the same, however short the step
};
/// By Cause: what is measured, its unit, what became of the muscle, and what to do about it.
struct CauseWords {
  const char *quantity, *unit, *happened, *next;
};
const CauseWords& words_of(Cause cause);

/// Which quantity of what is beyond which limit.
struct StepDiagnosis {
  std::string part;  ///< muscle "NAME", or skin; the whole message where there is no node
  int node = -1;
  Cause cause = Cause::kNoSolution;
  double value = 0.0, limit = 0.0;
  int muscle = -1;   ///< -1: it is of no muscle
  int other = -1;    ///< the collider that has most to do with it; -1: none has
  int substep = 0;   ///< of the frame, counted from 1; of the skin, which is stepped once, 0
  double way = 0.0;  ///< m, of kWayIntoBone: of the node, all in all
  int parts = 0;     ///< in how many the step has to be taken, where that is known
};

/// What the solver itself cannot do.
class NoSolution : public Error {
 public:
  NoSolution(int muscle, const std::string& message)
      : Error(ErrorCode::kSolver, message), muscle(muscle) {}
  int muscle;
};

}  // namespace thew::sim
