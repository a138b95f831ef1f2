// SPDX-License-Identifier: Apache-2.0
#include "rig/clip.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "rig/limits.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

// What a key may lie outside its range by, and is then clamped: rounding and resampling of motion
// capture. The documented tolerance of check_clip().
constexpr double kAngleSlack = 0.5 * kDegree;  // rad
constexpr double kLengthSlack = 0.5e-3;        // m
constexpr double kMaxTime = 1e9;               // s; doubles there still resolve 1e-7 s
constexpr double kRounding = 1e-12;            // of the slack, so that 0.5 degree itself passes

[[noreturn]] void refuse(const std::string& location, const std::string& what) {
  throw Error(ErrorCode::kInput, location + ": " + what);
}

void check_sizes(const Clip& clip, const std::string& location) {
  if (clip.times.empty()) refuse(location, "the clip has no keys; give it at least one");
  if (clip.values.size() != clip.times.size()) {
    refuse(location, "the clip has " + std::to_string(clip.times.size()) + " times and " +
                         std::to_string(clip.values.size()) +
                         " rows of values; give one row a time");
  }
  for (size_t k = 0; k < clip.times.size(); ++k) {
    if (!std::isfinite(clip.times[k]) || std::fabs(clip.times[k]) > kMaxTime) {
      refuse(location, "key " + std::to_string(k + 1) + ": time " + number_text(clip.times[k]) +
                           " is no time in seconds; correct it");
    }
    if (k > 0 && clip.times[k] <= clip.times[k - 1]) {
      refuse(location, "key " + std::to_string(k + 1) + ": time " + number_text(clip.times[k]) +
                           " is not after the one before; sort the keys");
    }
    if (clip.values[k].size() != clip.joints.size()) {
      refuse(location, "key " + std::to_string(k + 1) + ": " +
                           std::to_string(clip.values[k].size()) + " values for " +
                           std::to_string(clip.joints.size()) + " joints; give one each");
    }
  }
}

int checked_joint(const Clip& clip, size_t column, const Skeleton& skeleton,
                  const std::string& location) {
  const std::string& name = clip.joints[column];
  const int joint = find_joint(skeleton, name);
  const std::string at = "joint \"" + name + "\"";
  if (joint < 0) {
    refuse(location, at + " is not in the rig" + did_you_mean(name, skeleton.joint_names) +
                         "; correct the name or leave the column out");
  }
  if (skeleton.joint_types[joint] == Skeleton::JointType::kFixed) {
    refuse(location, at + " is fixed; leave its column out");
  }
  if (clip.angles_only && skeleton.joint_types[joint] == Skeleton::JointType::kPrismatic) {
    refuse(location, at + " is prismatic, but the file is in degrees; give it in m by a CSV");
  }
  if (std::find(clip.joints.begin(), clip.joints.begin() + static_cast<long>(column), name) !=
      clip.joints.begin() + static_cast<long>(column)) {
    refuse(location, at + " is driven by two columns; leave one out");
  }
  return joint;
}

// "130.2 deg", "0.01 m": limits and values in the units of the scene file.
std::string value_text(double value, bool is_angle) {
  return is_angle ? number_text(value / kDegree) + " deg" : number_text(value) + " m";
}

