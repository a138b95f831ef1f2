// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "rig/math.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/solver/drive.h"
#include "tools/base/temporary_folder.h"
#include "tools/inspect/crossings.h"
#include "tools/lab/results/anatomy.h"
#include "tools/lab/results/results.h"

namespace thew::tools {
namespace {

/// A bake, and what is measured on its frames besides its own measures.
struct Flexion {
  BakeResult result;
  std::vector<double> elbow;    ///< degrees, by frame
  double written_double = 0.0;  ///< volume error of the muscles, in double precision
  std::array<int, kLayerPairs.size()> crossings{};  ///< most of any frame
};

Flexion flex(const Model& model, int last, int threads) {
  const TemporaryFolder folder("results");
  BakeOptions options;
  options.folder = folder.path();
  options.frames.resize(last - model.first_frame + 1);
  std::iota(options.frames.begin(), options.frames.end(), model.first_frame);
  options.threads = threads;
  const BakeInfo info = bake_info(model, options.frames);
  const int elbow = find_joint(model.skeleton, "elbow");
  Flexion flexion;
  flexion.result = bake(model, options, [&](const BakeFrame& frame) {
    std::vector<double> joints;
    joints_at(model, (frame.frame - model.first_frame) / model.fps, joints);
    flexion.elbow.push_back(elbow < 0 ? 0.0 : joints[elbow] / kDegree);
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      flexion.written_double = std::max(
          flexion.written_double, written_volume_error(info.meshes[m], frame.positions[m], true));
    }
    const auto found = find_crossings(info.meshes, frame.positions);
    for (size_t k = 0; k < found.size(); ++k) {
      flexion.crossings[k] = std::max(flexion.crossings[k], found[k].pairs);
    }
    return true;
  });
  return flexion;
}

template <typename Of>
double most(const Flexion& flexion, Of of) {
  double found = 0.0;
  for (const FrameMeasures& frame : flexion.result.measures) found = std::max(found, of(frame));
  return found;
}
double most_of_muscles(const Flexion& flexion, double MuscleMeasures::*of) {
  return most(flexion, [of](const FrameMeasures& frame) {
    double found = 0.0;
    for (const MuscleMeasures& muscle : frame.muscles) found = std::max(found, muscle.*of);
    return found;
  });
}

// mm on the way up, linear between frames; NaN where the elbow does not come so far.
double length_at(const Flexion& flexion, int muscle, double degrees) {
  const auto length = [&](size_t f) {
    return 1e3 * flexion.result.measures[f].muscles[muscle].length;
  };
  for (size_t f = 1; f < flexion.elbow.size(); ++f) {
    const double a = flexion.elbow[f - 1], b = flexion.elbow[f];
    if (b < a || degrees > b + 1e-9) continue;
    const double t = b > a ? (degrees - a) / (b - a) : 0.0;
    return (1.0 - t) * length(f - 1) + t * length(f);
  }
  return std::nan("");
}

// mm, the largest of a table's differences; -1 where the scene has none of its muscles.
template <typename Rows>
double farthest(const Model& model, const Flexion& flexion, const Rows& rows, bool shortening) {
  double off = -1.0;
  for (const auto& row : rows) {
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      if (model.muscles[m].name != row.muscle) continue;
      const int index = static_cast<int>(m);
      const double rest = length_at(flexion, index, 0.0);
      for (size_t k = 0; k < row.millimetres.size(); ++k) {
        const double length = length_at(flexion, index, row.angles[k]);
        const double found = shortening ? rest - length : length;
        if (!std::isnan(found)) off = std::max(off, std::abs(found - row.millimetres[k]));
      }
    }
  }
  return off;
}

}  // namespace

Table flexion_table(const std::filesystem::path& scene, int last, int threads) {
  const Model model = build_model(read_scene(scene));
  if (last == 0) last = model.last_frame;
  const Flexion flexion = flex(model, last, threads);
  const std::string bake = "`thew bake SCENE --out DIR`: `report.json`",
                    inspect = "`thew inspect DIR/bake.h5`", arm = "`tests/property/sim_arm.cpp`";
  Table table{"",
              model.name + ": " + std::to_string(model.muscles.size()) + " muscles, frames " +
                  std::to_string(model.first_frame) + " to " + std::to_string(last),
              "The largest of all muscles and frames. Volume errors are |V/V0 - 1|. Pairs of "
              "triangles: bone against bone is left out, and the ends of tendons in bone.",
              figure_head(),
              {}};
  const auto add = [&](const std::string& what, const std::string& figure, const std::string& by,
                       const std::string& test) {
    table.rows.push_back({what, figure, by, test});
  };
  add("volume error as solved, at frames",
      number(most_of_muscles(flexion, &MuscleMeasures::volume_error), 2), bake, arm);
  add("volume error as solved, inside frames",
      number(most_of_muscles(flexion, &MuscleMeasures::substep_volume_error), 2), bake, arm);
  add("volume error of what is written, float32",
      number(most_of_muscles(flexion, &MuscleMeasures::volume_error_written), 2), bake, arm);
  add("volume error of what is written, `output.precision = \"double\"`",
      number(flexion.written_double, 2), bake + " with `--set output.precision=double`", arm);
  const double lengths = farthest(model, flexion, kArm26Lengths, false);
  const double shortening = farthest(model, flexion, kShortenings, true);
  if (lengths >= 0.0) {
    add("musculotendon lengths from arm26 (biceps, brachialis, triceps)",
        number(lengths, 2) + " mm", bake, arm);
  }
  if (shortening >= 0.0) {
    add("shortening of six others from published regressions", number(shortening, 2) + " mm", bake,
        arm);
  }
  add("poles of muscles off their bones",
      number(1e3 * most_of_muscles(flexion, &MuscleMeasures::attachment_gap), 2) + " mm", bake,
      arm);
  add("muscle nodes inside another muscle or a bone",
      number(1e3 * most_of_muscles(flexion, &MuscleMeasures::penetration), 2) + " mm", bake, arm);
  if (model.has_skin) {
    const auto skin = [&](double SkinMetrics::*of) {
      return most(flexion, [of](const FrameMeasures& frame) { return frame.skin.*of; });
    };
    add("skin inside muscle or bone", number(1e3 * skin(&SkinMetrics::max_penetration), 2) + " mm",
        bake, arm);
    add("muscle or bone outside the skin",
        number(1e3 * skin(&SkinMetrics::max_poke_through), 2) + " mm", bake, arm);
    add("volume error of what the skin encloses", number(skin(&SkinMetrics::volume_error), 2), bake,
        arm);
  }
  for (size_t k = 0; k < kLayerPairs.size(); ++k) {
    add("pairs of triangles that cross, " + std::string(kLayerPairs[k]),
        std::to_string(flexion.crossings[k]), inspect,
        "`tests/unit/tools/inspect/inspect_crossings.cpp`, " + arm);
  }
  return table;
}

}  // namespace thew::tools
