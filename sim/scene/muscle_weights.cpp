// SPDX-License-Identifier: Apache-2.0
#include "sim/scene/muscle_weights.h"

#include <algorithm>
#include <cmath>

#include "rig/text.h"

namespace thew::sim {
namespace {

// One weight for each vertex of the mesh as it is simulated, or of its file, in which several
// vertices may have one position.
std::vector<double> by_order(const std::vector<double>& given, const TriMesh& rest,
                             const ImportedMesh& imported, const std::string& location) {
  const size_t nodes = rest.vertices.size();
  if (given.size() == nodes) return given;
  if (!imported.map_back.empty() && given.size() == imported.map_back.size()) {
    std::vector<double> weights(nodes, 0.0);
    for (size_t i = given.size(); i-- > 0;) weights[imported.map_back[i]] = given[i];
    return weights;
  }
  throw Error(ErrorCode::kUsage,
              location + ": " + std::to_string(given.size()) + " weights for a mesh of " +
                  std::to_string(nodes) +
                  " vertices; give one per vertex, in the file's order, or x y z "
                  "weight in each line");
}

std::vector<double> by_point(const SceneWeights& painted, const TriMesh& rest,
                             const std::string& location) {
  std::vector<double> weights;
  int lost = 0;
  double farthest = 0.0;
  std::string first;
  for (const Vec3& p : rest.vertices) {
    size_t best = 0;
    double least = 1e300;
    for (size_t k = 0; k < painted.points.size(); ++k) {
      const double d = (painted.points[k] - p).squaredNorm();
      if (d < least) least = d, best = k;
    }
    weights.push_back(painted.weights[best]);
    if (std::sqrt(least) <= painted.tolerance) continue;
    if (lost++ == 0) first = point_text(p);
    farthest = std::max(farthest, std::sqrt(least));
  }
  if (lost == 0) return weights;
  throw Error(ErrorCode::kUsage,
              location + ": " + std::to_string(lost) + " of " + std::to_string(weights.size()) +
                  " vertices, first at " + first + ", have no weight within " +
                  number_text(painted.tolerance) +
                  " m; paint them, or give weights a tolerance of " + number_text(1.01 * farthest));
}

void add_colours(const ImportedMesh& mesh, const Eigen::Affine3d& to_rest,
                 const std::string& location, SceneWeights& painted) {
  if (mesh.colours.empty()) {
    throw Error(ErrorCode::kUsage,
                location +
                    ": weights by colour, but the mesh has no vertex colours; export it with "
                    "them (PLY or glTF)");
  }
  for (size_t i = 0; i < mesh.colours.size(); ++i) {
    const double weight = mesh.colours[i][painted.channel];
    if (!(weight >= 0.0 && weight <= 1e12)) {
      throw Error(ErrorCode::kUsage, location + ": vertex " + std::to_string(i) +
                                         " has a colour of " + number_text(weight) +
                                         "; give 0 or more");
    }
    painted.points.push_back(to_rest * mesh.mesh.vertices[i]);
    painted.weights.push_back(weight);
  }
}

}  // namespace

std::vector<double> authored_weights(const SceneMuscle& scene, const TriMesh& rest,
                                     const std::vector<double>& u, const ImportedMesh& imported,
                                     const std::string& location) {
  if (!scene.node_weights.empty()) return by_order(scene.node_weights, rest, imported, location);
  SceneWeights painted = scene.painted;
  if (painted.channel >= 0 && painted.mesh.empty()) {
    add_colours(imported, Eigen::Affine3d::Identity(), location,
                painted);  // its vertices themselves
    return painted.weights;
  }
  if (painted.channel >= 0) {
    add_colours(import_mesh(painted.mesh), scene.mesh_to_rest, location, painted);
  }
  return painted.points.empty() ? profile_weights(scene.weights, u)
                                : by_point(painted, rest, location);
}

}  // namespace thew::sim
