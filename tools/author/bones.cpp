// SPDX-License-Identifier: Apache-2.0
#include "tools/author/bones.h"

#include <algorithm>
#include <cmath>

#include "tools/author/level_grid.h"
#include "tools/author/remesh.h"

namespace thew::tools {
namespace {

double stroke_distance(const BoneStroke& s, const Vec3& p) {
  const Vec3 axis = s.to - s.from;
  const double length2 = axis.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp(axis.dot(p - s.from) / length2, 0.0, 1.0) : 0.0;
  const Vec3 v = p - s.from - t * axis;
  const double along = v.dot(s.flat_along);
  const double shrunk = v.squaredNorm() - (1.0 - 1.0 / (s.flat * s.flat)) * along * along;
  return std::sqrt(std::max(shrunk, 0.0)) - (s.from_radius + t * (s.to_radius - s.from_radius));
}

// Evens out the triangles: towards the mean of the neighbours, then back onto the surface.
void relax(const BoneShape& bone, TriMesh& mesh) {
  constexpr int kPasses = 8;  // and one that only smooths
  for (int pass = 0; pass <= kPasses; ++pass) {
    std::vector<Vec3> sum(mesh.vertices.size(), Vec3::Zero());
    std::vector<int> count(mesh.vertices.size(), 0);
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += mesh.vertices[t[(k + 1) % 3]];
        ++count[t[k]];
      }
    }
    for (size_t i = 0; i < sum.size(); ++i) {
      Vec3& p = mesh.vertices[i];
      p += (pass < kPasses ? 0.4 : 0.15) * (sum[i] / count[i] - p);
      if (pass == kPasses) continue;  // the last one takes out what is left of creases
      const Vec3 g = slope([&](const Vec3& at) { return bone_distance(bone, at); }, p, 1e-4);
      // Short steps: in a crease the slope says little.
      p -= std::clamp(bone_distance(bone, p), -0.001, 0.001) / std::max(g.squaredNorm(), 0.5) * g;
    }
  }
}

}  // namespace

double melt(double a, double b, double blend) {
  const double h = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * blend * h * h;
}

double bone_distance(const BoneShape& bone, const Vec3& p) {
  double d = 1e9;
  for (const BoneStroke& s : bone.strokes) d = melt(d, stroke_distance(s, p), bone.blend);
  for (const BoneStroke& s : bone.hollows) d = -melt(-d, stroke_distance(s, p), 0.25 * bone.blend);
  return d;
}

TriMesh bone_mesh(const BoneShape& bone) {
  Vec3 low = Vec3::Constant(1e9), high = -low;
  for (const BoneStroke& s : bone.strokes) {
    const double reach = s.flat * std::max(s.from_radius, s.to_radius);
    low = low.cwiseMin(s.from.cwiseMin(s.to) - Vec3::Constant(reach));
    high = high.cwiseMax(s.from.cwiseMax(s.to) + Vec3::Constant(reach));
  }
  LevelGrid grid = empty_grid(low - 1.7 * bone.cell, high, bone.cell);
  sample([&](const Vec3& p) { return bone_distance(bone, p); }, grid);
  TriMesh mesh = surface_nets(grid);
  relax(bone, mesh);
  smooth_folds(mesh);
  return mesh;
}

}  // namespace thew::tools
