// SPDX-License-Identifier: Apache-2.0
#include "sim/lone_frame.h"

#include <algorithm>
#include <cmath>

#include "sim/settle.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"

namespace thew::sim {
namespace {

// The most by which a joint slides from one pose to the other, m.
double slide_between(const Skeleton& skeleton, const Pose& from, const Pose& to) {
  double most = 0.0;
  for (int b = 0; b < skeleton.size(); ++b) {
    const int parent = skeleton.parent[b];
    if (b == 0) continue;  // all move with the root
    const Vec3 pivot = skeleton.pivots.empty() ? Vec3::Zero() : skeleton.pivots[b];
    const auto place = [&](const Pose& pose) -> Vec3 {
      return (pose[std::max(parent, 0)].inverse() * pose[b]) * pivot;
    };
    most = std::max(most, (place(to) - place(from)).norm());
  }
  return most;
}

// How far the pose is from the bind pose, in steps of the way: in each a joint turns by
// SkinSettings::max_turn at most, or slides as far as contact can follow. The state is scratch.
double steps_to(const Model& model, double time, State& state) {
  constexpr int kParts = 16;        // of the way, so that a turn of more than half a circle is seen
  constexpr double kMost = 1000.0;  // a way that is longer has longer steps
  const double turn = model.skin.settings.max_turn, slide = model.contact.settings.max_depth;
  state.way = LoneWay{kParts, time};
  double steps = 0.0;
  for (int k = 0; k <= kParts; ++k) {
    drive_bones(model, k - kParts, state);
    if (k == 0) continue;
    const Pose &from = state.pose_before, &to = state.pose;
    steps += std::max(turn_between(model.skeleton, from, to) / turn,
                      slide_between(model.skeleton, from, to) / slide);
  }
  return std::min(steps, kMost);
}

}  // namespace

bool stands_alone(const Model& model) {
  return !model.solver.tolerance && model.solver.integrator == Integrator::kQuasiStatic;
}

void solve_lone_frame(const Model& model, double time, Parallel& parallel, State& state,
                      StageSeconds& seconds, const std::function<void()>& on_step) {
  constexpr double kShortest = 0.05;  // steps; what is left of the way goes with the step before
  constexpr int kRests = 2;  // of the muscles; the arm's have come to rest to 0.1 um after one
  State own = initial_state(model);
  const double steps = steps_to(model, time, own);
  own = initial_state(model);
  own.way = LoneWay{steps / model.fps, time};
  own.time = -own.way->length;
  std::vector<LadderState> rungs(model.muscles.size());
  const auto note_rungs = [&] {
    for (size_t m = 0; m < rungs.size(); ++m) {
      if (own.muscles[m].ladder.frame_rung > rungs[m].frame_rung) rungs[m] = own.muscles[m].ladder;
    }
  };
  for (int k = 1; k < steps - kShortest; ++k) {
    step_frame(model, (k - steps) / model.fps, parallel, own, seconds);
    note_rungs();
    if (on_step) on_step();
  }
  if (steps > 0.0) step_frame(model, 0.0, parallel, own, seconds);
  note_rungs();
  for (int k = 0; k < kRests; ++k) {
    rest_frame(model, parallel, own, seconds);
    note_rungs();
  }
  bring_skin_to_rest(model, parallel, own, seconds);
  for (size_t m = 0; m < rungs.size(); ++m) {  // the report names what was taken on the way
    own.muscles[m].ladder.frame_rung = rungs[m].frame_rung;
    own.muscles[m].ladder.cause = rungs[m].cause;
  }
  own.time = time;
  state = std::move(own);
}

}  // namespace thew::sim
