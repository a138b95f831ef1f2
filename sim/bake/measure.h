// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/bake/sections.h"
#include "sim/cache/cache.h"
#include "sim/solver/parallel.h"
#include "sim/solver/state.h"
#include "skin/sides.h"

namespace thew::sim {

/// Figures of one muscle in one frame. They are measured on the meshes and not taken from the
/// solver, in double precision; those called "written" on the positions as the cache holds them.
struct MuscleMeasures {
  double volume_error = 0.0;  ///< |V - V0| / V0
  double volume_error_written = 0.0;
  double substep_volume_error = 0.0;  ///< |V - V0| / V0, the largest inside the frame
  double zone_error = 0.0;            ///< the largest of a zone, relative to its rest volume
  double activation = 0.0;            ///< 0..1, at the frame; of a muscle that has forces
  double length = 0.0;                ///< m, musculotendon path
  double area_ratio = 1.0;            ///< mean area of the belly's sections over that at rest
  double attachment_gap = 0.0;        ///< m, between the muscle's ends and origin or insertion
  double penetration = 0.0;    ///< m, the deepest of its free nodes in another muscle or bone
  double swing = 0.0;          ///< m, by which a node still moves from iteration to iteration, in a
                               ///< frame that is solved by itself; 0: the muscle has come to rest
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

/// What measure() needs of the model at rest, and memory that it uses again.
struct Measuring {
  /// The node that is nearest to an end of the path at rest is taken for the attached one.
  struct Attachment {
    int node = -1;
    double away = 0.0;  ///< m, from the end at rest
  };
  /// Two bodies, by their place in `shells`, and what is found of them in a frame. A body may meet
  /// itself.
  struct Meeting {
    int one = 0, other = 0;
    std::vector<std::array<int, 2>> near;             ///< pairs of triangles that may cross
    int crossings = 0;                                ///< pairs that do, one of a belly
    double depth_of_one = 0.0, depth_of_other = 0.0;  ///< m, inside each other
    double depth_of_covered = 0.0;                    ///< m, of the skin that is covered
    double outside = 0.0;  ///< m, of the other outside the one, which is the skin
  };
  std::vector<double> rest_areas;  ///< m^2, mean_belly_area() of each muscle in the bind pose
  std::vector<std::array<Attachment, 2>> attachments;  ///< of each muscle: origin, insertion
  std::vector<Shell> shells;                           ///< muscles, bones, the skin
  std::vector<Meeting> meetings;
  /// By vertex of a character's skin in the frame: what is seen and not covered, and what is
  /// covered (find_covered()); empty: nothing.
  std::vector<char> bare, covered;
};
/// `initial` is an initial state.
Measuring start_measuring(const Model& model, const State& initial);

/// All but the measures of written positions. Refits the trees of the state.
FrameMeasures measure(const Model& model, Measuring& measuring, Parallel& parallel, State& state);
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

/// Names of all measures for the cache, such as "volume_error/biceps_long", and their values in the
/// same order.
std::vector<std::string> measure_names(const Model& model);
std::vector<double> flatten(const FrameMeasures& measures);
/// The measures again. Error(kInput) where a name is missing, as in a bake of another version.
FrameMeasures unflatten(const Model& model, const std::vector<std::string>& names,
                        const std::vector<double>& numbers);

}  // namespace thew::sim
