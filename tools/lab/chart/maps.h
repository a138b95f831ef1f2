// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace thew::tools {

/// What became of a run. Each frame's volume error is at most kMapVolume, no triangle is inverted
/// (its normal against the mean of its neighbours') and the energy does not grow while the rig
/// rests: kAccurate, if it also ends where the run of the finest step does. kRecovered: only the
/// last frame is so. kDegraded: not even that. kDiverged: the solver gave up, the energy grew
/// tenfold while the rig rested, or the volume is off by more than 1 % at the end.
enum class Verdict { kAccurate, kDegraded, kRecovered, kDiverged, kNotRun };
const char* verdict_name(Verdict verdict);

inline constexpr double kMapVolume = 1e-9;    ///< |V/V0 - 1|
inline constexpr double kMapGrowth = 1.05;    ///< of the energy while the rig rests
inline constexpr double kMapDistance = 0.02;  ///< RMS, of the body's size
inline constexpr double kMapSpeed = 0.05;     ///< sizes a second, fastest node of the last frame

struct MapCell {
  Verdict verdict = Verdict::kNotRun;
  std::string failure;                           ///< what the solver said, or why it was not run
  double volume_error = 0.0, last_volume = 0.0;  ///< largest; of the last frame
  int inverted = 0, last_inverted = 0;           ///< triangles, most; in the last frame
  double growth = 1.0;                           ///< of the energy while the rig rests, largest
  double speed = 0.0;                            ///< sizes a second, last frame
  double distance = 0.0;                         ///< RMS from the finest step's, over the size
};

/// One method and quantity: cells[step][column].
struct StabilityMap {
  std::string method, quantity, unit;
  std::vector<double> columns, steps;  ///< values of the quantity; seconds, from fine to coarse
  std::vector<std::vector<MapCell>> cells;
};

struct MapAsk {
  std::filesystem::path scene;
  int threads = 1;
  std::string only_method = {}, only_quantity = {};  ///< empty: all
  std::function<void(int done, int total)> on_cell = [](int, int) {};
};
/// The scene's first muscle as a body by itself, with its material: squeezed by planes, twisted,
/// struck, overlapped. Error(kUsage) where its mesh has more than 2,000 nodes.
std::vector<StabilityMap> run_maps(const MapAsk& ask);

std::string maps_csv(const std::vector<StabilityMap>& maps);
std::string maps_json(const std::vector<StabilityMap>& maps);
/// One map as SVG, and all as one page.
std::string draw_map(const StabilityMap& map);
std::string maps_html(const std::string& scene, const std::vector<StabilityMap>& maps);

}  // namespace thew::tools
