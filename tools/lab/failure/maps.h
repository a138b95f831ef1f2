// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "tools/lab/base/table.h"
#include "tools/lab/failure/cell.h"

namespace thew::tools {

/// One method and quantity: cells[step][column].
struct StabilityMap {
  std::string method, what, quantity, unit;  ///< what: the method in a few words
  bool is_thew = true;
  std::vector<double> columns, steps;  ///< values of the quantity; seconds, from fine to coarse
  std::vector<std::vector<MapCell>> cells;
  int checked = 0, differed = 0;  ///< cells left out that were run after all; not as told
  /// By region: what a bake of Thew, rungs and all, makes of the region's coarsest step.
  std::vector<std::pair<Mechanism, std::string>> with_rungs;
};

struct MapAsk {
  std::filesystem::path scene;
  int threads = 1;
  std::string only_method = {}, only_quantity = {};  ///< empty: all
  bool every_cell = false;                           ///< leaves none out
  std::function<void(int done, int total)> on_map = [](int, int) {};
};
/// The scene's first muscle as a body by itself, with its material: squeezed by planes, twisted,
/// struck, overlapped; by the methods of Thew and those of others.
std::vector<StabilityMap> run_maps(const MapAsk& ask);

std::string maps_csv(const std::vector<StabilityMap>& maps);
std::string maps_json(const std::vector<StabilityMap>& maps);
/// Failing regions: a row for each map and mechanism, with what Thew does there.
Table regions_of(const std::vector<StabilityMap>& maps);
/// How many cells of each method came to which verdict, and how many of them were run.
Table verdicts_of(const std::vector<StabilityMap>& maps);
/// One map as SVG, and all as one page.
std::string draw_map(const StabilityMap& map);
std::string maps_html(const std::string& scene, const std::vector<StabilityMap>& maps,
                      double cpu_minutes);

}  // namespace thew::tools
