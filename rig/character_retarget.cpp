// SPDX-License-Identifier: Apache-2.0
//
// Transfers the motion of one skeleton to another, see retarget() in character.h. "Theirs" are the
// bodies of the motion, "ours" those of the character.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rig/character.h"
#include "rig/character_bones.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

using Names = std::vector<std::array<std::string, 2>>;

Mat3 turn_of(const Affine& transform) { return rigid_part(transform).linear(); }

// "mixamorig1:LeftArm" -> "LeftArm"
std::string without_namespace(const std::string& name) {
  const size_t colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

// For each of our bodies its counterpart, -1 for none.
struct Match {
  std::vector<int> source;
  int matched = 0, by_kind = 0;  // by_kind: matched as the same bone although their names differ
};

void match_named(const Character& from, const Character& to, const Names& names,
                 const std::string& location, Match& match) {
  for (const auto& [theirs, ours] : names) {
    const int a = find_body(from.skeleton, theirs), b = find_body(to.skeleton, ours);
    if (a < 0 || b < 0) {
      const bool left = a < 0;
      throw Error(ErrorCode::kInput,
                  location + ": body \"" + (left ? theirs : ours) + "\" is not in the " +
                      (left ? "motion" : "rig") +
                      did_you_mean(left ? theirs : ours, (left ? from : to).skeleton.body_names) +
                      "; correct the name");
    }
    match.source[b] = a;
  }
}

Match match_bodies(const Character& from, const HumanBodies& theirs, const Character& to,
                   const HumanBodies& ours, const Names& names, const std::string& location) {
  Match match;
  match.source.assign(to.skeleton.size(), -1);
  match_named(from, to, names, location, match);
  std::vector<char> used(from.skeleton.size(), 0);
  for (const int a : match.source) {
    if (a >= 0) used[a] = 1;
  }
  const auto put = [&](int a, int b) {
    if (match.source[b] >= 0 || used[a]) return false;
    match.source[b] = a;
    used[a] = 1;
    return true;
  };
  const auto name_of = [](const Character& of, int body) {
    return without_namespace(of.skeleton.body_names[body]);
  };
  for (const auto& [kind, b] : ours) {
    const auto found = theirs.find(kind);
    if (found == theirs.end() || !put(found->second, b)) continue;
    match.by_kind += name_of(from, found->second) != name_of(to, b);
  }
  std::map<std::string, int> by_name;
  for (int a = 0; a < from.skeleton.size(); ++a) by_name.emplace(name_of(from, a), a);
  for (int b = 0; b < to.skeleton.size(); ++b) {
    const auto found = by_name.find(name_of(to, b));
    if (found != by_name.end()) put(found->second, b);
    match.matched += match.source[b] >= 0;
  }
  return match;
}

// The axes of a person as columns: to the left, up, forward. False if shoulders or hips are not
// known.
bool frame_of(const Character& character, const HumanBodies& bodies, Mat3& frame) {
  const auto at = [&](BoneKind kind, int side, Vec3& p) {
    const auto found = bodies.find({kind, side});
    if (found != bodies.end()) p = position_of(character, found->second);
    return found != bodies.end();
  };
  Vec3 left, right, left_leg, right_leg;
  if (!at(BoneKind::kHumerus, 1, left) || !at(BoneKind::kHumerus, -1, right) ||
      !at(BoneKind::kThigh, 1, left_leg) || !at(BoneKind::kThigh, -1, right_leg)) {
    return false;
  }
  frame.col(0) = (left - right).normalized();
  const Vec3 up = left + right - left_leg - right_leg;
  frame.col(1) = (up - frame.col(0).dot(up) * frame.col(0)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  return frame.allFinite();
}

// The rotation from our axes to theirs. Files differ by quarter turns in which axis is up and where
// a person faces, so it is the quarter turn nearest to the difference; the remainder is the posture
// of the person and stays.
Mat3 axes_between(const Character& from, const HumanBodies& theirs, const Character& to,
                  const HumanBodies& ours) {
  Mat3 a, b;
  if (!frame_of(from, theirs, a) || !frame_of(to, ours, b)) return Mat3::Identity();
  const Mat3 turn = a * b.transpose();
  Mat3 best = Mat3::Identity();
  double most = -4.0;
  for (int x = 0; x < 6; ++x) {
    for (int y = 0; y < 6; ++y) {
      if (x / 2 == y / 2) continue;
      Mat3 quarter;
      quarter.col(0) = Vec3::Unit(x / 2) * (x % 2 == 0 ? 1.0 : -1.0);
      quarter.col(1) = Vec3::Unit(y / 2) * (y % 2 == 0 ? 1.0 : -1.0);
      quarter.col(2) = quarter.col(0).cross(quarter.col(1));
      const double trace = (quarter.transpose() * turn).trace();
      if (trace > most + 1e-9) most = trace, best = quarter;
    }
  }
  return best;
}

// For each of our bodies the rotation from its bind pose to that of its counterpart, in their axes.
// `farthest` gets the largest difference in direction, as text.
std::vector<Mat3> between_binds(const Character& from, const HumanBodies& theirs,
                                const Character& to, const HumanBodies& ours, const Mat3& axes,
                                std::string& farthest) {
  constexpr std::pair<BoneKind, BoneKind> kLimbs[] = {{BoneKind::kHumerus, BoneKind::kForearm},
                                                      {BoneKind::kForearm, BoneKind::kHand},
                                                      {BoneKind::kThigh, BoneKind::kShin},
                                                      {BoneKind::kShin, BoneKind::kFoot}};
  std::vector<std::array<Vec3, 2>> along(to.skeleton.size(), {Vec3::Zero(), Vec3::Zero()});
  for (const auto& pair : kLimbs) {
    const BoneKind limb = pair.first,
                   end = pair.second;  // a lambda cannot capture a structured binding
    for (const int side : {-1, 1}) {
      const auto direction = [&](const Character& of, const HumanBodies& bodies, Vec3& out) {
        const auto a = bodies.find({limb, side}), b = bodies.find({end, side});
        if (a == bodies.end() || b == bodies.end()) return -1;
        out = position_of(of, b->second) - position_of(of, a->second);
        return out.norm() > 1e-9 ? a->second : -1;
      };
      Vec3 p, q;
      if (direction(from, theirs, p) < 0) continue;
      const int body = direction(to, ours, q);
      if (body >= 0) along[body] = {p.normalized(), q.normalized()};
    }
  }
  std::vector<Mat3> out;
  // rad; smaller differences come from proportions and are not reported.
  double most = 1.0 * kDegree;
  for (int b = 0; b < to.skeleton.size(); ++b) {
    const int parent = to.skeleton.parent[b];
    out.push_back(parent < 0 ? axes : out[parent]);
    const auto& [p, q] = along[b];
    if (p.isZero()) continue;
    const Vec3 now = out[b] * q;
    const double angle = arc_tan2(now.cross(p).norm(), now.dot(p));
    out[b] = least_turn(now, p) * out[b];
    if (angle <= most) continue;
    most = angle;
    char text[32];
    std::snprintf(text, sizeof text, "%.0f deg", angle / kDegree);
    farthest = std::string(text) + " at \"" + to.skeleton.body_names[b] + "\"";
  }
  return out;
}

// Key times in s: those of the motion, and more between keys that are far apart. There,
// interpolating each body by itself would deviate where several joints turn at once.
std::vector<double> key_times(const BodyClip& clip) {
  constexpr double kGap = 0.05, kStep = 1.0 / 60.0;  // s
  constexpr size_t kMaxKeys = 36000;                 // ten minutes of added keys: bounds the memory
  std::vector<double> times;
  for (const BodyTrack& track : clip.tracks) {
    times.insert(times.end(), track.rotation.times.begin(), track.rotation.times.end());
  }
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());
  std::vector<double> out;
  for (const double time : times) {
    if (!out.empty() && time - out.back() > kGap) {
      const double begin = out.back(), steps = std::ceil((time - begin) / kStep);
      for (double k = 1.0; k < steps && out.size() < kMaxKeys; ++k) {
        out.push_back(begin + (time - begin) * k / steps);
      }
    }
    out.push_back(time);
  }
  return out;
}

std::string summary(const Match& match, const Character& to, const std::string& farthest) {
  return std::to_string(match.matched) + " of " + std::to_string(to.skeleton.size()) +
         " bodies follow the motion, by rotations alone" +
         (match.by_kind > 0
              ? ", " + std::to_string(match.by_kind) + " of them by which bone they are"
              : "") +
         (farthest.empty() ? ""
                           : "; the bind poses differ, most by " + farthest +
                                 ", and the difference is taken out");
}

}  // namespace

