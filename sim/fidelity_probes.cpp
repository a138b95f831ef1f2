// SPDX-License-Identifier: Apache-2.0
#include "sim/fidelity_probes.h"

#include <algorithm>
#include <set>

#include "muscles/path.h"
#include "sim/drive.h"

namespace thew {
namespace {

constexpr int kSpread = 6;      // probes at equal parts of the way
constexpr int kMostProbes = 12;
constexpr int kMostChecks = 6;

// What the rig does to the muscles, by frame.
struct Motion {
  std::vector<double> way;                  // m, since the first frame: of the point that moves most
  std::vector<std::vector<double>> length;  // [muscle][frame] m
};

// World places of what moves a muscle.
void add_places(const Muscle& muscle, const Pose& pose, std::vector<Vec3>& places) {
  for (const PathPoint& point : muscle.shape.path.points) {
    places.push_back(pose[point.body] * point.position);
  }
  for (size_t i = 0; i < muscle.shape.held.size(); ++i) {
    const int body = muscle.shape.held[i];
    if (body >= 0) places.push_back(pose[body] * muscle.shape.offset[i]);
  }
}

Motion motion_of(const Model& model) {
  Motion motion;
  State state = initial_state(model);
  motion.length.resize(model.muscles.size());
  std::vector<Vec3> places, before;
  for (int frame = 0; frame <= model.scene.last_frame - model.scene.first_frame; ++frame) {
    drive_bones(model, frame / model.scene.fps, state);
    places.swap(before);
    places.clear();
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      const Muscle& muscle = model.muscles[m];
      add_places(muscle, state.pose, places);
      motion.length[m].push_back(
          muscle.shape.held.empty() ? trace_path(muscle.shape.path, state.pose).length : 0.0);
    }
    double most = 0.0;
    for (size_t i = 0; i < places.size() && frame > 0; ++i) {
      most = std::max(most, (places[i] - before[i]).norm());
    }
    motion.way.push_back(frame > 0 ? motion.way.back() + most : 0.0);
  }
  return motion;
}

}  // namespace

ProbeFrames choose_probes(const Model& model) {
  const Motion motion = motion_of(model);
  const int last = static_cast<int>(motion.way.size()) - 1;
  const int apart = std::max(1, last / 40);
  std::set<int> probes;
  const auto add = [&](int frame) {
    frame = std::clamp(frame, 1, last);
    const auto near = probes.lower_bound(frame - apart + 1);
    if (static_cast<int>(probes.size()) < kMostProbes &&
        (near == probes.end() || *near >= frame + apart)) {
      probes.insert(frame);
    }
  };
  if (last < 1) return {};
  const auto way_at = [&](double way) {
    return static_cast<int>(std::lower_bound(motion.way.begin(), motion.way.end(), way) -
                            motion.way.begin());
  };
  int fastest = 1;
  for (int frame = 2; frame <= last; ++frame) {
    const auto speed = [&](int f) { return motion.way[f] - motion.way[f - 1]; };
    if (speed(frame) > speed(fastest)) fastest = frame;
  }
  add(fastest);
  add(static_cast<int>(std::upper_bound(motion.way.begin(), motion.way.end(), 0.0) -
                       motion.way.begin()));
  for (int k = 1; k <= kSpread; ++k) add(way_at(motion.way.back() * k / kSpread));
  for (const std::vector<double>& length : motion.length) {
    const auto [shortest, longest] = std::minmax_element(length.begin(), length.end());
    add(static_cast<int>(shortest - length.begin()));
    add(static_cast<int>(longest - length.begin()));
  }
  // The middles of the gaps, the widest first, measured by the way and then by time.
  std::vector<int> ends(probes.begin(), probes.end());
  ends.insert(ends.begin(), 0);
  if (ends.back() != last) ends.push_back(last);
  struct Gap {
    double way;
    int frames, middle;
  };
  std::vector<Gap> gaps;
  for (size_t i = 1; i < ends.size(); ++i) {
    const int middle = (ends[i - 1] + ends[i]) / 2;
    if (middle <= ends[i - 1] || middle < 1) continue;
    gaps.push_back({motion.way[ends[i]] - motion.way[ends[i - 1]], ends[i] - ends[i - 1], middle});
  }
  std::stable_sort(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) {
    return a.way != b.way ? a.way > b.way : a.frames > b.frames;
  });
  gaps.resize(std::min<size_t>(gaps.size(), kMostChecks));
  ProbeFrames frames{{probes.begin(), probes.end()}, {}};
  for (const Gap& gap : gaps) frames.checks.push_back(gap.middle);
  std::sort(frames.checks.begin(), frames.checks.end());
  return frames;
}

}  // namespace thew
