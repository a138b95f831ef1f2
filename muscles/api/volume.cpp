// SPDX-License-Identifier: Apache-2.0
#include "thew/volume.h"

#include <string>

#include "muscles/volume.h"
#include "rig/api/arrays.h"

namespace thew {
namespace {

struct Body {
  Body(std::span<const double> positions, std::span<const int> corners) {
    const rig::TriMesh mesh = rig::to_tri_mesh(positions, corners);
    rig::check_triangles(mesh);
    x = rig::to_points(mesh.vertices);
    triangles = mesh.triangles;
  }
  rig::Points x;
  std::vector<rig::Triangle> triangles;
};

void check_count(std::span<const double> values, std::size_t nodes, const char* what) {
  if (values.size() == nodes) return;
  throw Error(ErrorCode::kUsage, std::string(what) + " has " + std::to_string(values.size()) +
                                     " values for " + std::to_string(nodes) +
                                     " vertices; give one per vertex");
}

}  // namespace

std::vector<double> volume_gradient(std::span<const double> positions,
                                    std::span<const int> triangles) {
  const Body body(positions, triangles);
  rig::Points gradient;
  muscles::volume_gradient(body.x, body.triangles, gradient);
  std::vector<double> array;
  array.reserve(positions.size());
  for (const rig::Point& row : gradient) array.insert(array.end(), {row[0], row[1], row[2]});
  return array;
}

RestoredVolume restore_volume(std::span<double> positions, std::span<const int> triangles,
                              std::span<const double> weights, std::span<const double> inverse_mass,
                              double volume) {
  Body body(positions, triangles);
  const std::size_t nodes = body.x.size();
  if (!weights.empty()) check_count(weights, nodes, "weights");
  check_count(inverse_mass, nodes, "inverse_mass");
  rig::Points direction;
  muscles::volume_gradient(body.x, body.triangles, direction);
  for (std::size_t i = 0; i < nodes; ++i) {
    direction[i] *= (weights.empty() ? 1.0 : weights[i]) * inverse_mass[i];
  }
  const muscles::VolumeRoot root =
      muscles::nearest_root(muscles::volume_along(body.x, direction, body.triangles), volume);
  for (std::size_t i = 0; i < nodes; ++i) {
    body.x[i] += root.s * direction[i];
    for (std::size_t k = 0; k < 3; ++k) positions[3 * i + k] = body.x[i][k];
  }
  return {root.s, root.reached, muscles::enclosed_volume(body.x, body.triangles)};
}

}  // namespace thew
