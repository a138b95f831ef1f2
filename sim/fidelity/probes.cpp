// SPDX-License-Identifier: Apache-2.0
#include "sim/fidelity/probes.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "muscles/path.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"

namespace thew::sim {
namespace {

constexpr int kMaxProbes = 11, kChecks = 16;
constexpr double kSamePose = 0.04;  // of the range of a path's length, for two poses to differ

// How the rig moves the muscles, by frame.
struct Motion {
  std::vector<double>
      travel;  // m, since the first frame: sum of the longest displacements of a point
  std::vector<std::vector<double>> length;  // [muscle][frame] m
};

// World positions of the points through which the rig moves a muscle.
void add_positions(const Muscle& muscle, const Pose& pose, std::vector<Vec3>& positions) {
  for (const PathPoint& point : muscle.shape.path.points) {
    positions.push_back(frame_of_point(point, pose) * point.position);
  }
  for (size_t i = 0; i < muscle.shape.fixed_to.size(); ++i) {
    const int body = muscle.shape.fixed_to[i];
    if (body >= 0) positions.push_back(pose[body] * muscle.shape.offset[i]);
  }
}

Motion motion_of(const Model& model) {
  Motion motion;
  State state = initial_state(model);
  motion.length.resize(model.muscles.size());
  std::vector<Vec3> positions, before;
  for (int frame = 0; frame <= model.last_frame - model.first_frame; ++frame) {
    drive_bones(model, frame / model.fps, state);
    positions.swap(before);
    positions.clear();
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      const Muscle& muscle = model.muscles[m];
      add_positions(muscle, state.pose, positions);
      motion.length[m].push_back(
          muscle.shape.fixed_to.empty() ? trace_path(muscle.shape.path, state.pose).length : 0.0);
    }
    double most = 0.0;
    for (size_t i = 0; i < positions.size() && frame > 0; ++i) {
      most = std::max(most, (positions[i] - before[i]).norm());
    }
    motion.travel.push_back(frame > 0 ? motion.travel.back() + most : 0.0);
  }
  return motion;
}

}  // namespace

ProbeFrames choose_probes(const Model& model) {
  const Motion motion = motion_of(model);
  const int last = static_cast<int>(motion.travel.size()) - 1;
  if (last < 1) return {};
  std::set<int> probes = {0}, checks;  // frame 0 is where the clip begins, at rest
  // Whether the pose differs from all probes: some path's length does, by a share of its range.
  const auto is_new = [&](int frame) {
    return std::all_of(probes.begin(), probes.end(), [&](int probe) {
      return std::any_of(motion.length.begin(), motion.length.end(), [&](const auto& length) {
        const auto [low, high] = std::minmax_element(length.begin(), length.end());
        return std::abs(length[frame] - length[probe]) > kSamePose * (*high - *low) || *high == 0.0;
      });
    });
  };
  const auto add = [&](int frame) {
    frame = std::clamp(frame, 1, last);
    if (static_cast<int>(probes.size()) < kMaxProbes && is_new(frame)) probes.insert(frame);
  };
  const auto frame_at_travel = [&](double share) {
    const double travel = motion.travel.back() * share;
    const auto at = std::lower_bound(motion.travel.begin(), motion.travel.end(), travel);
    return static_cast<int>(at - motion.travel.begin());
  };
  int fastest = 1;
  const auto speed = [&](int frame) { return motion.travel[frame] - motion.travel[frame - 1]; };
  for (int frame = 2; frame <= last; ++frame) {
    if (speed(frame) > speed(fastest)) fastest = frame;
  }
  add(fastest);
  add(static_cast<int>(std::upper_bound(motion.travel.begin(), motion.travel.end(), 0.0) -
                       motion.travel.begin()));
  add(last);
  for (const std::vector<double>& length : motion.length) {
    const auto [shortest, longest] = std::minmax_element(length.begin(), length.end());
    add(static_cast<int>(shortest - length.begin()));
    add(static_cast<int>(longest - length.begin()));
  }
  for (const int parts : {4, 12, 24}) {
    for (int k = 1; k < parts; ++k) add(frame_at_travel(static_cast<double>(k) / parts));
  }
  for (int k = 0; k < kChecks; ++k) {
    // At equal shares of the travel or, where nothing moves, of the time.
    const double share = (k + 0.5) / kChecks;
    const int frame =
        motion.travel.back() > 0.0 ? frame_at_travel(share) : static_cast<int>(share * last);
    if (frame >= 1 && !probes.count(frame)) checks.insert(frame);
  }
  return {{probes.begin(), probes.end()}, {checks.begin(), checks.end()}};
}

}  // namespace thew::sim
