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

/// How hard a muscle pulls by what the rig does: the sum of its curves, clamped to 0..1.
struct JointActivation {
  /// A mass that hangs at a point of a body.
  struct Load {
    double mass = 0.0;  ///< kg
    std::string body;
    Vec3 at = Vec3::Zero();  ///< m, in the body's frame
    int index = -1;          ///< of the body; a model sets it
  };
  std::string joint;
  std::vector<std::array<double, 2>> curve;  ///< (degrees, or m of a slider; activation)
  std::vector<std::array<double, 2>> speed;  ///< (degrees/s, or m/s; activation)
  /// Held by all muscles that have this load, in equal parts of what each can.
  std::optional<Load> load;
  int body = -1;  ///< that the joint moves; a model sets it
  /// (rad or m, moment arm in m) at joint values, the other joints at rest; a model sets it where
  /// there is a load.
  std::vector<std::array<double, 2>> moment_arm;
};

/// Material and drive of a muscle. The defaults were chosen by trial on the arm.
struct MuscleSettings {
  /// 1/s^2: stiffness towards the carried shape over mass; 0 for a soft body.
  double guide = 250.0;
  double damping = 20.0;  ///< 1/s, against the velocity relative to the carried shape; for a soft
                          ///< body relative to rest
  double f_max = 0.0;     ///< N, maximal isometric force; 0: a passive muscle
  double fibre_length = 0.1;                      ///< m, optimal fibre length
  std::vector<std::array<double, 2>> activation;  ///< keys (frame, activation 0..1); empty: 0
  std::optional<JointActivation> by_joint = {};   ///< in place of keys
  SpringMaterial material;
  std::optional<ZoneSettings> zone;  ///< if given, the weights follow the load (eq. 15)
};

/// The definition of a muscle: arrays alone, all in the rest pose.
struct MuscleDef : MuscleSettings {
  std::string name;
  std::string location = {};  ///< where it was defined, for messages: "arm.toml:12"; may be empty
  TriMesh mesh;               ///< m; closed, facing outwards, no two vertices at one position
  FileOrder order = {};       ///< in which a bake stores it
  /// By node, 0 or more, in any unit: each node's part in the swelling of the belly and in the
  /// volume correction. Empty: all 1.
  std::vector<double> weights;
  std::vector<double> stiffness = {};  ///< N/m, by node; empty: material.stiffness everywhere
  /// Line of action from origin to insertion. Empty for a soft body, which is shaped by springs and
  /// volume alone and may be fixed to bodies.
  MusclePath path;
  /// m along the rest path, where the belly begins and ends. Both 0: a tenth of the path from its
  /// ends.
  std::array<double, 2> belly = {0.0, 0.0};
  /// m along the rest path; the twist of the insertion is distributed beyond it.
  double twist_from = 0.0;
  bool swells = true;  ///< true: shape = "target"; false: shape = "weights"
  /// For a soft body: the body that each node is fixed to, -1 if none; empty: none.
  std::vector<int> fixed_to;
  int zones = 1;  ///< number of zones along the axis, each of which keeps its volume
};

/// The constant data of a muscle, which do not change during a bake.
struct Muscle {
  std::string name, location;
  TriMesh rest;
  FileOrder order;           ///< in which a bake stores it
  double rest_volume = 0.0;  ///< m^3
  VolumeZones zones;         ///< empty: one multiplier for the whole volume
  SurfaceLinks zone_links;   ///< for automatic deformation zones; empty if the weights are constant
  CarriedShape shape;
  Springs springs;
  RingSprings rings;                       ///< the same springs, sorted by node
  std::vector<double> mass;                ///< kg
  double highest_frequency_squared = 0.0;  ///< 1/s^2, of the springs at rest
  std::vector<char> driven, free_nodes;
  std::vector<int> bodies;               ///< bodies that move it, each once
  std::vector<double> authored_weights;  ///< by node, as they were given
  /// Weights of the volume multiplier, by node: the authored ones, faded out towards the tendons.
  /// They sum to the number of nodes and are 0 at driven nodes.
  std::vector<double> weights;
  double weight_floor = 0.0;  ///< added to all weights if the authored ones lie on too few nodes
  bool swells = true;         ///< true: shape = "target"; false: shape = "weights"
  MuscleSettings settings;
  Skyline stiffness;  ///< sum of spring stiffness over free nodes, N/m
  /// By node, N/m, 0 at driven nodes: about the stiffness with which a patch of nodes gives way
  /// together.
  std::vector<double> contact_stiffness;
  /// The springs between a free node and a driven one.
  struct Anchored {
    int node, anchor;
    double stiffness;  ///< N/m
  };
  std::vector<Anchored> anchored;

  bool has_path() const { return shape.fixed_to.empty(); }
};

/// Begin and end of the belly, m along the rest path: as given, or a tenth of the path from its
/// ends. Throws Error(kUsage) if it reaches beyond the path.
std::array<double, 2> belly_of(const MuscleDef& def, const Pose& rest_pose);

/// Builds a muscle. Throws Error(kUsage) with location and name of the muscle if the sizes of
/// arrays differ, an index is out of range, a weight is negative or not finite, belly or twist_from
/// lie beyond the path, or the matrix would be too large.
Muscle build_muscle(const MuscleDef& def, const Pose& rest_pose, const Lengths& lengths);

}  // namespace thew::muscles
