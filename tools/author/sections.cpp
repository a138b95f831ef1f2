// SPDX-License-Identifier: Apache-2.0
#include "tools/author/sections.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::tools {
namespace {

// 0 at the ends, 1 at `fullest`, with no other maximum; u in 0..1.
double spindle(double u, double fullest) {
  const double t = std::clamp(u < fullest ? u / fullest : (1.0 - u) / (1.0 - fullest), 0.0, 1.0);
  return 0.25 * t * t * (3.0 - 2.0 * t) + 0.75 * t * (2.0 - t);
}

// Distances along the path.
std::vector<double> ring_places(const TableMuscle& muscle, double length) {
  const auto [from, to] = muscle.belly;
  std::vector<double> s = muscle.before;
  const int belly = muscle.rings - static_cast<int>(muscle.before.size() + muscle.after.size());
  for (int i = 0; i < belly; ++i) s.push_back(from + (to - from) * i / (belly - 1));
  for (double from_insertion : muscle.after) s.push_back(length - from_insertion);
  return s;
}

// How far the section at `along` lies off the path: linear between the table's centres, nothing at
// the ends.
Vec3 lean_at(const TableMuscle& muscle, const RestCurve& curve, double along) {
  double s0 = 0.0;
  Vec3 lean0 = Vec3::Zero();
  for (size_t i = 0; i <= muscle.centres.size(); ++i) {
    const bool end = i == muscle.centres.size();
    const double s1 = end ? curve.path_length : muscle.centres[i].first;
    const Vec3 lean1 =
        end ? Vec3(Vec3::Zero()) : Vec3(muscle.centres[i].second - point_on(curve, s1).point);
    if (along <= s1) return lean0 + (along - s0) / (s1 - s0) * (lean1 - lean0);
    s0 = s1;
    lean0 = lean1;
  }
  return Vec3::Zero();
}

// Where the section at `along` lies: across the path, or across the direction that the table gives
// (linear between its rows).
CurvePoint place_of(const TableMuscle& muscle, const RestCurve& curve, double along) {
  CurvePoint place = point_on(curve, along);
  if (muscle.across.empty()) return place;
  size_t i = 0;
  while (i + 1 < muscle.across.size() && muscle.across[i].first < along) ++i;
  const auto& [s1, after] = muscle.across[i];
  const auto& [s0, before] = muscle.across[i > 0 ? i - 1 : 0];
  const double t = s1 > s0 ? std::clamp((along - s0) / (s1 - s0), 0.0, 1.0) : 1.0;
  place.frame = frame_along(
      (before.normalized() + t * (after.normalized() - before.normalized())).normalized(),
      place.frame.col(1));
  return place;
}

// Nanometres, as the file holds them.
Vec3 rounded(const Vec3& p) {
  return {std::round(p.x() * 1e9) / 1e9, std::round(p.y() * 1e9) / 1e9,
          std::round(p.z() * 1e9) / 1e9};
}

TriMesh scaled_mesh(const SectionedMuscle& muscle, double scale) {
  TriMesh mesh;
  mesh.vertices.push_back(rounded(muscle.origin));
  for (const Section& section : muscle.sections) {
    for (size_t k = 0; k < section.reach.size(); ++k) {
      mesh.vertices.push_back(
          rounded(section.centre + scale * section.reach[k] * section.directions[k]));
    }
  }
  mesh.vertices.push_back(rounded(muscle.insertion));
  mesh.triangles = ordered_tube(muscle.around, static_cast<int>(muscle.sections.size()));
  return mesh;
}

}  // namespace

std::vector<Triangle> ordered_tube(int around, int rings) {
  std::vector<Triangle> triangles;
  const auto node = [&](int ring, int k) { return 1 + ring * around + k % around; };
  for (int k = 0; k < around; ++k) triangles.push_back({0, node(0, k), node(0, k + 1)});
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < around; ++k) {
      const int a = node(ring, k), b = node(ring, k + 1);
      const int c = node(ring + 1, k), d = node(ring + 1, k + 1);
      if (k % 2 == 0) {  // alternate diagonals: no sense of twist
        triangles.push_back({b, a, c});
        triangles.push_back({b, c, d});
      } else {
        triangles.push_back({b, a, d});
        triangles.push_back({a, c, d});
      }
    }
  }
  const int last = 1 + rings * around;
  for (int k = 0; k < around; ++k) {
    triangles.push_back({node(rings - 1, k + 1), node(rings - 1, k), last});
  }
  return triangles;
}

// Against the path's sense, so that the first triangle faces out.
void set_directions(Section& section) {
  const Mat3& frame = section.on_path.frame;
  for (size_t k = 0; k < section.angle.size(); ++k) {
    const SinCos turn = sin_cos(-section.angle[k]);
    section.directions[k] = turn.cos * frame.col(1) + turn.sin * frame.col(2);
  }
}

