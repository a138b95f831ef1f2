// SPDX-License-Identifier: Apache-2.0
//
// From where a new scene is looked at.
#include <algorithm>

#include "rig/math.h"
#include "tools/base/obj_text.h"
#include "tools/fit/arm.h"

namespace thew::tools {
namespace {

std::string view_text(const std::string& show, const Vec3& eye, const Vec3& target) {
  return "[[render.view]]\nname = \"" + show + "\"\nshow = \"" + show + "\"\neye = [" +
         metres(eye, ", ") + "]\ntarget = [" + metres(target, ", ") + "]\nfield_of_view = 30\n\n";
}

// The vertices of the arm's skin, with the elbow turned.
std::vector<Vec3> arm_skin(const Character& character, const ArmBodies& arm, const ArmFit& fit,
                           const Pose& rest, double angle) {
  Transform turn = Transform::Identity();
  turn.linear() = rotation_about(fit.hinge_axis, angle);
  turn.translation() = fit.elbow - turn.linear() * fit.elbow;
  Pose pose = rest;
  for (int b = 0; b < character.skeleton.size(); ++b) {
    if (hangs_on(character.skeleton, b, arm.forearm)) pose[b] = turn * rest[b];
  }
  const Points x = skin_in_pose(character, pose);
  const SkinWeights& skin = character.skin;
  std::vector<Vec3> of_arm;
  for (size_t i = 0; i < x.size(); ++i) {
    double share = 0.0;
    for (int k = skin.first[i]; k < skin.first[i + 1]; ++k) {
      const int body = skin.links[skin.link[k]].body;
      if (hangs_on(character.skeleton, body, arm.humerus)) share += skin.weight[k];
    }
    if (share > 0.5) of_arm.push_back(to_vec(x[i]));
  }
  return of_arm;
}

// Towards the camera: from where the arms bend to and a little above; from the side of an only arm,
// and from the first's a little where there are two, so that none hides the other.
Vec3 viewpoint(const std::vector<ArmFit>& fits) {
  const auto level = [](const Vec3& v) { return Vec3(v.x(), 0.0, v.z()); };
  Vec3 bend = Vec3::Zero();
  for (const ArmFit& fit : fits) bend += level(fit.frame.col(0));
  const Vec3 front =
      bend.norm() > 0.3 * static_cast<double>(fits.size()) ? bend.normalized() : Vec3::UnitZ();
  const double side = fits.size() == 1 ? 0.8 : 0.3;
  return (front + side * level(fits.front().frame.col(2)) + 0.25 * Vec3::UnitY()).normalized();
}

// The arm as it is seen along these axes, straight and flexed.
void add_arm(const Character& character, const ArmBodies& arm, const ArmFit& fit, const Pose& rest,
             const Mat3& axes, Eigen::AlignedBox3d& box) {
  constexpr double kFlesh = 0.06;  // of the arm, around its bones: they may lie outside the skin
  const Vec3 shoulder = rest[arm.humerus].translation(), wrist = rest[arm.hand].translation();
  const double size = (shoulder - fit.elbow).norm() + (wrist - fit.elbow).norm();
  for (const Vec3& p : {shoulder, fit.elbow, wrist}) {
    const Vec3 seen = axes.transpose() * p, around = Vec3::Constant(kFlesh * size);
    box.extend(Vec3(seen + around));
    box.extend(Vec3(seen - around));
  }
  for (const double degrees : {0.0, 60.0, 120.0}) {
    for (const Vec3& p : arm_skin(character, arm, fit, rest, degrees * kDegree)) {
      box.extend(Vec3(axes.transpose() * p));
    }
  }
}

}  // namespace

// As near as shows the arms whole.
std::string views_text(const Character& character, const std::vector<ArmBodies>& arms,
                       const std::vector<ArmFit>& fits, const Pose& rest) {
  constexpr double kAspect = 16.0 / 9.0, kFill = 0.9;
  const double tangent = sin_cos(15.0 * kDegree).sin / sin_cos(15.0 * kDegree).cos;
  const Vec3 from = viewpoint(fits);
  const Vec3 right = Vec3::UnitY().cross(from).normalized(), up = from.cross(right);
  Mat3 axes;
  axes << right, up, from;
  Eigen::AlignedBox3d box;
  for (size_t i = 0; i < arms.size(); ++i) {
    add_arm(character, arms[i], fits[i], rest, axes, box);
  }
  const Vec3 half = 0.5 * box.sizes(), target = axes * box.center();
  const double distance = std::max(half.x() / kAspect, half.y()) / (kFill * tangent) + half.z();
  const Vec3 eye = target + distance * from;
  return view_text("skin", eye, target) + view_text("muscles", eye, target);
}

}  // namespace thew::tools
