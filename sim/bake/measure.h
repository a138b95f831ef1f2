// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// What a bake states of each frame, measured on the meshes as they are, not taken from the solver:
/// in double precision, and what is "written" on the positions as the cache holds them.
struct MuscleMeasures {
  double volume_error = 0.0;  ///< |V - V0| / V0
  double volume_error_written = 0.0;
  double substep_volume_error = 0.0;  ///< the same, largest inside the frame
  double zone_error = 0.0;            ///< of the zone that is farthest off, over its own at rest
  double length = 0.0;                ///< m, musculotendon path
  double area_ratio = 1.0;            ///< mean belly section over the rest's
  double attachment_gap = 0.0;        ///< m, poles against origin and insertion on their bones
  double penetration = 0.0;           ///< m, of its free nodes, in another muscle or a bone
  Rung rung = Rung::kNone;            ///< of the frame
  Cause because = Cause::kNone;       ///< of the rung
};
struct FrameMeasures {
  std::vector<MuscleMeasures> muscles;
  SkinMetrics skin;
  double skin_volume_error_written = 0.0;
  double contact_penetration = 0.0;  ///< m, free muscle nodes inside another muscle or bone
  int intersecting_pairs = 0;        ///< triangles of bellies through others, or through bones
  int unreached = 0, weight_fallbacks = 0, zone_fallbacks = 0;
};

/// Area (m^2) of the section across the belly at u in 0..1.
double section_area_at(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u);

/// Mean area (m^2) of sections across the belly at a pose.
double mean_belly_area(const Muscle& muscle, const CarriedPose& pose, const Points& x);

FrameMeasures measure(const Model& model, const std::vector<double>& rest_areas, Parallel& parallel,
                      State& state);
/// |V - V0| / V0 of a mesh at a frame's positions, in double precision or as float32 has them.
double written_volume_error(const BakeMesh& mesh, const std::vector<Vec3>& positions,
                            bool double_precision);
/// The same of a bake's muscles and skin layer, whose meshes are those of bake_info().
void measure_written(const Model& model, const BakeInfo& info,
                     const std::vector<std::vector<Vec3>>& positions, FrameMeasures& measures);

/// Muscles whose free nodes lie over 1 mm inside another muscle or a bone at rest, a line for each
/// pair with the worst place: the scene is to know that settling will push them apart.
std::vector<std::string> rest_overlaps(const Model& model);
/// Of all muscles at rest in the bind pose.
std::vector<double> rest_belly_areas(const Model& model, const State& initial);

/// The same as numbers with names, for the cache: "volume_error/biceps_long", ...
std::vector<std::string> measure_names(const Model& model);
std::vector<double> flatten(const FrameMeasures& measures);
/// Error(kInput) where one of them is not among the names: of a bake by another version.
FrameMeasures unflatten(const Model& model, const std::vector<std::string>& names,
                        const std::vector<double>& numbers);

}  // namespace thew::sim
