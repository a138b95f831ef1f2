// SPDX-License-Identifier: Apache-2.0
#include "skin/skinned_skin.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::skin {
namespace {

using PlaneConstraint = SkinnedWork::PlaneConstraint;
using PlacedSample = SkinnedWork::PlacedSample;

// Most displacement by the muscles, in multiples of SkinSettings::reach; a limit of 30 mm was too
// little (skin/notes.md).
constexpr double kMaxDisplacement = 3.0;
constexpr int kRounds = 20;  // of smoothing and enforcing the planes again; chosen by trial

void smooth(const SkinnedSkin& skin, SkinnedWork& work) {
  for (int pass = 0; pass < skin.passes; ++pass) {
    for (const int i : skin.reached) work.before[i] = work.displacement[i];
    for (const int i : skin.reached) {
      const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      if (begin == end) continue;
      Point sum{};
      for (int k = begin; k < end; ++k) sum += work.before[skin.neighbours[k]];
      work.displacement[i] = 0.5 * work.before[i] + (0.5 / (end - begin)) * sum;
    }
  }
}

double squared(const std::array<double, 3>& b) { return b[0] * b[0] + b[1] * b[1] + b[2] * b[2]; }

// Sets the planes of all points. The offset of the point itself is rotated, not those of its
// corners, which have different weights: in a wide triangle their offsets are so long that the
// direction of the point would be lost.
void find_planes(const SkinnedSkin& skin, const std::vector<Collider>& below, SkinnedWork& work) {
  const double reach = skin.settings.reach, flat = skin.settings.lengths.least_offset;
  work.planes.assign(skin.points.size(), {});
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::SkinPoint& point = skin.points[p];
    if (point.anchor.muscle < 0) continue;
    Mat3 turn = Mat3::Zero();
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      const int v = point.corners[k];
      const Affine blend = blended_transform(skin.weights, work.of_links, v);
      turn += point.shares[k] * blend.linear() * skin.from_rest[v];
    }
    PlaneConstraint& plane = work.planes[p];
    const Vec3 out = turn * point.anchor.out;
    const double left = out.norm();
    plane.rest_height = point.anchor.out.norm();
    if (left < flat) continue;
    plane.normal = out / left;
    const Vec3 now = position_of(point.anchor, below), off = position_of(point, work.carried) - now;
    plane.level = plane.normal.dot(now);
    plane.carried_level = plane.normal.dot(off) + plane.level;
    const double slid = (off - plane.normal.dot(off) * plane.normal).norm();
    plane.strength = smoothstep(flat, 20.0 * flat, left) *
                     (1.0 - smoothstep(reach, kAnchorReach * reach, plane.rest_height)) *
                     (1.0 - smoothstep(2.0 * reach, 4.0 * reach, slid));
    const double whole = plane.level + std::min(plane.rest_height, skin.settings.thickness);
    plane.least_level = whole - (1.0 - plane.strength) * std::max(whole - plane.carried_level, 0.0);
  }
}

void displace(const SkinnedSkin::SkinPoint& point, const Vec3& by, Points& x) {
  const Vec3 each = by / squared(point.shares);
  for (int k = 0; k < 3; ++k) x[point.corners[k]] += to_point(point.shares[k] * each);
}

// Moves the skin out or in with the site of the muscle below it, relative to where the weights
// would carry the site. Each vertex takes the weighted mean of the displacements of its points.
void follow_anchors(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  const double most = kMaxDisplacement * skin.settings.reach;
  work.displacement.assign(x.size(), Point{});
  work.weight_sum.assign(x.size(), 0.0);
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::SkinPoint& point = skin.points[p];
    const PlaneConstraint& plane = work.planes[p];
    if (point.share <= 0.0) continue;
    const double distance =
        std::clamp(plane.level + plane.rest_height - plane.carried_level, -most, most);
    const Point by = to_point(point.share * plane.strength * distance * plane.normal);
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      work.displacement[point.corners[k]] += point.shares[k] * by;
      work.weight_sum[point.corners[k]] += point.shares[k];
    }
  }
  for (size_t i = 0; i < x.size(); ++i) {
    work.displacement[i] =
        work.weight_sum[i] > 0.0 ? (1.0 / work.weight_sum[i]) * work.displacement[i] : Point{};
  }
  work.before.assign(x.size(), Point{});
  smooth(skin, work);
  for (size_t i = 0; i < x.size(); ++i) x[i] = work.carried[i] + work.displacement[i];
}

