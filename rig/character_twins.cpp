// SPDX-License-Identifier: Apache-2.0
#include "rig/character_twins.h"

#include <algorithm>
#include <unordered_map>

#include "rig/character_bones.h"

namespace thew::rig {
namespace {

constexpr double kSamePlace = 1e-3;  // m; between copies that an exporter has rounded
constexpr double kSameTurn = 1e-2;   // of a frame's axes

bool are_alike(const Affine& a, const Affine& b) {
  return (a.translation() - b.translation()).norm() <= kSamePlace &&
         (a.linear() - b.linear()).norm() <= kSameTurn * a.linear().norm();
}

// By body, the one before it whose name it has but for a number that the reader has added, and at
// whose place it stands; else -1.
std::vector<int> find_alike(const Character& c) {
  const Skeleton& skeleton = c.skeleton;
  std::unordered_map<std::string, int> by_name;
  for (int b = 0; b < skeleton.size(); ++b) by_name.emplace(skeleton.body_names[b], b);
  std::vector<Affine> rest;
  animated_bodies(c, {}, 0.0, rest);
  std::vector<int> of(skeleton.size(), -1);
  for (int b = 0; b < skeleton.size(); ++b) {
    const std::string& name = skeleton.body_names[b];
    const size_t end = name.find_last_not_of("0123456789");
    if (end == std::string::npos || end + 1 == name.size() || name[end] != '_') continue;
    if (name[end + 1] == '0' || name.substr(end) == "_1") continue;  // the file's own numbers
    const auto found = by_name.find(name.substr(0, end));
    if (found == by_name.end() || found->second >= b) continue;
    const int a = found->second;
    if (hangs_on(skeleton, b, a)) continue;
    if (are_alike(c.bind[a], c.bind[b]) && are_alike(rest[a], rest[b])) of[b] = a;
  }
  return of;
}

// By body, whether the clip moves it or one above it.
std::vector<char> bodies_moved(const Character& c, const BodyClip& clip) {
  std::vector<char> moved(c.skeleton.size(), 0);
  for (const BodyTrack& track : clip.tracks) moved[track.body] = 1;
  for (int b = 0; b < c.skeleton.size(); ++b) {
    const int parent = c.skeleton.parent[b];
    if (parent >= 0 && moved[parent]) moved[b] = 1;
  }
  return moved;
}

// Bodies that a clip moves apart, and those that it moves alone in another frame than the first's,
// are no twins.
void leave_parted(const Character& c, const BodyClip& clip, std::vector<int>& of) {
  constexpr int kTimes = 9;
  const std::vector<char> moved = bodies_moved(c, clip);
  std::vector<char> apart(of.size(), 0);
  for (size_t b = 0; b < of.size(); ++b) {
    if (of[b] >= 0 && moved[b] && !moved[of[b]]) apart[b] = !are_alike(c.rest[of[b]], c.rest[b]);
  }
  std::vector<Affine> world;
  for (int k = 0; k < kTimes; ++k) {
    animated_bodies(c, clip, clip.duration * k / (kTimes - 1), world);
    for (size_t b = 0; b < of.size(); ++b) {
      if (of[b] < 0 || !moved[b] || !moved[of[b]]) continue;
      apart[b] |= !are_alike(world[of[b]], world[b]);
    }
  }
  for (size_t b = 0; b < of.size(); ++b) {
    if (apart[b]) of[b] = -1;
  }
}

// What moves a twin alone moves the first; else the first's own tracks do.
void join_tracks(const std::vector<int>& of, const std::vector<char>& moved, BodyClip& clip) {
  std::erase_if(clip.tracks, [&](const BodyTrack& track) {
    return of[track.body] >= 0 && moved[of[track.body]];
  });
  for (BodyTrack& track : clip.tracks) {
    if (of[track.body] >= 0) track.body = of[track.body];
  }
  std::stable_sort(clip.tracks.begin(), clip.tracks.end(),
                   [](const BodyTrack& a, const BodyTrack& b) { return a.body < b.body; });
}

}  // namespace

void join_twins(Character& c) {
  std::vector<int> of = find_alike(c);
  for (const BodyClip& clip : c.animations) {
    if (std::all_of(of.begin(), of.end(), [](int a) { return a < 0; })) return;
    leave_parted(c, clip, of);
  }
  for (BodyClip& clip : c.animations) join_tracks(of, bodies_moved(c, clip), clip);
  for (SkinWeights::Link& link : c.skin.links) {
    const int a = of[link.body];
    if (a < 0) continue;
    link.from_bind = c.bind[a].inverse() * c.bind[link.body] * link.from_bind;
    link.body = a;
  }
  for (Character::HumanBone& bone : c.humanoid) {
    if (bone.body >= 0 && of[bone.body] >= 0) bone.body = of[bone.body];
  }
  for (int b = 0; b < c.skeleton.size(); ++b) {
    if (of[b] < 0) continue;
    c.twins.push_back({b, c.skeleton.parent[b], c.rest[b]});
    c.skeleton.parent[b] = of[b];
    c.rest[b] = c.bind[of[b]].inverse() * c.bind[b];
  }
  if (c.twins.empty()) return;
  c.warnings.push_back(std::to_string(c.twins.size()) + " bodies, \"" +
                       c.skeleton.body_names[c.twins.front().body] +
                       "\" the first, are copies of others with the same names at the same "
                       "places, as clothes have them; they move with those");
}

}  // namespace thew::rig
