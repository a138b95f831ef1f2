// SPDX-License-Identifier: Apache-2.0
#include "tools/author/skin.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rig/math.h"
#include "tools/author/bones.h"
#include "tools/author/smoothing.h"

namespace thew::tools {
namespace {

constexpr int kAround = 64, kRings = 78, kCapRings = 9;  // nodes a ring; rings, and of a cap
constexpr double kRoundest = 0.02;                       // m, radius of the sharpest bump
constexpr double kFat = 0.0027;                          // m, over muscle and bone
constexpr double kOutermost = 0.13;  // m from the axis, where the search inwards begins

// What fills an arm besides the twelve muscles: deltoid, the other muscles of the forearm, the
// palm.
BoneShape flesh() {
  const Vec3 x = Vec3::UnitX();
  BoneShape flesh{"", 0.025, {}, {}, {}};
  const Vec3 z = Vec3::UnitZ();
  flesh.strokes = {{{-0.004, -0.004, -0.006}, {0.002, -0.060, 0.002}, 0.048, 0.045},  // deltoid
                   {{0.002, -0.060, 0.002}, {0.003, -0.130, 0.000}, 0.045, 0.036},
                   {{0.003, -0.130, 0.000}, {0.003, -0.240, -0.002}, 0.036, 0.030},
                   {{0.003, -0.240, -0.002}, {0.000, -0.285, -0.004}, 0.029, 0.0215, 1.10, z},
                   {{0.000, -0.285, -0.004}, {-0.002, -0.335, 0.001}, 0.0215, 0.0335, 1.20, z},
                   {{-0.002, -0.335, 0.001}, {0.000, -0.380, 0.006}, 0.0335, 0.0335, 1.15, z},
                   {{0.000, -0.380, 0.006}, {0.003, -0.430, 0.014}, 0.0335, 0.0300, 1.10, z},
                   {{0.003, -0.430, 0.014}, {0.008, -0.475, 0.020}, 0.0300, 0.0245},
                   {{0.008, -0.475, 0.020}, {0.012, -0.515, 0.0250}, 0.0225, 0.0165, 1.20, x},
                   {{0.012, -0.515, 0.0250}, {0.015, -0.540, 0.0270}, 0.0160, 0.0130, 1.35, x},
                   {{0.022, -0.575, 0.0330}, {0.024, -0.612, 0.0360}, 0.0140, 0.0145, 2.00, x},
                   {{0.040, -0.568, 0.0300}, {0.052, -0.582, 0.0240}, 0.0120, 0.0120}};  // thumb
  return flesh;
}

// The axis that the rings stand about: y, x, z; linear between.
constexpr std::array<std::array<double, 3>, 8> kAxis = {{{0.000, -0.004, -0.008},
                                                         {-0.060, -0.001, -0.006},
                                                         {-0.130, 0.002, -0.004},
                                                         {-0.290, 0.005, -0.002},
                                                         {-0.350, 0.005, 0.004},
                                                         {-0.430, 0.010, 0.014},
                                                         {-0.530, 0.019, 0.027},
                                                         {-0.605, 0.024, 0.036}}};

Vec3 axis_point(double y) {
  size_t i = 1;
  while (i + 1 < kAxis.size() && kAxis[i][0] > y) ++i;
  const auto &a = kAxis[i - 1], &b = kAxis[i];
  const double t = (y - a[0]) / (b[0] - a[0]);
  return {a[1] + t * (b[1] - a[1]), y, a[2] + t * (b[2] - a[2])};
}

// A ray for each node, from the axis outwards; the caps' rays fan out from the axis' ends.
struct Ray {
  Vec3 origin, direction;
  double reach = 0.0;  // m, of the skin
  double least = 0.0;  // m, that keeps the clearance
};

// Ring heights between the caps: denser at the elbow, whose skin folds.
std::vector<double> ring_heights(int count) {
  const double top = kAxis.front()[0], bottom = kAxis.back()[0];
  const auto density = [](double y) {
    return 1.0 + 1.2 * smoothstep(-0.36, -0.30, y) * (1.0 - smoothstep(-0.29, -0.23, y));
  };
  constexpr int kSteps = 2000;
  std::vector<double> sum(kSteps + 1, 0.0), heights;
  for (int i = 0; i < kSteps; ++i) sum[i + 1] = sum[i] + density(top + (bottom - top) * i / kSteps);
  int step = 0;
  for (int k = 0; k < count; ++k) {
    while (step < kSteps && sum[step] < sum[kSteps] * k / (count - 1)) ++step;
    heights.push_back(top + (bottom - top) * step / kSteps);
  }
  return heights;
}

std::vector<Ray> make_rays() {
  std::vector<Ray> rays;
  const auto add = [&](const Vec3& origin, double tilt) {
    const SinCos up = sin_cos(tilt);
    for (int k = 0; k < kAround; ++k) {
      const SinCos turn = sin_cos(-2.0 * kPi * k / kAround);
      rays.push_back({origin, {up.cos * turn.cos, up.sin, up.cos * turn.sin}});
    }
  };
  const Vec3 top = axis_point(kAxis.front()[0]), bottom = axis_point(kAxis.back()[0]);
  rays.push_back({top, Vec3::UnitY()});
  for (int i = kCapRings; i > 0; --i) add(top, 0.5 * kPi * i / (kCapRings + 1));
  for (double y : ring_heights(kRings - 2 * kCapRings)) add(axis_point(y), 0.0);
  for (int i = 1; i <= kCapRings; ++i) add(bottom, -0.5 * kPi * i / (kCapRings + 1));
  rays.push_back({bottom, -Vec3::UnitY()});
  return rays;
}

Measured merge(const std::vector<TriMesh>& meshes) {
  TriMesh all;
  for (const TriMesh& mesh : meshes) {
    const int first = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const Triangle& t : mesh.triangles) {
      all.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
    }
  }
  return Measured(std::move(all));
}

// Unsigned: overlapping meshes (tendons in bone) have no sign, and the search never gets inside.
double distance_below(const Measured& below, const Vec3& p) {
  constexpr double kBound = 0.03;  // m, beyond which no distance is asked for
  const ClosestPoint near = closest_point(below.surface, below.bvh, below.x, p, kBound);
  return near.triangle < 0 ? kBound : (near.point - p).norm();
}

// From outside inwards until `outside` (a distance) is used up.
template <typename Outside>
double reach_of(const Ray& ray, const Outside& outside) {
  double r = kOutermost;
  for (int i = 0; i < 80 && r > 0.004; ++i) {
    const double d = outside(ray.origin + r * ray.direction);
    if (d < 1e-5) break;
    r -= 0.9 * d;
  }
  return r;
}

// Fat rounds off what stands out: no bump of the skin is sharper than a ball of this radius (m).
void round_bumps(double radius, std::vector<Ray>& rays) {
  const std::vector<Ray> before = rays;
  for (Ray& ray : rays) {
    for (const Ray& other : before) {
      const Vec3 beside =
          other.origin - ray.origin + other.reach * (other.direction - ray.direction);
      ray.reach = std::max(ray.reach, other.reach - beside.squaredNorm() / (2.0 * radius));
    }
  }
}

// The four nodes about one in the tube's grid; poles have a whole ring.
void smooth(std::vector<Ray>& rays) {
  const size_t last = rays.size() - 1;
  std::vector<double> before(rays.size());
  for (size_t i = 0; i <= last; ++i) before[i] = rays[i].reach;
  for (size_t i = 1; i < last; ++i) {
    const size_t ring = (i - 1) / kAround, k = (i - 1) % kAround, first = 1 + ring * kAround;
    const double up = ring > 0 ? before[i - kAround] : before[0];
    const double down = ring + 1 < kRings ? before[i + kAround] : before[last];
    const double mean = 0.25 * (up + down + before[first + (k + 1) % kAround] +
                                before[first + (k + kAround - 1) % kAround]);
    rays[i].reach = std::max(0.5 * (before[i] + mean), rays[i].least);
  }
  for (const size_t pole : {size_t{0}, last}) {
    double mean = 0.0;
    for (int k = 0; k < kAround; ++k) mean += before[pole == 0 ? 1 + k : last - 1 - k] / kAround;
    rays[pole].reach = std::max(mean, rays[pole].least);
  }
}

TriMesh mesh_of(const std::vector<Ray>& rays, const std::vector<Triangle>& triangles) {
  TriMesh mesh;
  for (const Ray& ray : rays) mesh.vertices.push_back(ray.origin + ray.reach * ray.direction);
  mesh.triangles = triangles;
  return mesh;
}

// Moves the nodes of every triangle whose middle or edges come too near outwards, for good.
bool keep_clear(const Measured& below, const TriMesh& mesh, double clearance,
                std::vector<Ray>& rays) {
  bool moved = false;
  const auto check = [&](const Vec3& p, const Triangle& t) {
    const double missing = clearance - distance_below(below, p);
    if (missing <= 0.0) return;
    moved = true;
    for (int node : t) rays[node].least = std::max(rays[node].least, rays[node].reach + missing);
  };
  for (const Triangle& t : mesh.triangles) {
    const Vec3 &a = mesh.vertices[t[0]], &b = mesh.vertices[t[1]], &c = mesh.vertices[t[2]];
    check((a + b + c) / 3.0, t);
    check(0.5 * (a + b), {t[0], t[1], t[1]});
    check(a, {t[0], t[0], t[0]});
  }
  for (Ray& ray : rays) ray.reach = std::max(ray.reach, ray.least);
  return moved;
}

}  // namespace

TriMesh arm_skin(const std::vector<TriMesh>& meshes, double clearance) {
  const Measured below = merge(meshes);
  const BoneShape filling = flesh();
  std::vector<Ray> rays = make_rays();
  for (Ray& ray : rays) {
    ray.least = reach_of(ray, [&](const Vec3& p) { return distance_below(below, p) - clearance; });
    ray.reach = reach_of(ray, [&](const Vec3& p) {
      return std::min(distance_below(below, p) - kFat, bone_distance(filling, p) / 2.0);
    });
  }
  const std::vector<Triangle> triangles = ordered_tube(kAround, kRings);
  round_bumps(kRoundest, rays);
  for (int pass = 0; pass < 16; ++pass) smooth(rays);
  for (int pass = 0; pass < 40 && keep_clear(below, mesh_of(rays, triangles), clearance, rays);
       ++pass) {
    smooth(rays);
  }
  return mesh_of(rays, triangles);
}

}  // namespace thew::tools
