// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/truth.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "tools/lab/base/searched_mesh.h"

namespace thew::tools {
namespace {

constexpr int kParts = 4;  // of a quadratic face's edge

// Faces opposite each corner: three corners and the middles between them.
constexpr int kFaces[4][6] = {
    {1, 2, 3, 7, 9, 8}, {0, 3, 2, 6, 9, 5}, {0, 1, 3, 4, 8, 6}, {0, 2, 1, 5, 7, 4}};

Vec3 on_face(const Vec3* node, double a, double b) {
  const double c = 1.0 - a - b;
  return c * (2 * c - 1) * node[0] + a * (2 * a - 1) * node[1] + b * (2 * b - 1) * node[2] +
         4 * c * a * node[3] + 4 * a * b * node[4] + 4 * b * c * node[5];
}

void add_face(const Vec3* node, TriMesh& mesh) {
  const auto point = [&](int i, int j) {
    mesh.vertices.push_back(on_face(node, double(i) / kParts, double(j) / kParts));
    return static_cast<int>(mesh.vertices.size()) - 1;
  };
  for (int i = 0; i < kParts; ++i) {
    for (int j = 0; i + j < kParts; ++j) {
      mesh.triangles.push_back({point(i, j), point(i + 1, j), point(i, j + 1)});
      if (i + j + 1 < kParts) {
        mesh.triangles.push_back({point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)});
      }
    }
  }
}

TriMesh surface_of(const FemBody& body, const std::vector<Vec3>& x) {
  std::map<Triangle, int> times;  // inner faces are of two elements
  const auto key = [&](int e, const int* f) {
    Triangle corners;
    for (int k = 0; k < 3; ++k) corners[k] = body.elements[10 * e + f[k]];
    std::sort(corners.begin(), corners.end());
    return corners;
  };
  for (int e = 0; e < body.count(); ++e) {
    for (const auto& f : kFaces) ++times[key(e, f)];
  }
  TriMesh mesh;
  for (int e = 0; e < body.count(); ++e) {
    for (const auto& f : kFaces) {
      bool outside = times[key(e, f)] == 1;
      Vec3 node[6];
      for (int k = 0; k < 6; ++k) {
        const int i = body.elements[10 * e + f[k]];
        outside = outside && body.surface[i];
        node[k] = x[i];
      }
      if (outside) add_face(node, mesh);
    }
  }
  return mesh;
}

FemStep rest_step() {
  FemStep step;
  step.iterations = 100;
  step.tolerance = 1e-6;
  step.firmness = 2e4;
  return step;
}

void load_at(const TruthScene& scene, double share, FemBody& body, FemStep& step) {
  if (scene.drive) scene.drive(share, body);
  if (scene.beyond) {
    step.obstacle = [&scene, share](const Vec3& p) { return scene.beyond(share, p); };
  }
}

bool bring_to_rest(const TruthScene& scene, FemBody& body) {
  FemStep step = rest_step();
  step.direct = true;
  bool converged = true;
  std::vector<Vec3> before = body.x;
  for (int k = 1; k <= scene.steps && converged; ++k) {
    const std::vector<Vec3> start = body.x;
    for (size_t i = 0; i < body.x.size(); ++i) body.x[i] += start[i] - before[i];  // as it went on
    before = start;
    load_at(scene, double(k) / scene.steps, body, step);
    converged = solve_step(body, step).converged;
  }
  return converged;
}

// Where the quadratic elements of `coarse` have a point of the rest shape.
Vec3 carried(const FemBody& coarse, const Vec3& p) {
  for (int e = 0; e < coarse.count(); ++e) {
    const int* node = &coarse.elements[10 * e];
    Mat3 edges;
    for (int k = 0; k < 3; ++k) edges.col(k) = coarse.rest[node[k + 1]] - coarse.rest[node[0]];
    const Vec3 inner = edges.inverse() * (p - coarse.rest[node[0]]);
    const double l[4] = {1.0 - inner.sum(), inner.x(), inner.y(), inner.z()};
    if (*std::min_element(l, l + 4) < -1e-9) continue;
    Vec3 at = Vec3::Zero();
    for (int k = 0; k < 4; ++k) at += l[k] * (2.0 * l[k] - 1.0) * coarse.x[node[k]];
    for (int m = 0; m < 6; ++m) {
      at += 4.0 * l[kMiddles[m][0]] * l[kMiddles[m][1]] * coarse.x[node[4 + m]];
    }
    return at;
  }
  return p;
}

// From the rest of a coarser mesh, which is near: conjugate gradients need no factor of what is
// large.
bool bring_to_rest(const TruthScene& scene, const FemBody& coarse, FemBody& body) {
  for (size_t i = 0; i < body.x.size(); ++i) body.x[i] = carried(coarse, body.rest[i]);
  FemStep step = rest_step();
  load_at(scene, 1.0, body, step);
  return solve_step(body, step).converged;
}

std::array<long, 3> place_key(const Vec3& p) {
  return {std::lround(1e8 * p.x()), std::lround(1e8 * p.y()), std::lround(1e8 * p.z())};
}

// By node of `coarse`: the same point of `fine`, which has all of them.
std::vector<int> same_nodes(const FemBody& coarse, const FemBody& fine) {
  std::map<std::array<long, 3>, int> at;
  for (size_t i = 0; i < fine.rest.size(); ++i) at[place_key(fine.rest[i])] = static_cast<int>(i);
  std::vector<int> out;
  for (const Vec3& p : coarse.rest) out.push_back(at.at(place_key(p)));
  return out;
}

double node_difference(const FemBody& coarse, const FemBody& fine) {
  const std::vector<int> same = same_nodes(coarse, fine);
  double sum = 0.0;
  for (size_t i = 0; i < same.size(); ++i) sum += (coarse.x[i] - fine.x[same[i]]).norm();
  return sum / static_cast<double>(same.size());
}

std::vector<Vec3> surface_nodes(const FemBody& body) {
  std::vector<Vec3> out;
  for (size_t i = 0; i < body.x.size(); ++i) {
    if (body.surface[i]) out.push_back(body.x[i]);
  }
  return out;
}

double mean_distance_to(const std::vector<Vec3>& points, const TriMesh& mesh) {
  const SearchedMesh surface(mesh);
  double sum = 0.0;
  for (const Vec3& p : points) sum += (surface.nearest(p, 1.0).point - p).norm();
  return sum / static_cast<double>(points.size());
}

using Place = RoundBody::Place;

Vec3 in_space(const Place& p, int axis) {
  return axis == 0 ? Vec3(p[1], p[0], 0.0) : Vec3(p[0], p[1], 0.0);
}
Place in_section(const Vec3& p, int axis) {
  const Vec3 d = p.cwiseAbs();
  return {std::hypot(p[(axis + 1) % 3], p[(axis + 2) % 3]), d[axis]};
}

bool bring_to_rest(const TruthScene& scene, RoundBody& body) {
  bool converged = true;
  std::vector<Place> before = body.x;
  for (int k = 1; k <= scene.steps && converged; ++k) {
    const double share = static_cast<double>(k) / scene.steps;
    const std::vector<Place> start = body.x;
    for (size_t i = 0; i < start.size(); ++i) {
      for (int c = 0; c < 2; ++c) body.x[i][c] += start[i][c] - before[i][c];  // as it went on
    }
    before = start;
    if (scene.drive_round) scene.drive_round(share, body);
    std::function<Place(const Place&)> beyond;
    if (scene.beyond) {
      beyond = [&](const Place& p) {
        const Vec3 depth = scene.beyond(share, in_space(p, scene.axis));
        return scene.axis == 0 ? Place{depth.y(), depth.x()} : Place{depth.x(), depth.y()};
      };
    }
    converged = rest_round(beyond, 1e-8, body);
  }
  return converged;
}

double distance_to_line(const Place& p, const std::vector<Place>& line) {
  double least = 1e300;
  for (size_t k = 0; k + 1 < line.size(); ++k) {
    const double ax = line[k][0], az = line[k][1], dx = line[k + 1][0] - ax,
                 dz = line[k + 1][1] - az;
    const double t =
        std::clamp(((p[0] - ax) * dx + (p[1] - az) * dz) / (dx * dx + dz * dz), 0.0, 1.0);
    least = std::min(least, std::hypot(p[0] - ax - t * dx, p[1] - az - t * dz));
  }
  return least;
}

double rim_distance(const RoundBody& body, const std::vector<Place>& line) {
  double sum = 0.0;
  for (const int node : body.rim) sum += distance_to_line(body.x[node], line);
  return sum / static_cast<double>(body.rim.size());
}

// Mean distance of the nodes along the rims; the finer has each second one besides.
double rim_difference(const RoundBody& coarse, const RoundBody& fine) {
  double sum = 0.0;
  for (size_t k = 0; k < coarse.rim.size(); ++k) {
    const Place &a = coarse.x[coarse.rim[k]], &b = fine.x[fine.rim[2 * k]];
    sum += std::hypot(a[0] - b[0], a[1] - b[1]);
  }
  return sum / static_cast<double>(coarse.rim.size());
}

double order_of(const std::vector<double>& moved) {
  const size_t last = moved.size();
  if (last < 2) return 1.0;
  return std::clamp(std::log2(moved[last - 2] / moved[last - 1]), 0.5, 4.0);
}

Truth round_truth(const TruthScene& scene) {
  constexpr int kPieces = 8;  // of a quadratic edge
  Truth out;
  out.axis = scene.axis;
  std::vector<RoundBody> bodies;
  std::vector<double> moved;
  for (int k = 0, n = scene.coarsest; k < scene.meshes; ++k, n *= 2) {
    RoundBody& body = bodies.emplace_back(scene.round(n));
    const double rest = volume_of(body);
    out.converged = bring_to_rest(scene, body) && out.converged;
    out.elements.push_back(static_cast<int>(body.elements.size()));
    out.volume_error = std::abs(volume_of(body) / rest - 1.0);
    if (k == 0) continue;
    moved.push_back(rim_difference(bodies[k - 1], body));
    out.apart.push_back(rim_distance(bodies[k - 1], rim_line(body, kPieces)));
  }
  out.order = order_of(moved);
  // x = x_fine + (x_fine - x_coarse) / (2^order - 1), at the nodes of both.
  const double more = 1.0 / (std::pow(2.0, out.order) - 1.0);
  const RoundBody& fine = bodies.back();
  RoundBody limit = bodies[bodies.size() - 2];
  for (size_t k = 0; k < limit.rim.size(); ++k) {
    for (int c = 0; c < 2; ++c) {
      double& at = limit.x[limit.rim[k]][c];
      const double to = fine.x[fine.rim[2 * k]][c];
      at = to + more * (to - at);
    }
  }
  out.profile = rim_line(limit, kPieces);
  out.error = rim_distance(fine, out.profile);
  return out;
}

}  // namespace