// One pass of smoothing the displacement from the weights near muscles: half the own value, half
// the mean of the neighbours.
void even_out(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  for (const int i : skin.round_near) work.before[i] = x[i] - work.carried[i];
  for (const int i : skin.near_vertices) {
    const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
    if (begin == end) continue;
    Point sum{};
    for (int k = begin; k < end; ++k) sum += work.before[skin.neighbours[k]];
    x[i] = work.carried[i] + 0.5 * work.before[i] + (0.5 / (end - begin)) * sum;
  }
}

// Averaging leaves points behind their planes. This smooths the displacement and moves points back
// beyond their planes in turn.
void enforce_planes(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  for (int round = 0; round < kRounds; ++round) {
    even_out(skin, work, x);
    for (size_t p = 0; p < skin.points.size(); ++p) {
      const PlaneConstraint& plane = work.planes[p];
      const double lack = plane.least_level - plane.normal.dot(position_of(skin.points[p], x));
      if (lack > 0.0) displace(skin.points[p], plane.strength * lack * plane.normal, x);
    }
  }
}

// Half of the length (m) of the cylinder in which a point searches for samples; and below, the
// radius (m) of the ball around that cylinder.
double half_of(const SkinnedSkin& skin) {
  return 0.5 * (skin.settings.bridging + skin.settings.thickness);
}
double ball_of(const SkinnedSkin& skin) {
  const double beside = skin.settings.lengths.sample_reach;
  return std::sqrt(half_of(skin) * half_of(skin) + beside * beside);
}

std::array<int, 3> cell_of(const Vec3& p, double size) {
  std::array<int, 3> cell;
  for (int k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[k] / size));
  return cell;
}

void place_samples(const SkinnedSkin& skin, const std::vector<Collider>& below,
                   std::vector<PlacedSample>& placed) {
  placed.clear();
  placed.reserve(skin.muscle_samples.size());
  const double size = ball_of(skin);
  for (const SkinnedSkin::SurfaceSite& site : skin.muscle_samples) {
    const Collider& muscle = below[site.muscle];
    const Vec3 position = position_of(site, below);
    placed.push_back({cell_of(position, size), position,
                      face_normal(*muscle.surface, *muscle.x, site.triangle)});
  }
  std::sort(placed.begin(), placed.end(),
            [](const PlacedSample& a, const PlacedSample& b) { return a.cell < b.cell; });
}

// How far (m) a point has to move along the normal to be out of the flesh that comes up through it.
// A sample counts less with its distance beside and above the point and with the angle between the
// normals, as for the other side of a fold, so that none sets in or ends abruptly.
double lack_of(const SkinnedSkin& skin, const std::vector<PlacedSample>& placed, const Vec3& p,
               const Vec3& normal) {
  const double room = skin.settings.bridging, size = ball_of(skin);
  const double reach = skin.settings.lengths.sample_reach;
  const std::array<int, 3> middle =
      cell_of(p + (half_of(skin) - skin.settings.thickness) * normal, size);
  double most = 0.0;
  for (int k = 0; k < 9; ++k) {
    const std::array<int, 3> low = {middle[0] + k % 3 - 1, middle[1] + k / 3 - 1, middle[2] - 1};
    auto sample = std::lower_bound(
        placed.begin(), placed.end(), low,
        [](const PlacedSample& one, const std::array<int, 3>& cell) { return one.cell < cell; });
    const std::array<int, 3> high = {low[0], low[1], low[2] + 2};
    for (; sample != placed.end() && sample->cell <= high; ++sample) {
      const Vec3 off = sample->position - p;
      const double above = normal.dot(off), asks = above + skin.settings.thickness;
      if (asks <= most) continue;
      const double beside = (off - above * normal).norm();
      most = std::max(most, asks * (1.0 - smoothstep(0.5 * reach, reach, beside)) *
                                (1.0 - smoothstep(0.5 * room, room, above)) *
                                smoothstep(0.0, 0.5, normal.dot(sample->normal)));
    }
  }
  return most;
}

