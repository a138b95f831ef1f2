// SPDX-License-Identifier: Apache-2.0
#include "tools/bake_warnings.h"

#include <algorithm>
#include <cstdio>

#include "skin/depth.h"

namespace thew {
namespace {

constexpr double kShows = 5e-3;  // m, of a muscle outside its character's skin

// Empty where all lie under the skin, or stand out by less than shows.
std::string flesh_outside(const Model& model, const std::vector<int>& frames,
                          const BakeResult& result, const BakeReader& reader) {
  const auto& measures = result.measures;
  const auto worst =
      std::max_element(measures.begin(), measures.end(), [](const auto& a, const auto& b) {
        return a.skin.max_poke_through < b.skin.max_poke_through;
      });
  if (!model.skinned || worst == measures.end() || worst->skin.max_poke_through <= kShows ||
      measures.size() != frames.size()) {
    return "";
  }
  const auto at = worst - measures.begin();
  const BakeFrame frame = reader.read(static_cast<int>(at));
  const std::vector<BakeMesh>& meshes = reader.info().meshes;
  const Surface& surface = model.skinned->surface;
  Rows skin;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (meshes[m].kind == BakeMesh::Kind::kSkin) skin = to_rows(frame.positions[m]);
  }
  const Bvh bvh = build_bvh(surface, skin);
  double most = -1.0;
  std::string which;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (meshes[m].kind != BakeMesh::Kind::kMuscle) continue;
    const double outside = farthest_outside(surface, bvh, skin, to_rows(frame.positions[m]));
    if (outside > most) most = outside, which = meshes[m].name;
  }
  char line[120];
  std::snprintf(line, sizeof line, " stands out of the character's skin by %.1f mm in frame %d, ",
                1e3 * worst->skin.max_poke_through, frames[at]);
  return "muscle \"" + which + "\"" + line +
         "farther than any elsewhere; thinner muscles, or another place of their paths, keep them "
         "in";
}

}  // namespace

std::string skin_too_full(const Model& model, const std::vector<int>& frames,
                          const std::vector<FrameMeasures>& measures) {
  constexpr double kHeld = 1e-9;
  const auto worst = std::max_element(
      measures.begin(), measures.end(),
      [](const auto& a, const auto& b) { return a.skin.volume_error < b.skin.volume_error; });
  if (!model.has_skin || !model.skin.settings.keeps_volume || worst == measures.end() ||
      worst->skin.volume_error <= kHeld || measures.size() != frames.size()) {
    return "";
  }
  char line[160];
  std::snprintf(line, sizeof line,
                "skin: %.2g of its volume off in frame %d, where what is below leaves no room; "
                "more fat over it at rest gives some",
                worst->skin.volume_error, frames[worst - measures.begin()]);
  return line;
}

std::vector<std::string> bake_warnings(const Model& model, const std::vector<int>& frames,
                                       const BakeResult& result, const BakeReader& reader) {
  std::vector<std::string> warnings = model.warnings;
  if (result.plan) {
    for (const std::string& what : result.plan->raised) {
      warnings.push_back("solver.tolerance: " + what);
    }
  }
  char line[200];
  if (model.settle > 0.0 && result.resumed_frames == 0 && !result.settled.converged) {
    std::snprintf(line, sizeof line,
                  "the settle phase ended after %.2f s with nodes at %.2g m/s; raise scene.settle",
                  result.settled.seconds, result.settled.speed);
    warnings.push_back(line);
  }
  for (const std::string& warning : {flesh_outside(model, frames, result, reader),
                                     skin_too_full(model, frames, result.measures)}) {
    if (!warning.empty()) warnings.push_back(warning);
  }
  int unreached = 0, fallbacks = 0, zones = 0;
  for (const FrameMeasures& frame : result.measures) {
    unreached += frame.unreached;
    fallbacks += frame.weight_fallbacks;
    zones += frame.zone_fallbacks;
  }
  if (unreached > 0) {
    warnings.push_back("the volume could not be reached in " + std::to_string(unreached) +
                       " steps");
  }
  if (fallbacks > 0) {
    warnings.push_back("even weights stood in for the authored ones in " +
                       std::to_string(fallbacks) + " iterations");
  }
  if (zones > 0) {
    warnings.push_back("the volume as a whole, not that of each zone, was held in " +
                       std::to_string(zones) + " iterations");
  }
  return warnings;
}

}  // namespace thew
