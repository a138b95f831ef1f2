// SPDX-License-Identifier: Apache-2.0
//
// From where a new scene is looked at.
#include <algorithm>

#include "rig/math.h"
#include "tools/new_arm.h"
#include "tools/obj_text.h"

namespace thew {
namespace {

std::string view_text(const std::string& show, const Vec3& eye, const Vec3& target) {
  return "[[render.view]]\nname = \"" + show + "\"\nshow = \"" + show + "\"\neye = [" +
         metres(eye, ", ") + "]\ntarget = [" + metres(target, ", ") + "]\nfield_of_view = 30\n\n";
}

}  // namespace

// From before the breast and a little above, as near to the first arm as shows it whole, straight
// and flexed.
std::string views_text(const ArmBodies& arm, const ArmFit& fit, const Pose& rest) {
  constexpr double kAspect = 16.0 / 9.0, kFill = 0.9;
  constexpr double kHand = 0.4;    // of the forearm, beyond the wrist
  constexpr double kFlesh = 0.06;  // of the arm, around its bones
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
  const auto show = [&](const Vec3& p) {
    const Vec3 seen = axes.transpose() * p;
    box.extend(Vec3(seen + Vec3::Constant(kFlesh * size)));
    box.extend(Vec3(seen - Vec3::Constant(kFlesh * size)));
  };
  show(shoulder), show(elbow);
  for (const double degrees : {0.0, 60.0, 120.0}) {
    const Mat3 turn = rotation_about(fit.hinge_axis, degrees * kDegree);
    show(elbow + (1.0 + kHand) * (turn * (wrist - elbow)));
  }
  const Vec3 half = 0.5 * box.sizes(), target = axes * box.center();
  const double distance = std::max(half.x() / kAspect, half.y()) / (kFill * tangent) + half.z();
  const Vec3 eye = target + distance * from;
  return view_text("skin", eye, target) + view_text("muscles", eye, target);
}

}  // namespace thew
