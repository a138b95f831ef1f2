// SPDX-License-Identifier: Apache-2.0
#pragma once

// A made-up arm: upper arm along +y from the elbow at the origin, forearm along -y, flexed to the
// front (+x) about z. Seven bellies, two bones, and a skin cast around them at rest.
#include <functional>

#include "rig/math.h"
#include "skin/skin_layer.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {

struct TestArm {
  struct Belly {
    Vec3 origin, insertion;   ///< upper arm, forearm
    Vec3 bulge;               ///< of the middle from the straight line, m
    double radius, swelling;  ///< m; relative growth at 130 degrees
  };
  std::vector<Belly> bellies = {
      {{0.015, 0.28, 0.0}, {0.02, -0.04, 0.008}, {0.018, 0, 0}, 0.026, 0.27},   // biceps
      {{0.012, 0.15, 0.0}, {0.012, -0.03, -0.003}, {0.006, 0, 0}, 0.017, 0.2},  // brachialis
      {{-0.012, 0.29, 0.0}, {-0.022, 0.005, 0.0}, {-0.02, 0, 0}, 0.027, -0.1},  // triceps
      {{0.004, 0.09, 0.022},
       {0.012, -0.25, 0.012},
       {0.004, 0, 0.016},
       0.015,
       0.3},  // brachioradialis
      {{0.004, 0.02, -0.026}, {0.004, -0.25, -0.012}, {0.01, 0, -0.006}, 0.015, 0.1},  // flexor
      {{-0.008, 0.02, 0.026}, {-0.006, -0.26, 0.008}, {-0.01, 0, 0.012}, 0.013, 0.0},  // extensor
      {{0.0, 0.01, 0.0}, {-0.008, -0.2, -0.01}, {-0.012, 0, -0.008}, 0.014, 0.0},  // flexor ulnaris
  };
  static constexpr int kAround = 20, kRings = 17;
  Skeleton skeleton;
  Pose bind_pose;
  std::vector<Shape> below;  ///< bellies, then humerus and ulna at rest
  std::vector<int> bodies;
  TriMesh skin;
  Transform placed = Transform::Identity();  ///< of the whole

  TestArm() {
    skeleton.body_names = {"humerus", "ulna"};
    skeleton.parent = {-1, 0};
    bind_pose = pose(0.0);
    for (size_t m = 0; m < bellies.size(); ++m) {
      below.push_back(make_shape(belly(static_cast<int>(m), 0.0)));
      bodies.push_back(-1);
    }
    const auto bone = [](double from, double to) {
      return spindle(from, to, 16, 40, [=](double y, double) {
        const double end = std::min({1.0, (y - from) / 0.01, (to - y) / 0.01});
        return 0.011 * std::sqrt(1.0 - (1.0 - end) * (1.0 - end));
      });
    };
    // Condyles: the humerus widens to 56 mm at the elbow, and the end of the ulna lies behind it.
    TriMesh humerus = bone(-0.012, 0.3), ulna = bone(-0.27, 0.02);
    for (Vec3& p : humerus.vertices) p.z() *= 1.0 + 1.6 * (1.0 - smoothstep(0.0, 0.05, p.y()));
    for (Vec3& p : ulna.vertices) p += Vec3(-0.014, 0.0, 0.0);
    below.push_back(make_shape(humerus));
    below.push_back(make_shape(ulna));
    bodies.push_back(0);
    bodies.push_back(1);
    skin = cast_skin();
  }

  Pose pose(double degrees) const {
    Transform bend = Transform::Identity();
    bend.linear() = rotation_about(Vec3::UnitZ(), degrees * kDegree);
    return {placed, placed * bend};
  }

