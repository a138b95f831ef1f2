// SPDX-License-Identifier: Apache-2.0
#include "muscles/muscle.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "muscles/volume.h"
#include "muscles/weights.h"
#include "rig/math.h"

namespace thew::muscles {
namespace {

std::string begin_of_message(const MuscleDef& def) {
  return (def.location.empty() ? "" : def.location + ": ") + "muscle \"" + def.name + "\": ";
}

[[noreturn]] void refuse(const MuscleDef& def, const std::string& why) {
  throw Error(ErrorCode::kUsage, begin_of_message(def) + why);
}

// Refuses arrays whose size is not that of the mesh, and indices that are out of range.
void check_arrays(const MuscleDef& def, const Pose& rest_pose) {
  const size_t nodes = def.mesh.vertices.size();
  const auto count = [](size_t n) { return std::to_string(n); };
  if (nodes == 0) refuse(def, "its mesh is empty; give vertices and triangles");
  for (const auto& [size, what] :
       {std::pair(def.weights.size(), "weights"), std::pair(def.stiffness.size(), "stiffness"),
        std::pair(def.fixed_to.size(), "fixed_to")}) {
    if (size == 0 || size == nodes) continue;
    refuse(def, std::string(what) + " has " + count(size) + " values for a mesh of " +
                    count(nodes) + " nodes; give one per node");
  }
  const auto is_body = [&](int body) {
    return body >= 0 && body < static_cast<int>(rest_pose.size());
  };
  for (const Triangle& t : def.mesh.triangles) {
    for (const int i : t) {
      if (i < 0 || i >= static_cast<int>(nodes)) {
        refuse(def, "a triangle names vertex " + std::to_string(i) + " of " + count(nodes));
      }
    }
  }
  bool known = std::all_of(def.fixed_to.begin(), def.fixed_to.end(),
                           [&](int body) { return body == -1 || is_body(body); });
  for (const PathPoint& point : def.path.points) {
    known = known && is_body(point.body) && (point.with == -1 || is_body(point.with));
  }
  for (const WrapCylinder& wrap : def.path.wraps) known = known && is_body(wrap.body);
  if (!known) {
    refuse(def,
           "its path or fixed_to names a body beyond the skeleton's " + count(rest_pose.size()));
  }
  if (def.path.points.size() == 1) refuse(def, "its path has one point; give two or more, or none");
}

// Nodes outside the belly are driven, its two bounding rings included. The tolerance of 2 % of the
// belly is for rings that are a little oblique to the rounded path.
std::vector<char> driven_nodes(const CarriedShape& shape) {
  const double tolerance = 0.02 * (shape.belly[1] - shape.belly[0]);
  std::vector<char> driven(shape.along.size());
  for (size_t i = 0; i < driven.size(); ++i) {
    driven[i] =
        shape.along[i] < shape.belly[0] + tolerance || shape.along[i] > shape.belly[1] - tolerance;
  }
  return driven;
}

// Weights of the multiplier: the authored ones, faded out towards the tendons.
std::vector<double> multiplier_weights(const Muscle& muscle) {
  const double taper =
      muscle.swells
          ? 0.15
          : 0.30;  // share of the belly; shape = "weights" needs more, see muscles/notes.md
  std::vector<double> weights(muscle.authored_weights.size(), 0.0);
  for (size_t i = 0; i < weights.size(); ++i) {
    if (muscle.driven[i]) continue;
    weights[i] = muscle.authored_weights[i];
    if (!muscle.has_path()) continue;
    const double u = belly_coordinate(muscle.shape, static_cast<int>(i));
    weights[i] *= smoothstep(0.0, taper, u) * smoothstep(0.0, taper, 1.0 - u);
  }
  return normalised_weights(weights, muscle.driven);
}

Skyline spring_matrix(const Springs& springs, double shape, const std::vector<char>& driven) {
  Skyline matrix = make_skyline(static_cast<int>(driven.size()), springs.nodes, driven);
  for (size_t k = 0; k < springs.nodes.size(); ++k) {
    const auto& [a, b] = springs.nodes[k];
    const double stiffness = (1.0 + shape) * springs.stiffness[k];
    add_entry(matrix, a, a, stiffness);
    add_entry(matrix, b, b, stiffness);
    add_entry(matrix, a, b, -stiffness);
  }
  return matrix;
}

std::vector<double> contact_stiffness(const Skyline& matrix) {
  constexpr double kShare = 0.2;  // of the stiffness of the springs at the node; chosen by trial
  std::vector<double> stiffness(matrix.position.size(), 0.0);
  for (size_t node = 0; node < stiffness.size(); ++node) {
    const int i = matrix.position[node];
    if (i >= 0) stiffness[node] = kShare * matrix.values[matrix.start[i + 1] - 1];
  }
  return stiffness;
}

// Nodes that have to restore the volume all alone are torn out of the surface under any integrator.
// So no node may move more than kMaxShare times as far as under even weights.
void spread_weights(const Points& x, Muscle& muscle) {
  constexpr double kMaxShare = 3.0;  // chosen by trial
  Points gradient;
  volume_gradient(x, muscle.rest.triangles, gradient);
  std::vector<double> share;
  for (size_t i = 0; i < x.size(); ++i) {
    share.push_back(to_vec(gradient[i]).squaredNorm() / muscle.mass[i]);
  }
  muscle.weight_floor = limit_concentration(muscle.weights, share, muscle.driven, kMaxShare);
}

std::vector<int> bodies_of(const CarriedShape& shape) {
  std::set<int> bodies;
  for (const PathPoint& point : shape.path.points) {
    bodies.insert(point.body);
    if (point.with >= 0) bodies.insert(point.with);
  }
  for (const WrapCylinder& wrap : shape.path.wraps) bodies.insert(wrap.body);
  for (int body : shape.fixed_to) {
    if (body >= 0) bodies.insert(body);
  }
  return {bodies.begin(), bodies.end()};
}

void carry_along_path(const MuscleDef& def, const Pose& rest_pose, const Lengths& lengths,
                      Muscle& muscle) {
  const double length = trace_path(def.path, rest_pose).length;
  if (def.twist_from >= length) {
    refuse(def, "twist_from lies beyond the path, which is " + std::to_string(length) +
                    " m long at rest; give less");
  }
  muscle.shape = make_carried_shape(muscle.rest, def.path, rest_pose, belly_of(def, rest_pose),
                                    muscle.authored_weights, def.twist_from, lengths);
  muscle.swells = def.swells;
  muscle.driven = driven_nodes(muscle.shape);
}

void fix_to_bodies(const MuscleDef& def, const Pose& rest_pose, Muscle& muscle) {
  std::vector<int> fixed_to = def.fixed_to;
  fixed_to.resize(muscle.rest.vertices.size(), -1);
  muscle.shape = make_fixed_shape(muscle.rest, fixed_to, rest_pose);
  muscle.swells = false;
  for (int body : fixed_to) muscle.driven.push_back(body >= 0);
  if (std::find(muscle.driven.begin(), muscle.driven.end(), 0) == muscle.driven.end()) {
    refuse(def, "every node is fixed; make the boxes of [fixed] smaller");
  }
}

// Unit direction of the fibres at each node, along the path; empty for a soft body.
std::vector<Vec3> fibres_of(const Muscle& muscle, const Pose& rest_pose) {
  std::vector<Vec3> fibres;
  if (!muscle.has_path()) return fibres;
  const CarriedPose rest = carry_pose(muscle.shape, rest_pose);
  fibres.resize(muscle.rest.vertices.size());
  for (size_t i = 0; i < fibres.size(); ++i) {
    Vec3 point;
    curve_at(muscle.shape, rest, muscle.shape.along[i], point, fibres[i]);
  }
  return fibres;
}

void make_forces(const std::vector<Vec3>& fibres, const std::vector<double>& stiffness,
                 Muscle& muscle) {
  const SpringMaterial& material = muscle.settings.material;
  muscle.springs = make_springs(muscle.rest, fibres, material, stiffness);
  muscle.rings = make_ring_springs(muscle.rest.triangles, muscle.driven, muscle.springs);
  for (size_t k = 0; k < muscle.springs.nodes.size(); ++k) {
    auto [node, other] = muscle.springs.nodes[k];
    if (muscle.driven[node] == muscle.driven[other]) continue;
    if (muscle.driven[node]) std::swap(node, other);
    muscle.anchored.push_back({node, other, muscle.springs.stiffness[k]});
  }
  muscle.mass = lumped_masses(muscle.rest, material.density);
  muscle.highest_frequency_squared =
      highest_frequency_squared(muscle.springs, muscle.mass, muscle.driven);
  muscle.stiffness = spring_matrix(muscle.springs, material.shape, muscle.driven);
  muscle.contact_stiffness = contact_stiffness(muscle.stiffness);
}

// Divides the muscle into zones along the belly or, without a path, along its longest axis.
void divide(int count, Muscle& muscle) {
  std::vector<double> along;
  if (!muscle.has_path()) {
    along = longest_axis_coordinates(muscle.rest);
  } else {
    for (size_t i = 0; i < muscle.rest.vertices.size(); ++i) {
      along.push_back(belly_coordinate(muscle.shape, static_cast<int>(i)));
    }
  }
  muscle.zones = make_volume_zones(muscle.rest, along, count);
}

}  // namespace

std::array<double, 2> belly_of(const MuscleDef& def, const Pose& rest_pose) {
  const double length = trace_path(def.path, rest_pose).length;
  if (def.belly[1] <= def.belly[0]) return {0.1 * length, 0.9 * length};
  if (def.belly[0] < 0.0 || def.belly[1] > length) {
    refuse(def,
           "belly reaches beyond the path, which is " + std::to_string(length) + " m long at rest");
  }
  return def.belly;
}

Muscle build_muscle(const MuscleDef& def, const Pose& rest_pose, const Lengths& lengths) {
  check_arrays(def, rest_pose);
  Muscle muscle;
  muscle.name = def.name;
  muscle.location = def.location;
  muscle.settings = def;
  if (!def.stiffness.empty()) {  // where one number has to stand for all, it is the mean
    double sum = 0.0;
    for (const double stiffness : def.stiffness) sum += stiffness;
    muscle.settings.material.stiffness = sum / static_cast<double>(def.stiffness.size());
  }
  muscle.rest = def.mesh;
  if (def.zone) muscle.zone_links = surface_links(muscle.rest);
  muscle.order = def.order;
  muscle.authored_weights = def.weights;
  if (def.weights.empty()) muscle.authored_weights.assign(def.mesh.vertices.size(), 1.0);
  if (def.path.points.empty()) {
    fix_to_bodies(def, rest_pose, muscle);
  } else {
    carry_along_path(def, rest_pose, lengths, muscle);
  }
  for (char driven : muscle.driven) muscle.free_nodes.push_back(!driven);
  muscle.bodies = bodies_of(muscle.shape);
  const Points x = to_points(muscle.rest.vertices);
  muscle.rest_volume = enclosed_volume(x, muscle.rest.triangles);
  try {
    make_forces(fibres_of(muscle, rest_pose), def.stiffness, muscle);
    muscle.weights = multiplier_weights(muscle);
    spread_weights(x, muscle);
    if (def.zones > 1) divide(def.zones, muscle);
  } catch (const std::invalid_argument& error) {  // weights, zones
    refuse(def, error.what());
  } catch (const std::length_error& error) {  // the matrix
    refuse(def, error.what());
  }
  return muscle;
}

}  // namespace thew::muscles
