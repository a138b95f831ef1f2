// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/cache/cache.h"
#include "sim/solver/parallel.h"
#include "sim/solver/state.h"

namespace thew::sim {

/// Figures of one muscle in one frame. They are measured on the meshes and not taken from the
/// solver, in double precision; those called "written" on the positions as the cache holds them.
struct MuscleMeasures {
  double volume_error = 0.0;  ///< |V - V0| / V0
  double volume_error_written = 0.0;
  double substep_volume_error = 0.0;  ///< |V - V0| / V0, the largest inside the frame
  double zone_error = 0.0;            ///< the largest of a zone, relative to its rest volume
  double length = 0.0;                ///< m, musculotendon path
  double area_ratio = 1.0;            ///< mean area of the belly's sections over that at rest
  double attachment_gap = 0.0;        ///< m, between the muscle's ends and origin or insertion
  double penetration = 0.0;    ///< m, the deepest of its free nodes in another muscle or bone
  Rung rung = Rung::kNone;     ///< that the muscle was on in the frame
  Cause cause = Cause::kNone;  ///< of the rung
};
struct FrameMeasures {
  std::vector<MuscleMeasures> muscles;
  SkinMetrics skin;
  double skin_volume_error_written = 0.0;
  double contact_penetration = 0.0;  ///< m, the deepest free node of all muscles
  int intersecting_pairs = 0;        ///< pairs of triangles that intersect, one of a belly
  int unreached = 0, weight_fallbacks = 0, zone_fallbacks = 0;
};

/// Area (m^2) of the section across the belly at u in 0..1.
double section_area_at(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u);

/// Mean area (m^2) of sections across the belly at a pose.
double mean_belly_area(const Muscle& muscle, const CarriedPose& pose, const Points& x);

/// All but the measures of written positions; `rest_areas` as of rest_belly_areas(). Refits the
/// trees of the state.
FrameMeasures measure(const Model& model, const std::vector<double>& rest_areas, Parallel& parallel,
                      State& state);
/// |V - V0| / V0 of a mesh at a frame's positions, in double precision or as float32 has them.
double written_volume_error(const BakeMesh& mesh, const std::vector<Vec3>& positions,
                            bool double_precision);
/// Sets the volume errors of the written positions of muscles and skin layer. `info` is of
/// bake_info(), and so is the order of `positions`.
void measure_written(const Model& model, const BakeInfo& info,
                     const std::vector<std::vector<Vec3>>& positions, FrameMeasures& measures);

/// One line for each pair of a muscle and another muscle or bone that overlap at rest by more than
/// Lengths::reported_overlap, with the deepest position. Settling will push such a pair apart,
/// which changes both shapes.
std::vector<std::string> rest_overlaps(const Model& model);
/// mean_belly_area() (m^2) of each muscle in the bind pose, from an initial state.
std::vector<double> rest_belly_areas(const Model& model, const State& initial);

/// Names of all measures for the cache, such as "volume_error/biceps_long", and their values in the
/// same order.
std::vector<std::string> measure_names(const Model& model);
std::vector<double> flatten(const FrameMeasures& measures);
/// The measures again. Error(kInput) where a name is missing, as in a bake of another version.
FrameMeasures unflatten(const Model& model, const std::vector<std::string>& names,
                        const std::vector<double>& numbers);

}  // namespace thew::sim
