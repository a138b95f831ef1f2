// SPDX-License-Identifier: Apache-2.0
//
// The template's arm onto a character's.
#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "rig/text.h"
#include "tools/fit/arm.h"

namespace thew::tools {
namespace {

constexpr double kSureBend = 20.0 * kDegree;  // beyond it the bind pose shows where the elbow bends
constexpr double kUsedBend = 0.2;             // its sine; or the animations show it
constexpr double kRolled = 45.0 * kDegree;    // beyond it the bind pose is not how an arm is held
constexpr double kWringing = 80.0 * kDegree;  // to either side is all that a forearm turns
constexpr double kLeastBend = 3.0 * kDegree;  // beyond it, if it is forwards as well

Vec3 across(const Vec3& v, const Vec3& axis) { return v - v.dot(axis) * axis; }

// Horizontal, out of the breast: up, and from the other arm to this one.
Vec3 forward_of(const Character& character, const ArmBodies& arm, const Vec3& shoulder) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : character.mesh.vertices) box.extend(p);
  const Vec3 trunk = character.bind[arm.clavicle].translation();
  Vec3 out = shoulder - (box.isEmpty() ? trunk : Vec3(box.center()));
  out.y() = 0.0;
  if (std::abs(out.x()) + std::abs(out.z()) < 1e-9) out = Vec3(arm.left ? 1.0 : -1.0, 0.0, 0.0);
  // left x up = forward, for a left at +x, an up of +y and a forward of +z.
  const Vec3 left = arm.left ? out : Vec3(-out);
  // Shoulders lie on a line: the larger horizontal part of `out` is along it.
  const Vec3 axis = std::abs(left.x()) >= std::abs(left.z())
                        ? Vec3(left.x() > 0.0 ? 1.0 : -1.0, 0.0, 0.0)
                        : Vec3(0.0, 0.0, left.z() > 0.0 ? 1.0 : -1.0);
  return axis.cross(Vec3::UnitY());
}

// How the character's own animations hold the arm, in the mean, with the upper arm as it is bound.
struct InUse {
  Vec3 forearm = Vec3::Zero();             // its direction; zero where there are none
  double roll = 0.0;                       // rad, about its own length, from the bind pose
  std::vector<std::vector<double>> rolls;  // by animation
};

InUse find_use(const Character& character, const ArmBodies& arm, const Vec3& forearm) {
  constexpr double kStep = 1.0 / 24.0;  // s
  const Mat3 upper = rigid_part(character.bind[arm.humerus]).linear();
  const Mat3 fore = rigid_part(character.bind[arm.forearm]).linear();
  const Vec3 along = fore.transpose() * forearm;
  InUse mean;
  double cosine = 0.0, sine = 0.0;
  int count = 0;
  std::vector<Affine> world;
  for (const BodyClip& clip : character.animations) {
    std::vector<double>& rolls = mean.rolls.emplace_back();
    for (double time = 0.0; time <= clip.duration; time += kStep, ++count) {
      animated_bodies(character, clip, time, world);
      const Mat3 turned = upper * rigid_part(world[arm.humerus]).linear().transpose() *
                          rigid_part(world[arm.forearm]).linear();
      mean.forearm += turned * along;
      // Of the turn in the body's frame the part about `along`.
      const Eigen::Quaterniond turn(Mat3(fore.transpose() * turned));
      const double roll = 2.0 * arc_tan2(turn.vec().dot(along), turn.w());
      rolls.push_back(roll);
      cosine += sin_cos(roll).cos;
      sine += sin_cos(roll).sin;
    }
  }
  if (count == 0) return {};
  mean.forearm /= count;
  mean.roll = arc_tan2(sine, cosine);
  return mean;
}

// Unit, at right angles to the upper arm: where the forearm goes when the elbow bends.
Vec3 bend_direction(const Character& character, const ArmBodies& arm, const Vec3& shoulder,
                    const Vec3& down, const Vec3& forearm, const InUse& in_use) {
  const Vec3 bend = across(forearm, down);
  const double angle = arc_tan2(bend.norm(), forearm.dot(down));
  const Vec3 used = across(in_use.forearm, down);
  if (angle <= kSureBend && used.norm() > kUsedBend) return used.normalized();
  Vec3 forward = across(forward_of(character, arm, shoulder), down);
  if (forward.norm() < 0.2) forward = across(Vec3::UnitY(), down);  // an arm stretched forwards
  forward.normalize();
  const bool agrees = bend.norm() > 0.0 && bend.normalized().dot(forward) > 0.5;
  return angle > kSureBend || (angle > kLeastBend && agrees) ? bend.normalized() : forward;
}

