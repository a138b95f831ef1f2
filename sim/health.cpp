// SPDX-License-Identifier: Apache-2.0
#include "sim/health.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace thew {
namespace {

constexpr double kBox = 10.0;      // times the rig's own extent
constexpr double kStretch = 10.0;  // of a spring over its present rest length

std::string trouble_at(const Model& model, int m, int node, double time, const char* what,
                       double value, double limit, const char* unit) {
  char numbers[200];
  std::snprintf(numbers, sizeof numbers, "node %d at %.4f s: %s is %.6g %s, the limit is %.6g %s",
                node, time, what, value, unit, limit, unit);
  return "muscle \"" + model.muscles[m].name + "\", " + numbers +
         "; use more substeps or softer material";
}

double norm(const Row& r) { return std::sqrt(r[0] * r[0] + r[1] * r[1] + r[2] * r[2]); }

}  // namespace

void begin_frame(State& state) {
  for (MuscleState& muscle : state.muscles) {
    muscle.volume_error = muscle.substep_volume_error = 0.0;
    muscle.unreached = muscle.weight_fallbacks = 0;
    muscle.frame_before = muscle;
  }
}

void take_back(State& state) {
  for (MuscleState& muscle : state.muscles) {
    static_cast<MuscleMotion&>(muscle) = muscle.frame_before;
    muscle.searched.clear();  // the next search knows of no motion
  }
}

std::string find_trouble(const Model& model, double h, const State& state) {
  double extent = 0.1;
  for (const Transform& body : state.pose) extent = std::max(extent, body.translation().norm());
  const double reach = kBox * extent;
  const bool still = model.scene.solver.integrator == "quasi_static";
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    const Springs& springs = model.muscles[m].springs;
    for (size_t i = 0; i < now.x.size(); ++i) {
      const double distance = norm(now.x[i]);
      if (!(distance <= reach)) {  // also where it is not a number
        return trouble_at(model, m, static_cast<int>(i), state.time, "distance from the root",
                          distance, reach, "m");
      }
      for (const double speed : {norm(now.x[i] - now.start[i]) / h, norm(now.v[i])}) {
        // From rest to rest there is no speed, only a number or none.
        if (!(speed <= (still ? 1e300 : extent / h))) {
          return trouble_at(model, m, static_cast<int>(i), state.time, "speed", speed, extent / h,
                            "m/s");
        }
      }
    }
    for (int k = 0; k < springs.structural; ++k) {
      const double length = norm(now.x[springs.nodes[k][0]] - now.x[springs.nodes[k][1]]);
      const double limit = kStretch * std::max(now.rest_length[k], springs.rest_length[k]);
      if (!(length <= limit)) {
        return trouble_at(model, m, springs.nodes[k][0], state.time, "length of an edge", length,
                          limit, "m");
      }
    }
  }
  return "";
}

double fastest_node(const Model& model, const State& state) {
  double fastest = 0.0;
  for (int m = 0; m < state.count(); ++m) {
    const MuscleState& now = state.muscles[m];
    for (size_t i = 0; i < now.v.size(); ++i) {
      if (!model.muscles[m].driven[i]) fastest = std::max(fastest, norm(now.v[i]));
    }
  }
  return fastest;
}

}  // namespace thew