  // A spindle whose axis is a straight line, bowed out by `bulge`, between the two bones.
  TriMesh belly(int m, double degrees) const {
    const Belly& b = bellies[m];
    const Mat3 bend = rotation_about(Vec3::UnitZ(), degrees * kDegree);
    const Vec3 from = b.origin, to = bend * b.insertion;
    const Mat3 half =
        rotation_about(Vec3::UnitZ(), (b.insertion.y() < -0.15 ? 0.6 : 0.15) * degrees * kDegree);
    const Vec3 along = (to - from).normalized();
    const Vec3 side = Vec3::UnitZ().cross(along).normalized(), up = along.cross(side);
    const double grown = 1.0 + b.swelling * degrees / 130.0;
    TriMesh mesh = spindle(0.0, 1.0, kAround, kRings, [](double, double) { return 1.0; });
    for (Vec3& p : mesh.vertices) {
      const double u = p.y(), s = std::sin(M_PI * u),
                   r = 0.0025 + (b.radius * grown - 0.0025) * s * s;
      const Vec3 centre = from + u * (to - from) + s * (half * b.bulge);
      const bool pole = u <= 0.0 || u >= 1.0;
      p = centre + (pole ? 0.0 : r) * (p.x() * side - p.z() * up);
    }
    return mesh;
  }

  // All colliders at an angle, by fixed shapes that outlive the call.
  void move_to(double degrees) {
    const Pose now = pose(degrees);
    for (size_t j = 0; j < below.size(); ++j) {
      Shape& shape = below[j];
      const bool soft = bodies[j] < 0;
      const TriMesh mesh = soft ? belly(static_cast<int>(j), degrees) : shape.mesh;
      const Transform& frame = soft ? placed : now[bodies[j]];
      for (size_t i = 0; i < shape.x.size(); ++i) shape.x[i] = to_point(frame * mesh.vertices[i]);
      refit_bvh(shape.surface, shape.x, shape.bvh);
    }
  }

  std::vector<Collider> colliders() const {
    std::vector<Collider> all;
    for (const Shape& shape : below) all.push_back({&shape.surface, &shape.bvh, &shape.x, nullptr});
    return all;
  }

  SkinModel bind(const SkinSettings& settings = {}) const {
    return bind_skin(skin, skeleton, bind_pose, colliders(), bodies, settings);
  }

  // Rays from far outside end at the flesh; their ends are smoothed, with 4 mm of fat on top.
  TriMesh cast_skin() const {
    constexpr int kSkinAround = 64, kSkinRings = 78;
    constexpr double kFrom = -0.3, kTo = 0.33;
    std::vector<double> radius(kSkinAround * kSkinRings);
    for (int i = 0; i < kSkinRings; ++i) {
      for (int k = 0; k < kSkinAround; ++k) {
        const double y = kFrom + (kTo - kFrom) * (i + 1) / (kSkinRings + 1),
                     angle = 2 * M_PI * k / kSkinAround;
        double r = 0.1;
        for (double d = 1.0; d > 1e-4 && r > 0.012; r -= d) {
          d = 0.03;
          for (const Shape& shape : below) {
            const Vec3 p(r * std::cos(angle), y, r * std::sin(angle));
            const ClosestPoint near = closest_point(shape.surface, shape.bvh, shape.x, p, d);
            if (near.triangle >= 0) d = std::max(near.distance, 0.0);
          }
        }
        radius[i * kSkinAround + k] = std::max(r, 0.012);
      }
    }
    std::vector<double> smooth = radius;
    for (int round = 0; round < 60; ++round) {
      const std::vector<double> before = smooth;
      for (int i = 0; i < kSkinRings; ++i) {
        for (int k = 0; k < kSkinAround; ++k) {
          const auto at = [&](int row, int column) {
            return before[std::clamp(row, 0, kSkinRings - 1) * kSkinAround +
                          (column + kSkinAround) % kSkinAround];
          };
          const double mean = 0.25 * (at(i - 1, k) + at(i + 1, k) + at(i, k - 1) + at(i, k + 1));
          smooth[i * kSkinAround + k] = std::max(mean, radius[i * kSkinAround + k]);
        }
      }
    }
    return spindle(kFrom, kTo, kSkinAround, kSkinRings, [&](double y, double angle) {
      const int i =
          static_cast<int>(std::lround((y - kFrom) / (kTo - kFrom) * (kSkinRings + 1))) - 1;
      const int k = static_cast<int>(std::lround(angle / (2 * M_PI) * kSkinAround));
      const double end = std::min(i + 1, kSkinRings - i) / 4.0;  // rounded ends
      const double cap = end < 1.0 ? std::sqrt(1.0 - (1.0 - end) * (1.0 - end)) : 1.0;
      return (smooth[i * kSkinAround + k] + 0.004) * cap;
    });
  }
};

}  // namespace thew::tests
