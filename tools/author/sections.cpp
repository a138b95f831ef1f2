// SPDX-License-Identifier: Apache-2.0
#include "tools/author/sections.h"

#include <algorithm>
#include <cmath>

#include "rig/math.h"

namespace thew::tools {
namespace {

constexpr double kTaper = 0.018;  // m, of a belly's ends: where it begins it is driven as tendon is
constexpr double kFlattest = 2.4;  // flatter sections have edges too sharp for their nodes

// Distances along the path.
std::vector<double> ring_places(const TableMuscle& muscle, double length) {
  const auto [from, to] = muscle.belly;
  std::vector<double> s = muscle.before;
  const int belly = muscle.rings - static_cast<int>(muscle.before.size() + muscle.after.size());
  for (int i = 0; i < belly; ++i) s.push_back(from + (to - from) * i / (belly - 1));
  for (double from_insertion : muscle.after) s.push_back(length - from_insertion);
  return s;
}

// The table's section in the plane across the path: linear between its rows. Before the first and
// after the last it lies on the path and shrinks towards the path's end.
TableSection section_at(const TableMuscle& muscle, const RestCurve& curve,
                        const CurvePoint& place) {
  TableSection before = muscle.sections.front();
  before.centre = curve.points.front();
  before.area = 0.0;
  const Vec3 tangent = place.frame.col(0);
  for (size_t i = 0; i <= muscle.sections.size(); ++i) {
    const bool end = i == muscle.sections.size();
    TableSection after = end ? before : muscle.sections[i];
    if (end) {
      after.centre = curve.points.back();
      after.area = 0.0;
    }
    const double d0 = tangent.dot(before.centre - place.point);
    const double d1 = tangent.dot(after.centre - place.point);
    if (d1 >= 0.0 || end) {
      const double t = d1 > d0 ? std::clamp(-d0 / (d1 - d0), 0.0, 1.0) : 1.0;
      const double side = before.along.dot(after.along) < 0.0 ? -1.0 : 1.0;
      const bool beyond = i == 0 || end;
      return {beyond ? place.point : Vec3(before.centre + t * (after.centre - before.centre)),
              before.area + t * (after.area - before.area),
              before.flatness + t * (after.flatness - before.flatness),
              ((1.0 - t) * before.along + t * side * after.along).normalized()};
    }
    before = after;
  }
  return before;
}

// The slab of this area.
Slab slab_of(double area, double flatness, const Vec3& along) {
  const double q = std::clamp(flatness, 1.0, kFlattest);
  const double radius = std::sqrt(area / (kPi + 4.0 * (q - 1.0)));
  return {(q - 1.0) * radius, radius, along};
}

// Nanometres, as the file holds them.
Vec3 rounded(const Vec3& p) {
  return {std::round(p.x() * 1e9) / 1e9, std::round(p.y() * 1e9) / 1e9,
          std::round(p.z() * 1e9) / 1e9};
}

TriMesh scaled_mesh(const SectionedMuscle& muscle, double scale) {
  TriMesh mesh;
  mesh.vertices.push_back(rounded(muscle.origin));
  for (size_t i = 0; i < muscle.sections.size(); ++i) {
    const Section& section = muscle.sections[i];
    const bool inside = section.belly && i > 0 && i + 1 < muscle.sections.size() &&
                        muscle.sections[i - 1].belly && muscle.sections[i + 1].belly;
    for (size_t k = 0; k < section.reach.size(); ++k) {
      const double reach = section.reach[k];
      // What touches others stays.
      const double scaled = std::min(scale * reach, std::max(section.limit[k], reach));
      mesh.vertices.push_back(
          rounded(section.centre + (inside ? scaled : reach) * section.directions[k]));
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

double slab_distance(const Slab& slab, const Vec3& centre, const Vec3& p) {
  const Vec3 v = p - centre;
  return (v - std::clamp(v.dot(slab.along), -slab.half, slab.half) * slab.along).norm() -
         slab.radius;
}

double slab_reach(const Slab& slab, const Vec3& direction) {
  const double c = std::abs(direction.dot(slab.along));
  const double s = std::sqrt(std::max(1.0 - c * c, 0.0));
  if (c * slab.radius <= s * slab.half) return slab.radius / s;  // its flat side
  return slab.half * c +
         std::sqrt(std::max(slab.radius * slab.radius - slab.half * slab.half * s * s, 0.0));
}

Slab grown(const Section& section) {
  return {section.slab.half, section.grow * section.slab.radius, section.slab.along};
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
                         table.around,
                         table.volume,
                         1.0,
                         {}};
  const std::vector<double> places = ring_places(table, path.length);
  const auto [from, to] = table.belly;
  double tendon_volume = 0.0, belly_volume = 0.0;
  std::vector<TableSection> measured;
  for (size_t i = 0; i < places.size(); ++i) {
    Section section;
    section.on_path = point_on(curve, places[i]);
    measured.push_back(section_at(table, curve, section.on_path));
    const double u = (places[i] - from) / (to - from), w = std::clamp(u, 0.0, 1.0);
    const double tendon = (1.0 - w) * table.tendon_radius[0] + w * table.tendon_radius[1];
    section.belly = u > -1e-9 && u < 1.0 + 1e-9;
    section.area = kPi * tendon * tendon;
    const double inside = std::min(places[i] - from, to - places[i]);
    const Vec3& on_path = section.on_path.point;
    section.wanted =
        on_path + smoothstep(0.0, 2.0 * kTaper, std::min(places[i], path.length - places[i])) *
                      (measured[i].centre - on_path);
    measured[i].area *= smoothstep(0.0, kTaper, inside);
    section.limit.assign(table.around, 1.0);
    section.directions.resize(table.around);
    for (int k = 0; k < table.around; ++k) section.angle.push_back(2.0 * kPi * k / table.around);
    set_directions(section);
    // Trapezia: half the way to both neighbours.
    const double before = i > 0 ? places[i - 1] : 0.0;
    const double after = i + 1 < places.size() ? places[i + 1] : path.length;
    tendon_volume += 0.5 * (after - before) * section.area;
    belly_volume += 0.5 * (after - before) * measured[i].area;
    muscle.sections.push_back(section);
  }
  const double largest = (table.volume - tendon_volume) / belly_volume;
  for (size_t i = 0; i < places.size(); ++i) {
    Section& section = muscle.sections[i];
    const Vec3 tangent = section.on_path.frame.col(0);
    const Vec3& along = measured[i].along;
    section.slab = slab_of(section.area + largest * measured[i].area,
                           section.belly ? measured[i].flatness : 1.0,
                           (along - along.dot(tangent) * tangent).normalized());
    section.area += largest * measured[i].area;
    section.wanted -= tangent.dot(section.wanted - section.on_path.point) * tangent;
    section.centre = section.wanted;
    section.reach.assign(table.around, section.slab.radius);
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