Truth find_truth(const TruthScene& scene) {
  if (scene.round) return round_truth(scene);
  Truth out;
  std::vector<FemBody> bodies;
  std::vector<double> moved;  // by mesh but the first, m
  for (int k = 0, n = scene.coarsest; k < scene.meshes; ++k, n *= 2) {
    FemBody& body = bodies.emplace_back(scene.body(n));
    const double rest = fem_volume(body);
    out.converged =
        (k == 0 ? bring_to_rest(scene, body) : bring_to_rest(scene, bodies[k - 1], body)) &&
        out.converged;
    out.elements.push_back(body.count());
    out.volume_error = std::abs(fem_volume(body) / rest - 1.0);
    if (k == 0) continue;
    moved.push_back(node_difference(bodies[k - 1], body));
    out.apart.push_back(mean_distance_to(surface_nodes(bodies[k - 1]), surface_of(body, body.x)));
  }
  const size_t last = bodies.size() - 1;
  out.order = order_of(moved);
  const double more = 1.0 / (std::pow(2.0, out.order) - 1.0);
  const std::vector<int> same = same_nodes(bodies[last - 1], bodies[last]);
  std::vector<Vec3> limit = bodies[last - 1].x;
  for (size_t i = 0; i < limit.size(); ++i) {
    const Vec3& fine = bodies[last].x[same[i]];
    limit[i] = fine + more * (fine - limit[i]);
  }
  out.surface = surface_of(bodies[last - 1], limit);
  out.error = mean_distance_to(surface_nodes(bodies[last]), out.surface);
  return out;
}

double mean_distance(const std::vector<Vec3>& points, const Truth& truth) {
  if (truth.profile.empty()) return mean_distance_to(points, truth.surface);
  double sum = 0.0;
  for (const Vec3& p : points) sum += distance_to_line(in_section(p, truth.axis), truth.profile);
  return sum / static_cast<double>(points.size());
}

}  // namespace thew::tools