// Columns: where the template's x, y, z go, stretched along `axis` (template) and across.
Mat3 stretched(const Mat3& turn, const Vec3& axis, double along, double across) {
  return turn * (across * Mat3::Identity() + (along - across) * axis * axis.transpose());
}

}  // namespace

Vec3 facing_of(const Character& character, const Vec3& shoulders) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : character.mesh.vertices) box.extend(p);
  if (box.isEmpty()) return Vec3::Zero();
  const double floor = box.min().y(), height = box.sizes().y();
  Vec3 soles = Vec3::Zero(), ankles = Vec3::Zero();
  int sole = 0, ankle = 0;
  for (const Vec3& p : character.mesh.vertices) {
    if (p.y() < floor + 0.04 * height) soles += p, ++sole;
  }
  for (const SkinWeights::Link& link : character.skin.links) {
    const Vec3 p = character.bind[link.body].translation();
    if (p.y() > floor + 0.04 * height && p.y() < floor + 0.15 * height) ankles += p, ++ankle;
  }
  const Vec3 forward = Vec3(shoulders.x(), 0.0, shoulders.z()).normalized().cross(Vec3::UnitY());
  if (sole == 0 || ankle == 0) return Vec3::Zero();
  const double ahead = forward.dot(soles / sole - ankles / ankle);
  if (std::abs(ahead) < 0.005 * height) return Vec3::Zero();
  return ahead > 0.0 ? forward : Vec3(-forward);
}

ArmFit fit_arm(const Character& character, const ArmBodies& arm, const ArmTemplate& from) {
  const Vec3 shoulder = character.bind[arm.humerus].translation();
  const Vec3 elbow = character.bind[arm.forearm].translation();
  const Vec3 wrist = character.bind[arm.hand] * arm.wrist;
  const Skeleton& skeleton = character.skeleton;
  const double upper = (elbow - shoulder).norm(), fore = (wrist - elbow).norm();
  if (!(upper > 1e-4) || !(fore > 1e-4)) {
    throw Error(ErrorCode::kUsage,
                "body \"" + skeleton.body_names[upper > 1e-4 ? arm.forearm : arm.humerus] +
                    "\" has no length; name the arm's bodies with --map");
  }
  const Vec3 down = (elbow - shoulder) / upper, forearm = (wrist - elbow) / fore;
  ArmFit fit;
  fit.mirrored = arm.left;
  fit.elbow = elbow;
  fit.elbow_template = from.elbow;
  fit.wrist_template = from.wrist;
  // From the template's own shaft, which leans a little, to its y axis and so to the character's.
  const Vec3 shaft = -from.elbow.normalized();
  const InUse in_use = find_use(character, arm, forearm);
  const Vec3 bend = bend_direction(character, arm, shoulder, down, forearm, in_use);
  fit.along = forearm;
  if (std::abs(in_use.roll) > kRolled) fit.roll = in_use.roll;
  for (size_t c = 0; c < in_use.rolls.size(); ++c) {
    const auto is_far = [&](double roll) {
      const SinCos off = sin_cos(roll - fit.roll);
      return std::abs(arc_tan2(off.sin, off.cos)) > kWringing;
    };
    if (std::any_of(in_use.rolls[c].begin(), in_use.rolls[c].end(), is_far)) {
      fit.wringing.push_back(character.animations[c].name);
    }
  }
  const auto axes_of = [&](const Vec3& forward, const Vec3& below) {
    const Vec3 out = below.cross(forward);
    Mat3 axes;
    axes << forward, -below, (arm.left ? -out : out);
    return axes;
  };
  fit.frame = axes_of(bend, down) * least_turn(shaft, Vec3::UnitY());
  const Vec3 forward = forward_of(character, arm, shoulder);
  const Mat3 hanging = axes_of(forward, -Vec3::UnitY());
  fit.hang.linear() = hanging * fit.frame.transpose();
  fit.hang.translation() = shoulder - fit.hang.linear() * shoulder;
  fit.upwards = arm.left ? Vec3(forward) : Vec3(-forward);
  const Vec3 hinge = (fit.frame * from.elbow_axis).normalized();
  fit.hinge_axis = arm.left ? -hinge : hinge;  // an axis of turning is mirrored the other way round

  const Vec3 fore_template = (from.wrist - from.elbow).normalized();
  const Vec3 straight = fit.frame * fore_template;
  const Vec3 a = across(straight, fit.hinge_axis), b = across(forearm, fit.hinge_axis);
  // A bind pose stretched beyond straight is taken for straight: tendons would be drawn into bone.
  fit.at_bind = std::max(0.0, arc_tan2(fit.hinge_axis.dot(a.cross(b)), a.dot(b)));
  const Vec3 at_rest = rotation_about(fit.hinge_axis, -fit.at_bind) * forearm;

  fit.along_upper = upper / from.elbow.norm();
  fit.along_fore = fore / (from.wrist - from.elbow).norm();
  fit.across = (upper + fore) / (from.elbow.norm() + (from.wrist - from.elbow).norm());
  fit.upper = stretched(fit.frame, shaft, fit.along_upper, fit.across);
  fit.fore = stretched(least_turn(straight, at_rest) * fit.frame, fore_template, fit.along_fore,
                       fit.across);
  fit.blend = 0.3 * from.elbow.norm();
  return fit;
}

