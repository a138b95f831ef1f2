// SPDX-License-Identifier: Apache-2.0
#include "skin/skinned_skin.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::skin {
namespace {

using PlaneConstraint = SkinnedWork::PlaneConstraint;
using Spot = SkinnedWork::Spot;

constexpr double kMostWay = 3.0;  // reaches that the skin goes with a muscle against its weights
constexpr int kRounds = 20;       // of evening out and of what then has to hold again

void smooth(const SkinnedSkin& skin, SkinnedWork& work) {
  for (int pass = 0; pass < skin.passes; ++pass) {
    work.before = work.by;
    for (size_t i = 0; i < work.by.size(); ++i) {
      const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
      if (begin == end) continue;
      Point sum{};
      for (int k = begin; k < end; ++k) sum += work.before[skin.neighbours[k]];
      work.by[i] = 0.5 * work.before[i] + (0.5 / (end - begin)) * sum;
    }
  }
}

double squared(const std::array<double, 3>& b) { return b[0] * b[0] + b[1] * b[1] + b[2] * b[2]; }

// The point's own offset is turned, and not its corners' with their different weights: of a wide
// triangle they are so much longer that nothing would be left of its direction.
void find_walls(const SkinnedSkin& skin, const std::vector<Collider>& below, SkinnedWork& work) {
  const double reach = skin.settings.reach, flat = skin.settings.lengths.flat;
  work.walls.assign(skin.points.size(), {});
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::Sample& point = skin.points[p];
    if (point.anchor.muscle < 0) continue;
    Mat3 turn = Mat3::Zero();
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      const int v = point.corners[k];
      const Affine blend = blended_transform(skin.weights, work.of_links, v);
      turn += point.shares[k] * blend.linear() * skin.from_rest[v];
    }
    PlaneConstraint& wall = work.walls[p];
    const Vec3 out = turn * point.anchor.out;
    const double left = out.norm();
    wall.above = point.anchor.out.norm();
    if (left < flat) continue;
    wall.normal = out / left;
    const Vec3 now = place_of(point.anchor, below), off = place_of(point, work.carried) - now;
    wall.level = wall.normal.dot(now);
    wall.carried = wall.normal.dot(off) + wall.level;
    const double slid = (off - wall.normal.dot(off) * wall.normal).norm();
    wall.hold = smoothstep(flat, 20.0 * flat, left) *
                (1.0 - smoothstep(reach, kMostNear * reach, wall.above)) *
                (1.0 - smoothstep(2.0 * reach, 4.0 * reach, slid));
    const double whole = wall.level + std::min(wall.above, skin.settings.thickness);
    wall.least = whole - (1.0 - wall.hold) * std::max(whole - wall.carried, 0.0);
  }
}

void push(const SkinnedSkin::Sample& point, const Vec3& by, Points& x) {
  const Vec3 each = by / squared(point.shares);
  for (int k = 0; k < 3; ++k) x[point.corners[k]] += to_point(point.shares[k] * each);
}

// Out or in with the muscle's place below, against where the weights would have it: each vertex the
// mean way that is asked for at its points.
void follow_anchors(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  const double most = kMostWay * skin.settings.reach;
  work.by.assign(x.size(), Point{});
  work.asked.assign(x.size(), 0.0);
  for (size_t p = 0; p < skin.points.size(); ++p) {
    const SkinnedSkin::Sample& point = skin.points[p];
    const PlaneConstraint& wall = work.walls[p];
    if (point.share <= 0.0) continue;
    const double way = std::clamp(wall.level + wall.above - wall.carried, -most, most);
    const Point by = to_point(point.share * wall.hold * way * wall.normal);
    for (int k = 0; k < 3; ++k) {
      if (point.shares[k] <= 0.0) continue;
      work.by[point.corners[k]] += point.shares[k] * by;
      work.asked[point.corners[k]] += point.shares[k];
    }
  }
  for (size_t i = 0; i < x.size(); ++i) {
    work.by[i] = work.asked[i] > 0.0 ? (1.0 / work.asked[i]) * work.by[i] : Point{};
  }
  work.before.resize(x.size());
  smooth(skin, work);
  for (size_t i = 0; i < x.size(); ++i) x[i] = work.carried[i] + work.by[i];
}

// Of what the weights alone would make, half its own and half the neighbours' mean, near muscles.
void even_out(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  for (size_t i = 0; i < x.size(); ++i) work.before[i] = x[i] - work.carried[i];
  for (size_t i = 0; i < x.size(); ++i) {
    const int begin = skin.first_neighbour[i], end = skin.first_neighbour[i + 1];
    if (!skin.near[i] || begin == end) continue;
    Point sum{};
    for (int k = begin; k < end; ++k) sum += work.before[skin.neighbours[k]];
    x[i] = work.carried[i] + 0.5 * work.before[i] + (0.5 / (end - begin)) * sum;
  }
}

// What the mean of several wishes left behind: as even as it can be with all points beyond theirs.
void stay_beyond(const SkinnedSkin& skin, SkinnedWork& work, Points& x) {
  for (int round = 0; round < kRounds; ++round) {
    even_out(skin, work, x);
    for (size_t p = 0; p < skin.points.size(); ++p) {
      const PlaneConstraint& wall = work.walls[p];
      const double lack = wall.least - wall.normal.dot(place_of(skin.points[p], x));
      if (lack > 0.0) push(skin.points[p], wall.hold * lack * wall.normal, x);
    }
  }
}