// Raises planes over flesh other than the site below a point: muscles that have slid aside or bulge
// beside it. The search is made once: repeated from farther out it would find the next flesh, and
// in the end go through the other side of a fold.
void raise_planes(const SkinnedSkin& skin, const Points& x, SkinnedWork& work) {
  for (size_t p = 0; p < skin.points.size(); ++p) {
    PlaneConstraint& plane = work.planes[p];
    if (plane.strength <= 0.0) continue;
    const Vec3 position = position_of(skin.points[p], x);
    const double lack = lack_of(skin, work.placed, position, plane.normal) - skin.points[p].lack;
    // Where the lack is small the point is not yet held at its height, so that this does not set in
    // abruptly. It may sink by a thickness at most, so that a point far above its plane is not
    // caught abruptly either.
    const double thickness = skin.settings.thickness;
    const double share = plane.strength * smoothstep(0.0, thickness, lack);
    const double asked = plane.normal.dot(position) + std::max(lack, 0.0);
    plane.least_level = std::max(plane.least_level, asked - (1.0 - share) * thickness);
  }
}

// Limits the displacement of each vertex: the corners of a wide triangle move farther than a point
// inside it has to.
void limit_displacement(const SkinnedSkin& skin, const Points& carried, Points& x) {
  const double most = kMaxDisplacement * skin.settings.reach;
  for (size_t i = 0; i < x.size(); ++i) {
    const Point by = x[i] - carried[i];
    const double distance = norm(by);
    if (distance > most) x[i] = carried[i] + (most / distance) * by;
  }
}

}  // namespace

Vec3 position_of(const SkinnedSkin::SurfaceSite& of, const std::vector<Collider>& below) {
  const Collider& muscle = below[of.muscle];
  const Triangle& t = muscle.surface->triangles[of.triangle];
  Vec3 position = Vec3::Zero();
  for (int k = 0; k < 3; ++k) position += of.share[k] * to_vec((*muscle.x)[t[k]]);
  return position;
}

Vec3 position_of(const SkinnedSkin::SkinPoint& point, const Points& x) {
  Point position{};
  for (int k = 0; k < 3; ++k) position += point.shares[k] * x[point.corners[k]];
  return to_vec(position);
}

void find_rest_lacks(const std::vector<Collider>& below, SkinnedSkin& skin) {
  std::vector<PlacedSample> placed;
  place_samples(skin, below, placed);
  for (SkinnedSkin::SkinPoint& point : skin.points) {
    const double above = point.anchor.out.norm();
    if (above < skin.settings.lengths.least_offset) continue;
    point.lack = lack_of(skin, placed, position_of(point, skin.rest), point.anchor.out / above);
  }
}

SkinState initial_skinned(const SkinnedSkin& skin) {
  SkinState state;
  state.x = skin.rest;
  state.bvh = build_bvh(skin.surface, state.x);
  return state;
}

void step_skinned(const SkinnedSkin& skin, const std::vector<Affine>& bodies,
                  const std::vector<Collider>& below, SkinState& state) {
  SkinnedWork& work = state.skinned;
  link_transforms(skin.weights, bodies, work.of_links);
  skin_by_links(skin.weights, skin.mesh, work.of_links, work.carried);
  find_planes(skin, below, work);
  follow_anchors(skin, work, state.x);
  enforce_planes(skin, work, state.x);
  place_samples(skin, below, work.placed);
  raise_planes(skin, state.x, work);
  enforce_planes(skin, work, state.x);
  limit_displacement(skin, work.carried, state.x);
  even_creases(skin, work, state.x);
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] = state.x[skin.map_back[i]];
}

}  // namespace thew::skin