namespace {

// Of the forearm, at the template's section y.
double share_of_fore(const ArmFit& fit, double y) {
  return smoothstep(-fit.blend, fit.blend, fit.elbow_template.y() - y);
}

}  // namespace

Vec3 axis_point(const ArmFit& fit, double y) {
  const Vec3 &elbow = fit.elbow_template, fore = fit.wrist_template - elbow;
  const double share = share_of_fore(fit, y);
  return (1.0 - share) * (y / elbow.y()) * elbow +
         share * (elbow + (y - elbow.y()) / fore.y() * fore);
}

Mat3 linear_at(const ArmFit& fit, double y) {
  const double share = share_of_fore(fit, y);
  return (1.0 - share) * fit.upper + share * fit.fore;
}

Vec3 map_point(const ArmFit& fit, const Vec3& p) {
  const Vec3 axis = axis_point(fit, p.y()), out = p - axis;
  const double girth = fit.girth.value(p.y(), arc_tan2(out.z(), out.x()));
  return fit.elbow + fit.girth.shift_at(p.y()) +
         linear_at(fit, p.y()) * (axis - fit.elbow_template + girth * out);
}

Pose straight_pose(const Character& character, const std::vector<ArmBodies>& arms,
                   const std::vector<ArmFit>& fits) {
  Skeleton skeleton = character.skeleton;
  Pose bind;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), bind);
  for (size_t i = 0; i < arms.size(); ++i) {
    const int body = arms[i].forearm;
    const Vec3 axis = bind[body].linear().transpose() * fits[i].hinge_axis;
    const Vec3 along = bind[body].linear().transpose() * fits[i].along;
    skeleton.joint_in_parent[body].linear() *=
        rotation_about(axis, -fits[i].at_bind) * rotation_about(along, fits[i].roll);
  }
  Pose rest;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), rest);
  return rest;
}

Pose hanging_pose(const Character& character, const Pose& straight,
                  const std::vector<ArmBodies>& arms, const std::vector<ArmFit>& fits) {
  Pose hanging = straight;
  for (size_t i = 0; i < arms.size(); ++i) {
    const ArmBodies& arm = arms[i];
    const int own = character.skeleton.size();
    for (int b = 0; b < static_cast<int>(straight.size()); ++b) {
      const bool of_arm =
          b < own ? hangs_on(character.skeleton, b, arm.humerus) : b == arm.ulna || b == arm.radius;
      if (of_arm) hanging[b] = fits[i].hang * straight[b];
    }
  }
  return hanging;
}

}  // namespace thew::tools
