// SPDX-License-Identifier: Apache-2.0
#include "tools/author/smoothing.h"

#include <algorithm>
#include <utility>

namespace thew::tools {
namespace {

void shorten(SectionedMuscle& muscle, int node, double by) {
  const int around = muscle.around;
  if (node == 0 || node > around * static_cast<int>(muscle.sections.size())) return;  // the poles
  Section& section = muscle.sections[(node - 1) / around];
  double& limit = section.limit[(node - 1) % around];
  limit = std::min(limit, section.reach[(node - 1) % around] - by);
}

}  // namespace

double allowed_depth(const SectionedMuscle& muscle, bool belly, int body, const Vec3& p) {
  constexpr double kPatch = 0.010;  // m, round an attachment: there tendons may enter their bone
  if (belly) return 0.0;
  double share = 0.0;
  if (body == muscle.origin_body) share = 1.0 - (p - muscle.origin).norm() / kPatch;
  if (body == muscle.insertion_body) {
    share = std::max(share, 1.0 - (p - muscle.insertion).norm() / kPatch);
  }
  return std::max(share, 0.0) * 0.008;
}

Measured::Measured(TriMesh m) : mesh(std::move(m)) {
  surface = make_surface(mesh.triangles, static_cast<int>(mesh.vertices.size()));
  x = to_points(mesh.vertices);
  bvh = build_bvh(surface, x);
  for (const Triangle& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] < t[(k + 1) % 3]) edges.push_back({t[k], t[(k + 1) % 3]});
    }
  }
}

void blunt(const Measured& mine, const std::vector<Vec3>& nodes, SectionedMuscle& muscle) {
  constexpr double kSharpest = 0.2;  // cosine of the angle between the normals
  constexpr double kShare = 0.03;    // of the reach
  const Points x = to_points(nodes);
  for (int t = 0; t < static_cast<int>(mine.mesh.triangles.size()); ++t) {
    const Triangle& corners = mine.mesh.triangles[t];
    for (int k = 0; k < 3; ++k) {
      const int across = mine.surface.neighbours[t][k];
      if (across < t) continue;
      const Vec3 normal = face_normal(mine.surface, x, t);
      if (normal.dot(face_normal(mine.surface, x, across)) > kSharpest) continue;
      const int a = corners[k], b = corners[(k + 1) % 3], c = corners[(k + 2) % 3];
      const Triangle& others = mine.mesh.triangles[across];
      const int d = others[0] + others[1] + others[2] - a - b;
      const bool ridge = normal.dot(nodes[d] - nodes[a]) < 0.0;
      for (const int node : {ridge ? a : c, ridge ? b : d}) {
        if (node == 0 || node + 1 == static_cast<int>(nodes.size())) continue;
        const Section& section = muscle.sections[(node - 1) / muscle.around];
        shorten(muscle, node, kShare * section.reach[(node - 1) % muscle.around]);
      }
    }
  }
}

void draw_back(const Measured& other, bool is_bone, int body, const Measured& mine,
               SectionedMuscle& muscle) {
  constexpr double kReach = 0.004;  // m, how deep crossings are looked for
  const int around = muscle.around, last = static_cast<int>(mine.mesh.vertices.size()) - 1;
  const auto is_belly = [&](int node) {
    return node != 0 && node != last && muscle.sections[(node - 1) / around].belly;
  };
  const auto missing = [&](const ClosestPoint& near, const Vec3& p, bool belly) {
    const double allowed = is_bone ? allowed_depth(muscle, belly, body, p) : 0.0;
    return kGap - allowed - near.distance;
  };
  const double share = is_bone ? 0.8 : 0.4;
  const auto check = [&](const Vec3& p, int a, int b) {  // a node of mine, or an edge's middle
    const ClosestPoint near = closest_point(other.surface, other.bvh, other.x, p, kReach);
    if (near.triangle < 0) return;
    const double by = missing(near, p, is_belly(a) && is_belly(b));
    if (by <= 0.0) return;
    shorten(muscle, a, share * by);
    shorten(muscle, b, share * by);
  };
  const auto check_other = [&](const Vec3& p) {
    const ClosestPoint near = closest_point(mine.surface, mine.bvh, mine.x, p, kReach);
    if (near.triangle < 0) return;
    const Triangle& corners = mine.mesh.triangles[near.triangle];
    const double by = missing(near, p, std::all_of(corners.begin(), corners.end(), is_belly));
    if (by <= 0.0) return;
    for (int k = 0; k < 3; ++k) {
      if (near.barycentric[k] >= 0.15) shorten(muscle, corners[k], share * by);
    }
  };
  for (int node = 1; node < last; ++node) check(mine.mesh.vertices[node], node, node);
  for (const auto& [a, b] : mine.edges) {
    check(0.5 * (mine.mesh.vertices[a] + mine.mesh.vertices[b]), a, b);
  }
  for (const Vec3& p : other.mesh.vertices) check_other(p);
  for (const auto& [a, b] : other.edges) {
    check_other(0.5 * (other.mesh.vertices[a] + other.mesh.vertices[b]));
  }
}

}  // namespace thew::tools
