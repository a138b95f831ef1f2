// SPDX-License-Identifier: Apache-2.0
//
// The template's arm onto a character's.
#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "rig/text.h"
#include "tools/new_arm.h"

namespace thew {
namespace {

constexpr double kSureBend = 20.0 * kDegree;  // beyond it the bind pose shows where the elbow bends
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

// Unit, at right angles to the upper arm: where the forearm goes when the elbow bends.
Vec3 bend_direction(const Character& character, const ArmBodies& arm, const Vec3& shoulder,
                    const Vec3& down, const Vec3& forearm) {
  const Vec3 bend = across(forearm, down);
  const double angle = arc_tan2(bend.norm(), forearm.dot(down));
  Vec3 forward = across(forward_of(character, arm, shoulder), down);
  if (forward.norm() < 0.2) forward = across(Vec3::UnitY(), down);  // an arm stretched forwards
  forward.normalize();
  const bool agrees = bend.norm() > 0.0 && bend.normalized().dot(forward) > 0.5;
  return angle > kSureBend || (angle > kLeastBend && agrees) ? bend.normalized() : forward;
}

// Points on the edges that go with a body more than with any other: a low cylinder has vertices at
// its ends alone.
std::vector<Vec3> points_of(const Character& character, int body) {
  constexpr int kSteps = 10;
  const SkinWeights& skin = character.skin;
  std::vector<char> mine(character.mesh.vertices.size(), 0);
  for (size_t i = 0; i < mine.size(); ++i) {
    double weight = 0.0;
    for (int k = skin.first[i]; k < skin.first[i + 1]; ++k) {
      if (skin.links[skin.link[k]].body == body) weight += skin.weight[k];
    }
    mine[i] = weight > 0.5;
  }
  std::vector<Vec3> points;
  for (const Triangle& t : character.mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      const int a = t[k], b = t[(k + 1) % 3];
      if (!mine[a] || !mine[b]) continue;
      for (int step = 0; step < kSteps; ++step) {
        const double u = (step + 0.5) / kSteps;
        points.push_back((1.0 - u) * character.mesh.vertices[a] + u * character.mesh.vertices[b]);
      }
    }
  }
  return points;
}

double girth_ratio(double girth, double of_template, double along) {
  if (girth <= 0.0) return along;  // the skin tells nothing
  return std::clamp(girth / of_template, along / 3.0, along * 3.0);
}

// Columns: where the template's x, y, z go, stretched along `axis` (template) and across it.
Mat3 stretched(const Mat3& turn, const Vec3& axis, double along, double girth) {
  return turn * (girth * Mat3::Identity() + (along - girth) * axis * axis.transpose());
}

// The least turn that takes one unit vector to another.
Mat3 least_turn(const Vec3& from, const Vec3& to) {
  const Vec3 axis = from.cross(to);
  const double sine = axis.norm();
  if (sine < 1e-12) return Mat3::Identity();
  return rotation_about(axis / sine, arc_tan2(sine, from.dot(to)));
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

double girth_of(const std::vector<Vec3>& points, const Vec3& from, const Vec3& to) {
  const double length = (to - from).norm();
  const Vec3 axis = (to - from) / length;
  double sum = 0.0;
  int count = 0;
  for (const Vec3& p : points) {
    const double along = (p - from).dot(axis) / length;
    if (along < 0.3 || along > 0.7) continue;
    sum += across(p - from, axis).norm();
    ++count;
  }
  return count < 4 ? 0.0 : sum / count;
}

ArmFit fit_arm(const Character& character, const ArmBodies& arm, const ArmLandmarks& landmarks) {
  const Vec3 shoulder = character.bind[arm.humerus].translation();
  const Vec3 elbow = character.bind[arm.forearm].translation();
  const Vec3 wrist = character.bind[arm.hand].translation();
  const Skeleton& skeleton = character.skeleton;
  const double upper = (elbow - shoulder).norm(), fore = (wrist - elbow).norm();
  if (!(upper > 1e-4) || !(fore > 1e-4)) {
    throw Error(ExitCode::kUsage,
                "body \"" + skeleton.body_names[upper > 1e-4 ? arm.forearm : arm.humerus] +
                    "\" has no length; name the arm's bodies with --map");
  }
  const Vec3 down = (elbow - shoulder) / upper, forearm = (wrist - elbow) / fore;
  ArmFit fit;
  fit.mirrored = arm.left;
  fit.elbow = elbow;
  fit.elbow_template = landmarks.elbow;
  // From the template's own shaft, which leans a little, to its y axis and so to the character's.
  const Vec3 shaft = -landmarks.elbow.normalized();
  const Vec3 bend = bend_direction(character, arm, shoulder, down, forearm);
  const Vec3 out = down.cross(bend);
  Mat3 axes;
  axes << bend, -down, (arm.left ? -out : out);
  fit.frame = axes * least_turn(shaft, Vec3::UnitY());
  const Vec3 hinge = (fit.frame * landmarks.elbow_axis).normalized();
  fit.hinge_axis = arm.left ? -hinge : hinge;  // an axis of turning is mirrored the other way round

  const Vec3 fore_template = (landmarks.wrist - landmarks.elbow).normalized();
  const Vec3 straight = fit.frame * fore_template;
  const Vec3 a = across(straight, fit.hinge_axis), b = across(forearm, fit.hinge_axis);
  fit.at_bind = arc_tan2(fit.hinge_axis.dot(a.cross(b)), a.dot(b));
  const Vec3 at_rest = rotation_about(fit.hinge_axis, -fit.at_bind) * forearm;

  fit.along_upper = upper / landmarks.elbow.norm();
  fit.along_fore = fore / (landmarks.wrist - landmarks.elbow).norm();
  fit.girth_upper = girth_ratio(girth_of(points_of(character, arm.humerus), shoulder, elbow),
                                landmarks.girth_upper, fit.along_upper);
  fit.girth_fore = girth_ratio(girth_of(points_of(character, arm.forearm), elbow, wrist),
                               landmarks.girth_fore, fit.along_fore);
  fit.upper = stretched(fit.frame, shaft, fit.along_upper, fit.girth_upper);
  fit.fore = stretched(least_turn(straight, at_rest) * fit.frame, fore_template, fit.along_fore,
                       fit.girth_fore);
  fit.blend = 0.3 * landmarks.elbow.norm();
  return fit;
}

Vec3 map_point(const ArmFit& fit, const Vec3& p) {
  const Vec3 from_elbow = p - fit.elbow_template;
  const double share = smoothstep(-fit.blend, fit.blend, -from_elbow.y());
  return fit.elbow + (1.0 - share) * (fit.upper * from_elbow) + share * (fit.fore * from_elbow);
}

Pose rest_pose_of(const Character& character, const std::vector<ArmBodies>& arms,
                  const std::vector<ArmFit>& fits) {
  Skeleton skeleton = character.skeleton;
  Pose bind;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), bind);
  for (size_t i = 0; i < arms.size(); ++i) {
    const int body = arms[i].forearm;
    const Vec3 axis = bind[body].linear().transpose() * fits[i].hinge_axis;
    skeleton.joint_in_parent[body].linear() *= rotation_about(axis, -fits[i].at_bind);
  }
  Pose rest;
  forward_kinematics(skeleton, std::vector<double>(skeleton.size(), 0.0), rest);
  return rest;
}

}  // namespace thew
