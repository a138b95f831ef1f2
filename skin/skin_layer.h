// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "muscles/skyline.h"
#include "rig/mesh.h"
#include "rig/skeleton.h"
#include "skin/contact.h"
#include "skin/flesh_field.h"

namespace thew {

struct SkinSettings {
  double thickness = 0.002;  ///< m, least distance of the skin's nodes from muscle and bone
  double smoothing = 0.5;    ///< 0..1, resistance to bending and stretch against the bound shape
  int iterations = 8;        ///< projections in each step
  double fold_gap = 5e-4;    ///< m, kept between skin and skin
  double bridging = 0.012;   ///< m, crevices of the flesh narrower than half of it are bridged
};

/// What never changes: topology, rest shape, binding to the bodies.
struct SkinModel {
  Surface surface;
  Rows rest;                                  ///< in the bind pose, world
  std::vector<std::array<int, 4>> bodies;     ///< -1: unused
  std::vector<std::array<double, 4>> shares;  ///< sum 1
  Pose bind_pose;
  SkinSettings settings;
  std::vector<double> fat;    ///< m, level of the flesh field under each node at rest
  std::vector<double> least;  ///< m, distance that each node keeps from the flesh
  std::vector<std::array<int, 2>> edges;
  std::vector<int> first_neighbour, neighbours;  ///< nodes across the edges of each node
  std::vector<double> edge_weights;              ///< by edge
  std::vector<double> weights;                   ///< by neighbour
  std::vector<double> anchor;  ///< pull towards the bound shape, against 1 per edge
  Skyline matrix;              ///< elasticity, anchors and pull of the flesh
  SkylineFactor factor;
};

/// Weights of the elastic energy: of an edge, and of the flesh's pull on a node.
inline double kFleshPull = getenv("FP") ? atof(getenv("FP")) : 0.05;
inline double edge_stiffness(const SkinSettings& settings) { return 2.0 * settings.smoothing; }

struct SkinState {
  Rows x;
  Rows offset;  ///< m, of x from the bound shape, turned back to the bind pose: all that a step
                ///< reads
  Rows slip, carried;
  Rows force;   ///< of the flesh on each node, over the stiffness of an edge, m, turned back likewise
  Bvh bvh;
  // Scratch, kept so that a step does not allocate.
  Rows bound, elastic, normals;
  Rows solution_scratch;
  Rows turned;  ///< edge from each neighbour at rest, turned
  std::vector<Mat3> turns;
  FleshPlanes planes;
  struct Cover {
    int triangle;
    std::array<double, 3> barycentric;
    Vec3 normal;
    double level;
  };
  std::vector<Cover> covers;
  struct Fold {
    int node;
    Cover wall;
  };
  std::vector<Fold> folds;
  std::vector<int> nearby;
  std::vector<int> hints;
  RowPairs solution;
};

struct SkinMetrics {
  double max_penetration = 0.0;   ///< m, skin nodes inside muscle or bone
  double max_poke_through = 0.0;  ///< m, muscle or bone nodes outside the skin
  int intersecting_pairs = 0;     ///< skin with itself
};

/// `below` are bones and muscles in the bind pose, `bodies_of` the body that carries each collider
/// (muscles: -1). Shares follow the distance to the bodies' bones, smoothed over the surface.
SkinModel bind_skin(const TriMesh& mesh, const Skeleton& skeleton, const Pose& bind_pose,
                    const std::vector<Collider>& below, const std::vector<int>& bodies_of,
                    const SkinSettings& settings);
SkinState initial_skin(const SkinModel& model);

/// Moves the skin to the pose: bound shape, elastic smoothing, contact with what is below, contact
/// with itself. The result depends on the state before alone.
void step_skin(const SkinModel& model, const Pose& pose, const std::vector<Collider>& below,
               SkinState& state);

SkinMetrics measure_skin(const SkinModel& model, const std::vector<Collider>& below,
                         const SkinState& state);

}  // namespace thew
