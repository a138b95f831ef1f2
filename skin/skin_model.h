// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <vector>

#include "muscles/lengths.h"
#include "muscles/skyline.h"
#include "rig/character.h"
#include "rig/math.h"
#include "rig/mesh.h"
#include "rig/skeleton.h"
#include "skin/contact/contact.h"
#include "skin/flesh_field.h"

namespace thew::skin {

struct SkinSettings {
  double thickness = 0.002;   ///< m, least distance of the skin's nodes from muscle and bone
  double smoothing = 0.5;     ///< 0..1, resistance to bending and stretch against the bound shape
  int iterations = 8;         ///< projections in each step
  double fold_gap = 5e-4;     ///< m, kept between skin and skin
  double bridging = 0.012;    ///< m, crevices of the flesh narrower than half of it are bridged
  double reach = 0.03;        ///< m, a skinned skin feels the muscles within it
  bool keeps_volume = false;  ///< what the skin encloses stays what it is at rest
  /// rad, of a joint in one step of the skin: the walls of a fold part only so fast.
  double most_turn = 4.0 * kDegree;
  Lengths lengths = {};
};
SkinSettings times(const SkinSettings& settings, double size);

/// What never changes: topology, rest shape, binding to the bodies.
struct SkinModel {
  Surface surface;
  Points rest;                                ///< in the bind pose, world
  std::vector<std::array<int, 4>> bodies;     ///< -1: unused
  std::vector<std::array<double, 4>> shares;  ///< sum 1
  Pose bind_pose;
  double volume = 0.0;  ///< m^3, enclosed at rest
  SkinSettings settings;
  std::vector<double> fat;    ///< m, level of the flesh field under each node at rest
  std::vector<double> least;  ///< m, distance that each node keeps from the flesh
  // The elastic energy, sum_ij w_ij |x_i - x_j - e_ij|^2 + sum_i a_i |x_i - b_i|^2.
  std::vector<int> first_neighbour, neighbours;  ///< neighbours of i: first[i] to first[i + 1]
  std::vector<double> weights;                   ///< w by neighbour
  std::vector<double> anchor;                    ///< a
  Skyline matrix;
  SkylineFactor factor;
};

/// A point of a skin triangle and a plane: normal . point >= level.
struct SkinPlane {
  int triangle;
  std::array<double, 3> barycentric;
  Vec3 normal;
  double level;
};

/// A rigid motion, turn + eps shift, with shift = 1/2 (0, t) turn.
struct DualQuaternion {
  Eigen::Vector4d turn = Eigen::Vector4d::Zero(), shift = Eigen::Vector4d::Zero();
};

/// A node and the other wall of a fold: plane.normal . (x_node - point) >= plane.level.
struct SkinFold {
  int node;
  SkinPlane wall;
};

/// Scratch of a skinned skin's step (skinned_skin.h), kept so that a step does not allocate.
struct SkinnedWork {
  /// The plane over the place of the muscle below a point that the point stays beyond.
  struct PlaneConstraint {
    Vec3 normal = Vec3::Zero();  ///< unit, from the muscle to the skin as the weights turn it
    double above = 0.0;          ///< m, of the muscle's place at rest
    double level = 0.0;          ///< m, of the muscle's place now
    double carried = 0.0;        ///< m, of the point as the weights have it
    double least = 0.0;          ///< m, of the point
    double hold = 0.0;           ///< 0..1, less where the muscle lies far or has slid away
  };
  /// Where a muscle's sample is now, by cells of a grid as wide as a point looks for them.
  struct Spot {
    std::array<int, 3> cell;
    Vec3 place, normal;
  };
  std::vector<Affine> of_links;
  Points carried;                      ///< by the weights alone
  Points by;                           ///< m, of x from there
  Points before;                       ///< the same, before a pass
  std::vector<double> asked;           ///< by vertex, the weights of its points
  std::vector<PlaneConstraint> walls;  ///< by point
  std::vector<Spot> spots;
  std::vector<double> folds;             ///< rad, by edge, as the weights have them
  std::vector<double> sharp, own_sharp;  ///< 0..1 by vertex, of the edges around; of its own
};

/// What a step reads of the step before, and a failed one takes back.
struct SkinMotion {
  Points x;
  // Turned back to the bind pose:
  Points offset;              ///< m, of x from the elastic shape
  Points force;               ///< of the flesh on each node, in m of stretch of an edge of weight 1
  Points slip;                ///< m, of x from the bound shape
  std::vector<double> moved;  ///< m, how far the passes led from the prediction
};

struct SkinState : SkinMotion {
  Bvh bvh;
  // Scratch, kept so that a step does not allocate.
  Points bound;        ///< carried by the bodies alone
  Points elastic;      ///< least elastic energy, without the flesh
  Points turned;       ///< e by neighbour
  Points own_normals;  ///< of the skin
  Points normals;      ///< the same, averaged with those around
  Points predicted;    ///< x before the passes
  Points looked;       ///< x when the flesh below was last looked up
  std::vector<Mat3> turns;
  FleshPlanes planes;
  std::vector<SkinPlane> covers;
  std::vector<SkinFold> folds;
  Points parted;             ///< m, by which the walls of folds were last moved apart
  std::vector<double> room;  ///< m, how far a node may go inwards, up to what is plenty
  Points swelling;           ///< m^2, the way of a unit of the volume's multiplier
  std::vector<int> hints, nearby;
  std::vector<DualQuaternion> motions;        ///< by body, since the bind pose
  std::vector<std::array<int, 2>> crossings;  ///< triangles
  std::vector<char> marked, held;             ///< nodes
  Points unswollen;                           ///< x before its volume is restored
  PointPairs solution;
  SkinnedWork skinned;
};

struct SkinMetrics {
  double max_penetration = 0.0;   ///< m, skin nodes inside muscle or bone
  double max_poke_through = 0.0;  ///< m, muscle or (of our own skin) bone nodes outside the skin
  int intersecting_pairs = 0;     ///< skin with itself
  double volume_error = 0.0;      ///< |V - V0| / V0 of what it encloses
};

}  // namespace thew::skin