BodyClip retarget(const Character& from, const BodyClip& clip, const Character& to,
                  const Names& names, const std::string& location,
                  std::vector<std::string>& warnings) {
  HumanBodies theirs = human_bodies(from), ours = human_bodies(to);
  const std::string of_motion = add_limbs_by_geometry(from, theirs),
                    of_rig = add_limbs_by_geometry(to, ours);
  const Match match = match_bodies(from, theirs, to, ours, names, location);
  if (match.matched == 0) {
    throw Error(ErrorCode::kInput,
                location + ": no body of the motion is one of the rig, by name or as a bone (\"" +
                    from.skeleton.body_names.back() + "\", \"" + to.skeleton.body_names.back() +
                    "\"); name pairs with columns = { THEIRS = \"OURS\" }");
  }
  const Mat3 axes = axes_between(from, theirs, to, ours);
  std::string farthest;
  const std::vector<Mat3> between = between_binds(from, theirs, to, ours, axes, farthest);
  std::string by_geometry;
  if (!of_motion.empty()) by_geometry += "; of the motion by shape: " + of_motion;
  if (!of_rig.empty()) by_geometry += "; of the rig by shape: " + of_rig;
  warnings.push_back(location + ": " + summary(match, to, farthest) + by_geometry);
  const Skeleton& skeleton = to.skeleton;
  BodyClip out{clip.name, clip.duration, {}};
  for (int b = 0; b < skeleton.size(); ++b) out.tracks.push_back({b, {}, {}, {}});
  Pose bind;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), bind);
  std::vector<Affine> now;
  std::vector<Mat3> turn(skeleton.size());
  for (const double time : key_times(clip)) {
    animated_bodies(from, clip, time, now);
    for (int b = 0; b < skeleton.size(); ++b) {
      const int parent = skeleton.parent[b], a = match.source[b];
      if (a < 0) {
        turn[b] = skeleton.joint_in_parent[b].linear();
        if (parent >= 0) turn[b] = turn[parent] * turn[b];
      } else {
        turn[b] = axes.transpose() * turn_of(now[a]) * turn_of(from.bind[a]).transpose() *
                  between[b] * bind[b].linear();
      }
      const Mat3 local = parent < 0 ? turn[b] : turn[parent].transpose() * turn[b];
      out.tracks[b].rotation.times.push_back(time);
      out.tracks[b].rotation.values.push_back(Eigen::Quaterniond(local).normalized());
    }
  }
  for (int b = 0; b < skeleton.size(); ++b) {
    const int parent = skeleton.parent[b];
    const LocalTransform local =
        split_transform(parent < 0 ? to.bind[b] : to.bind[parent].inverse() * to.bind[b]);
    out.tracks[b].translation = {{0.0}, {local.translation}, CurveInterpolation::kLinear, {}, {}};
    out.tracks[b].scale = {{0.0}, {local.scale}, CurveInterpolation::kLinear, {}, {}};
  }
  return out;
}

}  // namespace thew::rig