void clamp_column(Clip& clip, size_t column, const Skeleton& skeleton, int joint,
                  const std::string& location, std::vector<std::string>& warnings) {
  const bool is_angle = skeleton.joint_types[joint] != Skeleton::JointType::kPrismatic;
  const double lower = skeleton.lower[joint], upper = skeleton.upper[joint];
  const double slack = is_angle ? kAngleSlack : kLengthSlack;
  const std::string at = "joint \"" + clip.joints[column] + "\"";
  const std::string range =
      "[" + value_text(lower, is_angle) + ", " + value_text(upper, is_angle) + "]";
  const auto fail = [&](size_t k, const std::string& what) {
    const std::string row = k < clip.rows.size() ? ":" + std::to_string(clip.rows[k]) : "";
    refuse(row.empty() ? location : clip.file + row,
           at + " is " + value_text(clip.values[k][column], is_angle) + " at " +
               number_text(clip.times[k]) + " s, " + what);
  };
  int clamped = 0;
  double largest = 0.0;
  for (size_t k = 0; k < clip.times.size(); ++k) {
    double& value = clip.values[k][column];
    if (!std::isfinite(value)) fail(k, "not finite; correct the key");
    if (std::fabs(value) > kMaxAngle) fail(k, "which is no angle or length; correct the key");
    const double inside = std::clamp(value, lower, upper);
    const double beyond = std::fabs(value - inside);
    if (beyond > slack * (1.0 + kRounding)) {
      fail(k, "outside its range " + range + "; correct the key, its unit or the rig's limits");
    }
    clamped += beyond > 0.0;
    largest = std::max(largest, beyond);
    value = inside;
  }
  if (clamped == 0) return;
  warnings.push_back(location + ": " + at + ": " + std::to_string(clamped) + " of " +
                     std::to_string(clip.times.size()) + " keys clamped to " + range +
                     ", by at most " + value_text(largest, is_angle));
}

double secant(const Clip& clip, size_t k, size_t column) {
  return (clip.values[k + 1][column] - clip.values[k][column]) /
         (clip.times[k + 1] - clip.times[k]);
}

// Slope at a key: the weighted harmonic mean of the secants on both sides, which keeps each
// interval monotone (Fritsch, Carlson 1980; Fritsch, Butland 1984). It is zero where the secants
// differ in sign, and at the first and last key, because the value is constant beyond them.
double slope(const Clip& clip, size_t k, size_t column) {
  if (k == 0 || k + 1 == clip.times.size()) return 0.0;
  const double before = secant(clip, k - 1, column), after = secant(clip, k, column);
  if (!(before > 0.0 && after > 0.0) && !(before < 0.0 && after < 0.0)) return 0.0;
  const double h0 = clip.times[k] - clip.times[k - 1], h1 = clip.times[k + 1] - clip.times[k];
  const double w0 = 2.0 * h1 + h0, w1 = h1 + 2.0 * h0;
  return (w0 + w1) / (w0 / before + w1 / after);
}

// Cubic Hermite between key k and the next, u in [0, 1].
double smooth_value(const Clip& clip, size_t k, size_t column, double u) {
  const double a = clip.values[k][column], b = clip.values[k + 1][column];
  const double h = clip.times[k + 1] - clip.times[k], v = 1.0 - u;
  const double value = a + (b - a) * u * u * (3.0 - 2.0 * u) +
                       h * u * v * (v * slope(clip, k, column) - u * slope(clip, k + 1, column));
  return std::clamp(value, std::min(a, b), std::max(a, b));  // rounding must not overshoot either
}

}  // namespace

void check_clip(Clip& clip, const Skeleton& skeleton, const std::string& location,
                std::vector<std::string>& warnings) {
  check_sizes(clip, location);
  for (size_t column = 0; column < clip.joints.size(); ++column) {
    const int joint = checked_joint(clip, column, skeleton, location);
    clamp_column(clip, column, skeleton, joint, location, warnings);
  }
}

void sample_clip(const Clip& clip, const Skeleton& skeleton, double time,
                 std::vector<double>& joint_values) {
  assert(!clip.times.empty());
  joint_values.assign(skeleton.body_names.size(), 0.0);
  const size_t after = static_cast<size_t>(
      std::upper_bound(clip.times.begin(), clip.times.end(), time) - clip.times.begin());
  const size_t k = after == 0 ? 0 : after - 1;  // the last key at or before `time`
  const bool outside = after == 0 || after == clip.times.size();
  for (size_t column = 0; column < clip.joints.size(); ++column) {
    const int joint = find_joint(skeleton, clip.joints[column]);
    if (joint < 0) continue;
    const double a = clip.values[k][column];
    double value = a;
    if (!outside) {
      const double u = (time - clip.times[k]) / (clip.times[k + 1] - clip.times[k]);
      value = clip.interpolation == Clip::Interpolation::kLinear
                  ? a + u * (clip.values[k + 1][column] - a)
                  : smooth_value(clip, k, column, u);
    }
    joint_values[joint] = value;
  }
}

}  // namespace thew::rig
