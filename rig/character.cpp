// SPDX-License-Identifier: Apache-2.0
#include "rig/character.h"

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "rig/math.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

// The rotation of a linear map by Gram-Schmidt. Unlike a polar decomposition it needs no iteration,
// and it is exact for bones, which are scaled along their own axes.
Mat3 turn_of(const Mat3& linear) {
  Mat3 turn;
  turn.col(0) = linear.col(0).normalized();
  if (linear.determinant() < 0.0) turn.col(0) = -turn.col(0);
  turn.col(1) = (linear.col(1) - turn.col(0).dot(linear.col(1)) * turn.col(0)).normalized();
  turn.col(2) = turn.col(0).cross(turn.col(1));
  return turn.allFinite() ? turn : Mat3::Identity();
}

// Spherical linear interpolation. Eigen's uses the sines of libm, whose bytes differ by processor.
Eigen::Quaterniond slerp(const Eigen::Quaterniond& a, Eigen::Quaterniond b, double u) {
  if (a.dot(b) < 0.0) b.coeffs() = -b.coeffs();
  const double angle =
      2.0 * arc_tan2((a.coeffs() - b.coeffs()).norm(), (a.coeffs() + b.coeffs()).norm());
  const double sine = sin_cos(angle).sin;
  Eigen::Quaterniond out;
  if (sine < 1e-6) {
    out.coeffs() = (1.0 - u) * a.coeffs() + u * b.coeffs();
  } else {
    out.coeffs() =
        (sin_cos((1.0 - u) * angle).sin * a.coeffs() + sin_cos(u * angle).sin * b.coeffs()) / sine;
  }
  return out.normalized();
}
Vec3 between(const Vec3& a, const Vec3& b, double u) { return a + u * (b - a); }
Eigen::Quaterniond between(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b, double u) {
  return slerp(a, b, u);
}

Vec3 combined(const std::array<double, 4>& share, const std::array<const Vec3*, 4>& of) {
  return share[0] * *of[0] + share[1] * *of[1] + share[2] * *of[2] + share[3] * *of[3];
}
Eigen::Quaterniond combined(const std::array<double, 4>& share,
                            const std::array<const Eigen::Quaterniond*, 4>& of) {
  Eigen::Quaterniond out;
  out.coeffs().setZero();
  for (int k = 0; k < 4; ++k) out.coeffs() += share[k] * of[k]->coeffs();
  return out;
}
// A rotation made unit again, or `other` where its four numbers have cancelled out.
Vec3 sound(const Vec3& value, const Vec3&) { return value; }
Eigen::Quaterniond sound(const Eigen::Quaterniond& value, const Eigen::Quaterniond& other) {
  return value.norm() > 1e-9 ? value.normalized() : other.normalized();
}

template <typename Value>
void sample_curve(const Curve<Value>& curve, double time, Value& value) {
  if (curve.times.empty()) return;
  const auto after = static_cast<size_t>(
      std::upper_bound(curve.times.begin(), curve.times.end(), time) - curve.times.begin());
  if (after == 0 || after == curve.times.size() ||
      curve.interpolation == CurveInterpolation::kStep) {
    const Value& key = curve.values[after == 0 ? 0 : after - 1];
    value = curve.interpolation == CurveInterpolation::kCubic ? sound(key, key) : key;
    return;
  }
  const double begin = curve.times[after - 1], step = curve.times[after] - begin;
  const double u = (time - begin) / step, v = 1.0 - u;
  const Value &a = curve.values[after - 1], &b = curve.values[after];
  if (curve.interpolation == CurveInterpolation::kLinear) {
    value = between(a, b, u);
    return;
  }
  value = sound(combined({v * v * (1.0 + 2.0 * u), step * u * v * v, u * u * (3.0 - 2.0 * u),
                          -step * u * u * v},
                         {&a, &curve.slopes_out[after - 1], &b, &curve.slopes_in[after]}),
                a);
}

}  // namespace

void sample(const Curve<Vec3>& curve, double time, Vec3& value) {
  sample_curve(curve, time, value);
}
void sample(const Curve<Eigen::Quaterniond>& curve, double time, Eigen::Quaterniond& value) {
  sample_curve(curve, time, value);
}

LocalTransform split_transform(const Affine& transform) {
  const Mat3 linear = transform.linear(), turn = turn_of(linear);
  LocalTransform out;
  out.translation = transform.translation();
  out.rotation = Eigen::Quaterniond(turn);
  for (int k = 0; k < 3; ++k) out.scale[k] = turn.col(k).dot(linear.col(k));
  return out;
}

