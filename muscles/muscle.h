// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "muscles/carried_shape.h"
#include "muscles/ring_springs.h"
#include "muscles/skyline.h"
#include "muscles/springs.h"
#include "muscles/volume_zones.h"
#include "muscles/zone.h"

namespace thew::muscles {

/// What a muscle is made of and driven by, besides its shape.
struct MuscleSettings {
  double guide = 250.0;       ///< 1/s^2: pull to the carried shape over mass; a soft body has none
  double damping = 20.0;      ///< 1/s, towards the velocity of the carried shape; a soft body: 0
  double f_max = 0.0;         ///< N; 0: passive
  double fibre_length = 0.1;  ///< m, optimal
  std::vector<std::array<double, 2>> activation;  ///< (frame, 0..1); empty: 0
  SpringMaterial material;
  std::optional<ZoneSettings> zone;  ///< weights follow the load
};

/// A muscle as it is given: arrays alone, all in the rest pose.
struct MuscleDef : MuscleSettings {
  std::string name;
  std::string location = {};  ///< where it was given, "arm.toml:12", for messages; may be empty
  TriMesh mesh;               ///< m; closed, outward, no two vertices at one place
  FileOrder order = {};       ///< in which a bake has it
  /// By node, 0 or more, in any unit: bulge and volume correction both go by it. Empty: even.
  std::vector<double> weights;
  /// Line of action, origin to insertion. Empty: a soft body, which springs of rest length and its
  /// volume alone shape, and which bodies may hold.
  MusclePath path;
  /// m along the rest path, first and last ring of the belly; both 0: a tenth of the path from its
  /// ends.
  std::array<double, 2> belly = {0.0, 0.0};
  double twist_from = 0.0;  ///< m along the rest path; beyond it the insertion's twist is taken
  bool swells = true;       ///< the target shape; else the weights alone
  std::vector<int> held;    ///< a soft body: by node the body that holds it, -1 none; empty: none
  int zones = 1;            ///< each keeps its volume
};

/// One muscle: what does not change during a bake.
struct Muscle {
  std::string name, location;
  TriMesh rest;
  FileOrder order;           ///< in which a bake has it
  double rest_volume = 0.0;  ///< m^3
  VolumeZones zones;         ///< empty: one multiplier for all of it
  SurfaceLinks zone_links;   ///< of an automatic deformation zone; empty: the weights are fixed
  CarriedShape shape;
  Springs springs;
  RingSprings rings;                       ///< the same by node
  std::vector<double> mass;                ///< kg
  double highest_frequency_squared = 0.0;  ///< 1/s^2, of the springs at rest
  std::vector<char> driven, free_nodes;
  std::vector<int> bodies;               ///< that move it, each once
  std::vector<double> authored_weights;  ///< as they were given, by node
  /// Of the multiplier: the authored ones, faded out towards the tendons; sum n, 0 where driven.
  std::vector<double> weights;
  double weight_floor = 0.0;  ///< added to all, where the authored lie on too few nodes
  bool swells = true;         ///< the target shape; else the weights alone
  MuscleSettings settings;
  Skyline stiffness;  ///< sum of spring stiffness over free nodes, N/m
  /// By node, N/m, 0 where driven: of the order by which a patch of nodes gives way together.
  std::vector<double> contact_stiffness;
  /// The springs between a free node and a driven one.
  struct Anchored {
    int node, anchor;
    double stiffness;  ///< N/m
  };
  std::vector<Anchored> anchored;

  bool has_path() const { return shape.held.empty(); }
};

/// The belly as given, or a tenth of the path from its ends. Error(kUsage) beyond the path.
std::array<double, 2> belly_of(const MuscleDef& def, const Pose& rest_pose);

/// Error(kUsage) with the muscle's place and name for arrays that do not fit one another, weights
/// that are none, a belly or twist beyond the path, a matrix that is too large.
Muscle build_muscle(const MuscleDef& def, const Pose& rest_pose, const Lengths& lengths);

}  // namespace thew::muscles
