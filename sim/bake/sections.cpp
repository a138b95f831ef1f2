// SPDX-License-Identifier: Apache-2.0
#include "sim/bake/sections.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "rig/vectorise.h"

namespace thew::sim {
namespace {

constexpr int kSections = 24;  // across a belly, for its mean area
constexpr int kWidth = 4;  // doubles, of the widest vector that all processors of ten years have

// Sections of one muscle, each in a lane.
struct Sections {
  using Lanes = double __attribute__((vector_size(8 * kWidth)));
  static constexpr int kGroups = (kSections + kWidth - 1) / kWidth;
  Lanes along[kGroups];  // m, on the rest curve
  Lanes point[3][kGroups], tangent[3][kGroups];
  double reach = 0.0;  // m, along the rest curve, within which nodes belong to a section
  int count = 0;
};

void add_section(const Muscle& muscle, const CarriedPose& pose, double u, Sections& sections) {
  const auto& belly = muscle.shape.belly;
  const double length = belly[1] - belly[0], along = belly[0] + u * length;
  Vec3 point, tangent;
  curve_at(muscle.shape, pose, along, point, tangent);
  const int group = sections.count / kWidth, lane = sections.count % kWidth;
  sections.along[group][lane] = along;
  for (int k = 0; k < 3; ++k) {
    sections.point[k][group][lane] = point[k];
    sections.tangent[k][group][lane] = tangent[k];
  }
  sections.reach = std::max(0.35 * length, muscle.shape.lengths.section_reach);
  ++sections.count;
}

// Of a node, one bit for each section: whether it is below the plane, and whether it is near enough
// along the muscle.
struct NodeBits {
  std::uint32_t below, near;
};

using Mask = std::int64_t __attribute__((vector_size(8 * kWidth)));

[[gnu::always_inline]] inline std::uint32_t gathered(const Mask& bits) {
  std::int64_t all = 0;
  for (int lane = 0; lane < kWidth; ++lane) all |= bits[lane];
  return static_cast<std::uint32_t>(all);
}

THEW_VECTORISED
void find_bits(const Sections& sections, const std::vector<double>& along, const Points& x,
               std::vector<NodeBits>& bits) {
  bits.resize(x.size());
  for (size_t i = 0; i < x.size(); ++i) {
    Mask below = {}, near = {}, bit = {1, 2, 4, 8};
    for (int g = 0; g < Sections::kGroups; ++g, bit <<= kWidth) {
      Sections::Lanes term[3];
      for (int k = 0; k < 3; ++k) {
        term[k] = sections.tangent[k][g] * (x[i][k] - sections.point[k][g]);
      }
      // In the order of Vec3::dot(), so that signs are the same as in cut().
      below |= (term[0] + (term[1] + term[2]) < 0.0) & bit;
      const Sections::Lanes off = along[i] - sections.along[g];
      near |= ((off < 0.0 ? -off : off) < sections.reach) & bit;
    }
    bits[i] = {gathered(below), gathered(near)};
  }
}

// Half the cross product of the crossings of two edges of a triangle with the plane of section s,
// along its tangent; 0 if it has not two.
double cut(const Sections& sections, int s, const Triangle& t, const Points& x) {
  const int g = s / kWidth, lane = s % kWidth;
  Vec3 point, tangent;
  for (int k = 0; k < 3; ++k) {
    point[k] = sections.point[k][g][lane];
    tangent[k] = sections.tangent[k][g][lane];
  }
  double height[3];
  for (int k = 0; k < 3; ++k) height[k] = tangent.dot(to_vec(x[t[k]]) - point);
  Vec3 in = Vec3::Zero(), out = Vec3::Zero();
  int crossings = 0;
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3;
    if ((height[k] < 0.0) == (height[next] < 0.0)) continue;
    const double share = height[k] / (height[k] - height[next]);
    const Vec3 p = (1.0 - share) * to_vec(x[t[k]]) + share * to_vec(x[t[next]]) - point;
    (height[k] < 0.0 ? in : out) = p;
    ++crossings;
  }
  return crossings == 2 ? 0.5 * tangent.dot(out.cross(in)) : 0.0;
}

// Areas (m^2) of the sections, over the triangles near them: half the sums of crossings' cross
// products, closed or not.
std::array<double, kSections> areas_of(const Sections& sections, const Muscle& muscle,
                                       const Points& x) {
  thread_local std::vector<NodeBits> bits;
  find_bits(sections, muscle.shape.along, x, bits);
  std::array<double, kSections> areas{};
  const std::uint32_t wanted = (std::uint32_t{1} << sections.count) - 1;
  for (const Triangle& t : muscle.rest.triangles) {
    const NodeBits &a = bits[t[0]], &b = bits[t[1]], &c = bits[t[2]];
    std::uint32_t crossed = ((a.below ^ b.below) | (a.below ^ c.below)) & a.near & b.near & c.near;
    for (crossed &= wanted; crossed != 0; crossed &= crossed - 1) {
      const int s = std::countr_zero(crossed);
      areas[s] += cut(sections, s, t, x);
    }
  }
  for (double& area : areas) area = std::abs(area);
  return areas;
}

}  // namespace

double section_area_at(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u) {
  Sections one{};
  add_section(muscle, pose, u, one);
  return areas_of(one, muscle, x)[0];
}

double mean_belly_area(const Muscle& muscle, const CarriedPose& pose, const Points& x) {
  if (!muscle.shape.fixed_to.empty()) return 1.0;  // no path, no sections
  Sections all{};
  for (int k = 0; k < kSections; ++k) add_section(muscle, pose, (k + 0.5) / kSections, all);
  double sum = 0.0;
  for (const double area : areas_of(all, muscle, x)) sum += area;
  return sum / kSections;
}

}  // namespace thew::sim
