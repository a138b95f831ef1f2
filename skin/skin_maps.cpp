// SPDX-License-Identifier: Apache-2.0
//
// What an artist paints on a skin layer: how thick its fat is, and how freely it slides.
#include <algorithm>
#include <cmath>

#include "skin/flesh_level.h"
#include "skin/skin_passes.h"

namespace thew::skin {
namespace {

// The frame of a place of a surface: its normal, and the first edge of its triangle across that.
Mat3 frame_at(const Collider& flesh, const SkinSite& site) {
  const Triangle& t = flesh.surface->triangles[site.triangle];
  const Vec3 n = smooth_normal(*flesh.surface, *flesh.x, site.triangle, site.barycentric.data());
  const Vec3 edge = to_vec((*flesh.x)[t[1]] - (*flesh.x)[t[0]]);
  const Vec3 along = (edge - n.dot(edge) * n).normalized();
  Mat3 frame;
  frame << along, n.cross(along), n;
  return frame;
}

Vec3 place_of(const Collider& flesh, const SkinSite& site) {
  const Triangle& t = flesh.surface->triangles[site.triangle];
  Vec3 place = Vec3::Zero();
  for (int k = 0; k < 3; ++k) place += site.barycentric[k] * to_vec((*flesh.x)[t[k]]);
  return place;
}

}  // namespace

void shape_fat(const std::vector<Collider>& below, const std::vector<double>& fat,
               const std::vector<Vec3>& normals, SkinModel& model) {
  if (fat.empty()) return;
  constexpr int kRounds = 20;  // the level is curved; each round takes what the plane leaves
  const Lengths& lengths = model.settings.lengths;
  const double bridging = model.settings.bridging, reach = lengths.farthest_bone;
  const size_t nodes = model.rest.size();
  FleshPlanes planes;
  planes.planes.resize(nodes);
  planes.count.resize(nodes);
  std::vector<int> hints(nodes * (below.size() + 1), -1);
  for (size_t i = 0; i < nodes; ++i) {
    const int node = static_cast<int>(i);
    for (int round = 0; fat[i] >= 0.0 && round < kRounds; ++round) {
      find_flesh(below, model.rest, {1, {node}}, reach, bridging, lengths.least_direction, hints,
                 planes);
      const FleshValue flesh = flesh_value(planes, node, to_vec(model.rest[i]), bridging);
      if (!flesh.found) break;
      const double lack = fat[i] - flesh.level;
      if (std::abs(lack) < lengths.clearance) break;
      const Vec3 out = outward_direction(flesh.gradient_of_level, to_point(normals[i]));
      model.rest[i] += to_point(climb_distance(flesh.gradient_of_level, out, lack) * out);
    }
  }
}

void bind_slide(const std::vector<Collider>& below, const std::vector<double>& slide,
                double mean_edge, SkinModel& model) {
  if (std::all_of(slide.begin(), slide.end(), [](double s) { return s == 1.0; })) return;
  // With a slide of 1/2 skin that sticks draws its neighbours along over a quarter of the length
  // over which an anchor does (3 cm of a grown man), whatever the mesh.
  constexpr double kShare = 0.25;
  constexpr double kLeast = 0.01;  // sticks: neighbours are drawn along over 3 mm
  const double hold = mean_edge / (kShare * model.settings.lengths.anchor_length);
  model.sites.resize(slide.size());
  model.stick.assign(slide.size(), 0.0);
  for (size_t i = 0; i < slide.size(); ++i) {
    double nearest = model.settings.lengths.farthest_bone;
    const Vec3 x = to_vec(model.rest[i]);
    SkinSite& site = model.sites[i];
    for (size_t c = 0; c < below.size(); ++c) {
      const ClosestPoint near =
          closest_point(*below[c].surface, *below[c].bvh, *below[c].x, x, nearest);
      if (near.triangle < 0 || std::abs(near.distance) >= nearest) continue;
      nearest = std::abs(near.distance);
      site = {static_cast<int>(c), near.triangle, {}, Vec3::Zero()};
      std::copy(near.barycentric, near.barycentric + 3, site.barycentric.begin());
    }
    if (site.collider < 0) continue;
    model.stick[i] = hold * hold * (1.0 - slide[i]) / std::max(slide[i], kLeast);
    const Collider& flesh = below[site.collider];
    site.offset = frame_at(flesh, site).transpose() * (x - place_of(flesh, site));
  }
}

void find_stuck(const SkinModel& model, const std::vector<Collider>& below, SkinState& state) {
  for (size_t i = 0; i < model.sites.size(); ++i) {
    const SkinSite& site = model.sites[i];
    if (site.collider < 0) continue;
    const Collider& flesh = below[site.collider];
    state.stuck[i] = to_point(place_of(flesh, site) + frame_at(flesh, site) * site.offset);
  }
}

}  // namespace thew::skin