// m, half of the cylinder's length in which a point looks for samples; and the ball's around it.
double half_of(const SkinnedSkin& skin) {
  return 0.5 * (skin.settings.bridging + skin.settings.thickness);
}
double ball_of(const SkinnedSkin& skin) {
  const double beside = skin.settings.lengths.beside;
  return std::sqrt(half_of(skin) * half_of(skin) + beside * beside);
}

std::array<int, 3> cell_of(const Vec3& p, double size) {
  std::array<int, 3> cell;
  for (int k = 0; k < 3; ++k) cell[k] = static_cast<int>(std::floor(p[k] / size));
  return cell;
}

void find_spots(const SkinnedSkin& skin, const std::vector<Collider>& below,
                std::vector<Spot>& spots) {
  spots.clear();
  spots.reserve(skin.samples.size());
  const double size = ball_of(skin);
  for (const SkinnedSkin::Place& sample : skin.samples) {
    const Collider& muscle = below[sample.muscle];
    const Vec3 place = place_of(sample, below);
    spots.push_back(
        {cell_of(place, size), place, face_normal(*muscle.surface, *muscle.x, sample.triangle)});
  }
  std::sort(spots.begin(), spots.end(),
            [](const Spot& a, const Spot& b) { return a.cell < b.cell; });
}

// m, how far out along the normal a point has to go for the flesh that comes up through it. Each
// sample asks for less the farther beside the point it lies, the farther above it, and the less it
// faces the point's way, as that of a fold's other side: so that none begins or ends at once.
double lack_of(const SkinnedSkin& skin, const std::vector<Spot>& spots, const Vec3& p,
               const Vec3& normal) {
  const double room = skin.settings.bridging, size = ball_of(skin);
  const double reach = skin.settings.lengths.beside;
  const std::array<int, 3> middle =
      cell_of(p + (half_of(skin) - skin.settings.thickness) * normal, size);
  double most = 0.0;
  for (int k = 0; k < 9; ++k) {
    const std::array<int, 3> low = {middle[0] + k % 3 - 1, middle[1] + k / 3 - 1, middle[2] - 1};
    auto spot = std::lower_bound(
        spots.begin(), spots.end(), low,
        [](const Spot& one, const std::array<int, 3>& cell) { return one.cell < cell; });
    const std::array<int, 3> high = {low[0], low[1], low[2] + 2};
    for (; spot != spots.end() && spot->cell <= high; ++spot) {
      const Vec3 off = spot->place - p;
      const double above = normal.dot(off), asks = above + skin.settings.thickness;
      if (asks <= most) continue;
      const double beside = (off - above * normal).norm();
      most = std::max(most, asks * (1.0 - smoothstep(0.5 * reach, reach, beside)) *
                                (1.0 - smoothstep(0.5 * room, room, above)) *
                                smoothstep(0.0, 0.5, normal.dot(spot->normal)));
    }
  }
  return most;
}

// Out of flesh that the place below a point does not tell of: of muscles that slid or bulge beside.
// It is looked for once: from further out the next would be seen, and so through a fold's other
// side.
void raise_walls(const SkinnedSkin& skin, const Points& x, SkinnedWork& work) {
  for (size_t p = 0; p < skin.points.size(); ++p) {
    PlaneConstraint& wall = work.walls[p];
    if (wall.hold <= 0.0) continue;
    const Vec3 place = place_of(skin.points[p], x);
    const double lack = lack_of(skin, work.spots, place, wall.normal) - skin.points[p].lack;
    // Where little is asked for the place is not held either, or it would be all at once; but it is
    // let go by a thickness at most, or what lies far above its wall would be taken up all at once.
    const double thickness = skin.settings.thickness;
    const double share = wall.hold * smoothstep(0.0, thickness, lack);
    const double asked = wall.normal.dot(place) + std::max(lack, 0.0);
    wall.least = std::max(wall.least, asked - (1.0 - share) * thickness);
  }
}

// The corners of a wide triangle go farther than what they are asked for at a point within.
void keep_near(const SkinnedSkin& skin, const Points& carried, Points& x) {
  const double most = kMostWay * skin.settings.reach;
  for (size_t i = 0; i < x.size(); ++i) {
    const Point by = x[i] - carried[i];
    const double way = norm(by);
    if (way > most) x[i] = carried[i] + (most / way) * by;
  }
}

}  // namespace

Vec3 place_of(const SkinnedSkin::Place& of, const std::vector<Collider>& below) {
  const Collider& muscle = below[of.muscle];
  const Triangle& t = muscle.surface->triangles[of.triangle];
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 3; ++k) place += of.share[k] * to_vec((*muscle.x)[t[k]]);
  return place;
}

Vec3 place_of(const SkinnedSkin::Sample& point, const Points& x) {
  Point place{};
  for (int k = 0; k < 3; ++k) place += point.shares[k] * x[point.corners[k]];
  return to_vec(place);
}

void find_lacks(const std::vector<Collider>& below, SkinnedSkin& skin) {
  std::vector<Spot> spots;
  find_spots(skin, below, spots);
  for (SkinnedSkin::Sample& point : skin.points) {
    const double above = point.anchor.out.norm();
    if (above < skin.settings.lengths.flat) continue;
    point.lack = lack_of(skin, spots, place_of(point, skin.rest), point.anchor.out / above);
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
  find_walls(skin, below, work);
  follow_anchors(skin, work, state.x);
  stay_beyond(skin, work, state.x);
  find_spots(skin, below, work.spots);
  raise_walls(skin, state.x, work);
  stay_beyond(skin, work, state.x);
  keep_near(skin, work.carried, state.x);
  even_creases(skin, work, state.x);
  for (size_t i = 0; i < skin.rest.size(); ++i) state.x[i] = state.x[skin.map_back[i]];
}

}  // namespace thew::skin
