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

}  // namespace

// From before the breast and a little above, as near to the first arm as shows it whole, straight
// and flexed.
std::string views_text(const Character& character, const ArmBodies& arm, const ArmFit& fit,
                       const Pose& rest) {
  constexpr double kAspect = 16.0 / 9.0, kFill = 0.9;
  constexpr double kFlesh = 0.06;  // of the arm, around its bones: they may lie outside the skin
  const double tangent = sin_cos(15.0 * kDegree).sin / sin_cos(15.0 * kDegree).cos;
  const Vec3 shoulder = rest[arm.humerus].translation();
  const Vec3 elbow = fit.elbow, bend = fit.frame.col(0);
  const Vec3 wrist = rest[arm.hand].translation();
  const double size = (shoulder - elbow).norm() + (wrist - elbow).norm();
  const double way = (bend - bend.y() * Vec3::UnitY()).norm();
  Vec3 from = way > 0.3 ? Vec3(bend.x(), 0.0, bend.z()).normalized() : Vec3::UnitZ();
  const Vec3 out = fit.frame.col(2) - fit.frame.col(2).y() * Vec3::UnitY();
  from = (from + 0.8 * out + 0.25 * Vec3::UnitY()).normalized();
  const Vec3 right = Vec3::UnitY().cross(from).normalized(), up = from.cross(right);
  Mat3 axes;
  axes << right, up, from;
  Eigen::AlignedBox3d box;
  for (const Vec3& p : {shoulder, elbow, wrist}) {
    const Vec3 seen = axes.transpose() * p, around = Vec3::Constant(kFlesh * size);
    box.extend(Vec3(seen + around));
    box.extend(Vec3(seen - around));
  }
  for (const double degrees : {0.0, 60.0, 120.0}) {
    for (const Vec3& p : arm_skin(character, arm, fit, rest, degrees * kDegree)) {
      box.extend(Vec3(axes.transpose() * p));
    }
  }
  const Vec3 half = 0.5 * box.sizes(), target = axes * box.center();
  const double distance = std::max(half.x() / kAspect, half.y()) / (kFill * tangent) + half.z();
  const Vec3 eye = target + distance * from;
  return view_text("skin", eye, target) + view_text("muscles", eye, target);
}

}  // namespace thew::tools
