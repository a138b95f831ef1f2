// SPDX-License-Identifier: Apache-2.0
#include "tools/export/fields.h"

#include <algorithm>
#include <cmath>

namespace thew::tools {
namespace {

// At the k-th point: to the point after from the point before. Points at one place, as in a path of
// no length, take the direction of the whole.
Vec3 tangent_at(const std::vector<Vec3>& line, std::size_t k) {
  const Vec3 along = line[std::min(k + 1, line.size() - 1)] - line[k > 0 ? k - 1 : 0];
  if (along.norm() > 0.0) return along.normalized();
  const Vec3 whole = line.back() - line.front();
  return whole.norm() > 0.0 ? Vec3(whole.normalized()) : Vec3(Vec3::UnitY());
}

// Principal stretches of a triangle: the square roots of the eigenvalues of C = F^T F, where F maps
// the triangle at rest, in its plane, to where it is. False where it has no area at rest.
bool stretches_of(const std::array<Vec3, 3>& rest, const std::array<Vec3, 3>& now, double& area,
                  std::array<double, 2>& stretches) {
  const Vec3 a = rest[1] - rest[0], b = rest[2] - rest[0];
  const double height = a.cross(b).norm();
  if (!(height > 0.0)) return false;
  area = 0.5 * height;
  // In a frame whose first axis is a: a = (l, 0), b = (c, h).
  const double l = a.norm(), c = a.dot(b) / l, h = height / l;
  const Vec3 u = (now[1] - now[0]) / l, v = (now[2] - now[0] - c * u) / h;
  const double mean = 0.5 * (u.dot(u) + v.dot(v)), half = 0.5 * (u.dot(u) - v.dot(v));
  const double radius = std::sqrt(half * half + u.dot(v) * u.dot(v));
  stretches = {std::sqrt(mean + radius), std::sqrt(std::max(mean - radius, 0.0))};
  return true;
}

}  // namespace

std::vector<Vec3> line_of_action(const ShotFrame& frame, std::size_t m, std::size_t i,
                                 const RigidMotion& rigid) {
  std::vector<Vec3> line = frame.lines[m];
  if (rigid.empty()) return line;
  const Transform back = rigid[i].inverse(Eigen::Isometry);
  for (Vec3& p : line) p = back * p;
  return line;
}

std::vector<Vec3> fibre_directions(const BakeMesh& mesh, const std::vector<Vec3>& line) {
  std::vector<Vec3> directions;
  if (line.size() < 2 || mesh.coordinates.empty()) return directions;
  std::vector<Vec3> tangents;
  for (std::size_t k = 0; k < line.size(); ++k) tangents.push_back(tangent_at(line, k));
  const double pieces = static_cast<double>(line.size() - 1);
  for (const auto& [share, angle, belly] : mesh.coordinates) {
    const double at = pieces * std::clamp(share, 0.0, 1.0);
    const auto k = std::min(static_cast<std::size_t>(at), line.size() - 2);
    const double after = at - static_cast<double>(k);
    const Vec3 between = (1.0 - after) * tangents[k] + after * tangents[k + 1];
    directions.push_back(between.norm() > 1e-6 ? Vec3(between.normalized()) : tangents[k]);
  }
  return directions;
}

std::vector<std::array<float, 2>> principal_stretches(const TriMesh& rest,
                                                      const std::vector<int>& first,
                                                      const std::vector<Vec3>& positions) {
  std::vector<double> areas(positions.size(), 0.0);
  std::vector<std::array<double, 2>> sums(positions.size(), {0.0, 0.0});
  for (const Triangle& t : rest.triangles) {
    double area = 0.0;
    std::array<double, 2> stretches;
    const auto corners = [&](const std::vector<Vec3>& x) {
      return std::array<Vec3, 3>{x[t[0]], x[t[1]], x[t[2]]};
    };
    if (!stretches_of(corners(rest.vertices), corners(positions), area, stretches)) continue;
    for (const int corner : t) {
      const int node = first[corner];
      areas[node] += area;
      for (std::size_t k = 0; k < 2; ++k) sums[node][k] += area * stretches[k];
    }
  }
  std::vector<std::array<float, 2>> result(positions.size(), {1.0f, 1.0f});
  for (std::size_t i = 0; i < result.size(); ++i) {
    const int node = first[i];
    if (!(areas[node] > 0.0)) continue;
    for (std::size_t k = 0; k < 2; ++k) {
      result[i][k] = static_cast<float>(sums[node][k] / areas[node]);
    }
  }
  return result;
}

}  // namespace thew::tools
