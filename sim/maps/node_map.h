// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "rig/character.h"
#include "rig/import/mesh_import.h"

namespace thew::sim {

/// A number for each vertex of a mesh, as a scene gives it: weights, stiffness, fat, slide, and
/// thickness are all maps. It is given in one of these ways; the first that is not empty counts.
struct NodeMap {
  /// In which a value fades to the `base` of the map from the middle of a ball to its rim.
  struct Place {
    Vec3 centre = Vec3::Zero();  ///< m, in the rest pose
    double radius = 0.0;         ///< m
    double value = 0.0;
  };
  std::string location = {};  ///< begins messages; empty: there is no map
  std::string noun = {};      ///< what it is of, in messages: "weights"
  /// (u, value) along a belly, 0 at the origin's end.
  std::vector<std::array<double, 2>> keys = {};
  std::vector<double> list = {};  ///< by vertex of the mesh, or of its file
  std::vector<Place> places = {};
  double base = 0.0;
  /// The nearest of these points has the value, so that it outlives edits of the mesh.
  std::vector<Vec3> points = {};  ///< m, in the rest pose
  std::vector<double> at_points = {};
  double tolerance = 1e-3;             ///< m, how far a vertex may lie from the nearest point
  int channel = -1;                    ///< 0 to 3: which vertex colour it is; -1: none
  std::string attribute = {};          ///< the vertex attribute that it is; empty: none
  std::filesystem::path painted = {};  ///< the mesh that has them; empty: the map's own
  /// What a colour or attribute of 0 and of 1 stand for.
  std::array<double, 2> scale = {0.0, 1.0};
  std::array<double, 2> bounds = {0.0, 1e12};  ///< of each value

  bool given() const { return !location.empty(); }
};

/// The mesh that a map is of.
struct MappedMesh {
  const TriMesh& rest;           ///< m, in the rest pose
  const ImportedMesh& imported;  ///< as it was read; empty where it is of no file
  std::filesystem::path file = {};
  Eigen::Affine3d to_rest = Eigen::Affine3d::Identity();  ///< from its file
  const std::vector<double>* u = nullptr;                 ///< along the belly; null: it has none
  /// Set: the mesh is that of this character and `file`. Where its parts have no attribute or
  /// colour of the map, that means `otherwise`.
  const Character* character = nullptr;
  double otherwise = 0.0;
};

/// The values by vertex of `rest`. Error(kUsage) or Error(kInput), with the map's location, where
/// one is missing or out of bounds.
std::vector<double> map_values(const NodeMap& map, const MappedMesh& on);

/// All the same, and so one number; otherwise `values` stays.
bool take_constant(std::vector<double>& values, double& number);

/// Reflects its places at the plane x = 0.
void mirror_map(NodeMap& map);

/// Adds to the map what a text file says: the value of one vertex in each line, in the order of
/// the mesh, or "x y z value" for the vertices near that point.
void read_map_file(const std::filesystem::path& file, NodeMap& map);

}  // namespace thew::sim