void even_out(Section& section) {
  const size_t n = section.reach.size();
  std::vector<double> length(n + 1, 0.0), angle = section.angle;
  angle.push_back(2.0 * kPi);
  for (size_t k = 0; k < n; ++k) {
    const size_t l = (k + 1) % n;
    const Vec3 side =
        section.reach[l] * section.directions[l] - section.reach[k] * section.directions[k];
    length[k + 1] = length[k] + side.norm();
  }
  size_t k = 0;
  for (size_t i = 1; i < n; ++i) {
    const double wanted = length[n] * i / n;
    while (k + 1 < n && length[k + 1] < wanted) ++k;
    const double t = (wanted - length[k]) / (length[k + 1] - length[k]);
    const double even = angle[k] + t * (angle[k + 1] - angle[k]);
    const double uniform = 2.0 * kPi * i / n;
    // Half of the way only: rings that differ much would twist the mesh.
    section.angle[i] += 0.3 * (0.5 * (even + uniform) - section.angle[i]);
  }
  set_directions(section);
}

SectionedMuscle make_sections(const TableMuscle& table, const Pose& rest, const Vec3& humerus) {
  TracedPath path = trace_path(table.path, rest);
  for (Vec3& p : path.points) p -= humerus;
  const RestCurve curve = make_rest_curve(path);
  SectionedMuscle muscle{path.points.front(),
                         path.points.back(),
                         table.path.points.front().body,
                         table.path.points.back().body,
                         {table.tendon_radius[0], table.tendon_radius[1]},
                         table.flat,
                         table.flat_along,
                         table.around,
                         table.volume,
                         1.0,
                         {}};
  const std::vector<double> places = ring_places(table, path.length);
  const auto [from, to] = table.belly;
  double tendon_volume = 0.0, spindle_volume = 0.0;
  for (size_t i = 0; i < places.size(); ++i) {
    Section section;
    section.on_path = place_of(table, curve, places[i]);
    const double u = (places[i] - from) / (to - from), w = std::clamp(u, 0.0, 1.0);
    const double tendon = (1.0 - w) * table.tendon_radius[0] + w * table.tendon_radius[1];
    section.belly = u > -1e-9 && u < 1.0 + 1e-9;
    section.area = kPi * tendon * tendon;
    section.radius = spindle(u, table.fullest);
    section.wanted = section.on_path.point + lean_at(table, curve, places[i]);
    section.reach.assign(table.around, tendon);
    section.limit.assign(table.around, 1.0);
    section.directions.resize(table.around);
    for (int k = 0; k < table.around; ++k) section.angle.push_back(2.0 * kPi * k / table.around);
    set_directions(section);
    // Trapezia: half the way to both neighbours.
    const double before = i > 0 ? places[i - 1] : 0.0;
    const double after = i + 1 < places.size() ? places[i + 1] : path.length;
    tendon_volume += 0.5 * (after - before) * section.area;
    spindle_volume += 0.5 * (after - before) * section.radius;
    muscle.sections.push_back(section);
  }
  const double largest = (table.volume - tendon_volume) / spindle_volume;
  for (Section& section : muscle.sections) {
    section.area += largest * section.radius;
    section.radius = std::sqrt(section.area / kPi);
    const Vec3 tangent = section.on_path.frame.col(0);
    section.wanted -= tangent.dot(section.wanted - section.on_path.point) * tangent;
    section.centre = section.wanted;
    std::fill(section.reach.begin(), section.reach.end(), section.radius);
  }
  return muscle;
}

double area_of(const Section& section) {
  const size_t n = section.reach.size();
  Vec3 twice = Vec3::Zero();
  for (size_t k = 0; k < n; ++k) {
    const size_t l = (k + 1) % n;
    twice +=
        section.reach[k] * section.reach[l] * section.directions[l].cross(section.directions[k]);
  }
  return 0.5 * twice.dot(section.on_path.frame.col(0));
}

Vec3 centroid_of(const Section& section) {
  const size_t n = section.reach.size();
  Vec3 moment = Vec3::Zero();
  double area = 0.0;
  for (size_t k = 0; k < n; ++k) {
    const size_t l = (k + 1) % n;
    const double share =
        section.reach[k] * section.reach[l] *
        section.directions[l].cross(section.directions[k]).dot(section.on_path.frame.col(0));
    area += share;
    moment += share / 3.0 *
              (section.reach[k] * section.directions[k] + section.reach[l] * section.directions[l]);
  }
  return section.centre + moment / area;
}

TriMesh mesh_of(const SectionedMuscle& muscle) { return scaled_mesh(muscle, 1.0); }

TriMesh exact_mesh_of(const SectionedMuscle& muscle) {
  double scale = 1.0;
  TriMesh mesh = scaled_mesh(muscle, scale);
  for (int i = 0; i < 20; ++i) {  // volume goes with the square of the scale
    scale *= std::sqrt(muscle.volume / enclosed_volume(mesh));
    mesh = scaled_mesh(muscle, scale);
  }
  return mesh;
}

}  // namespace thew::tools