Affine join_transform(const LocalTransform& transform) {
  Affine out = Affine::Identity();
  out.linear() = transform.rotation.toRotationMatrix() * transform.scale.asDiagonal();
  out.translation() = transform.translation;
  return out;
}

Transform rigid_part(const Affine& transform) {
  Transform out = Transform::Identity();
  out.linear() = turn_of(transform.linear());
  out.translation() = transform.translation();
  return out;
}

std::vector<char> bodies_with_skin(const Character& character) {
  const SkinWeights& skin = character.skin;
  std::vector<char> has_skin(character.skeleton.size(), 0);
  for (size_t k = 0; k < skin.link.size(); ++k) {
    if (skin.weight[k] > 0.0) has_skin[skin.links[skin.link[k]].body] = 1;
  }
  for (size_t body = has_skin.size(); body-- > 0;) {  // parents come first
    const int parent = character.skeleton.parent[body];
    if (has_skin[body] && parent >= 0) has_skin[parent] = 1;
  }
  return has_skin;
}

void animated_bodies(const Character& character, const BodyClip& clip, double time,
                     std::vector<Affine>& world) {
  world = character.rest;
  for (const BodyTrack& track : clip.tracks) {
    LocalTransform local = split_transform(character.rest[track.body]);
    sample(track.translation, time, local.translation);
    sample(track.rotation, time, local.rotation);
    sample(track.scale, time, local.scale);
    world[track.body] = join_transform(local);
  }
  for (int i = 0; i < character.skeleton.size(); ++i) {
    const int parent = character.skeleton.parent[i];
    if (parent >= 0) world[i] = world[parent] * world[i];
  }
}

void blend_bodies(const Skeleton& skeleton, const std::vector<Affine>& a,
                  const std::vector<Affine>& b, double share, std::vector<Affine>& world) {
  world.resize(a.size());
  for (int i = 0; i < skeleton.size(); ++i) {
    const int parent = skeleton.parent[i];
    const auto local = [&](const std::vector<Affine>& of) {
      return split_transform(parent < 0 ? of[i] : of[parent].inverse() * of[i]);
    };
    const LocalTransform from = local(a), to = local(b);
    LocalTransform now;
    now.translation = between(from.translation, to.translation, share);
    now.rotation = slerp(from.rotation, to.rotation, share);
    now.scale = between(from.scale, to.scale, share);
    world[i] = parent < 0 ? join_transform(now) : world[parent] * join_transform(now);
  }
}

void link_transforms(const SkinWeights& skin, const std::vector<Affine>& world,
                     std::vector<Affine>& of_links) {
  of_links.resize(skin.links.size());
  for (size_t k = 0; k < of_links.size(); ++k) {
    of_links[k] = world[skin.links[k].body] * skin.links[k].from_bind;
  }
}

Affine blended_transform(const SkinWeights& skin, const std::vector<Affine>& of_links, int vertex) {
  Affine blend;
  blend.matrix().setZero();
  for (int k = skin.first[vertex]; k < skin.first[vertex + 1]; ++k) {
    blend.matrix() += skin.weight[k] * of_links[skin.link[k]].matrix();
  }
  return blend;
}

Mat3 bounded_inverse(const Mat3& blend) {
  constexpr double kLeastStretch = 0.05;
  const double size = blend.norm();  // sqrt(3) for a rotation
  if (std::abs(blend.determinant()) > 0.1 * size * size * size) return blend.inverse();
  const Eigen::JacobiSVD<Mat3> svd(blend, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Vec3 stretch = svd.singularValues().cwiseMax(kLeastStretch * svd.singularValues()[0]);
  return svd.matrixV() * stretch.cwiseInverse().asDiagonal() * svd.matrixU().transpose();
}

void skin_by_links(const SkinWeights& skin, const TriMesh& mesh,
                   const std::vector<Affine>& of_links, Points& x) {
  x.resize(mesh.vertices.size());
  for (size_t i = 0; i < x.size(); ++i) {
    x[i] = to_point(blended_transform(skin, of_links, static_cast<int>(i)) * mesh.vertices[i]);
  }
}

void skin_vertices(const SkinWeights& skin, const TriMesh& mesh, const std::vector<Affine>& world,
                   Points& x) {
  std::vector<Affine> of_links;
  link_transforms(skin, world, of_links);
  skin_by_links(skin, mesh, of_links, x);
}

}  // namespace thew::rig
