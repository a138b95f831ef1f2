// SPDX-License-Identifier: Apache-2.0
//
// What thew_bench measures, each as one JSON object. Times are CPU milliseconds of one thread,
// medians of interleaved runs; the figures that carry over between machines are the ratios.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace thew::tools {

/// How fast the muscles are, over the same without volume and without contact, with friction and
/// with self-contact; the sag of the first; their distance from the refined step.
nlohmann::ordered_json speed_of(const std::string& scene, int repetitions);
/// The skin layer: what a frame costs more than one without, as it comes and with its volume kept.
/// Error(kInput) where the scene has none.
nlohmann::ordered_json skin_price(const std::string& scene, int repetitions);
/// What the maps, the activation and the props of a scene cost: its time over that of the same
/// scene without them. Error(kInput) where it has none of these.
nlohmann::ordered_json price_of_features(const std::string& scene, int repetitions);
/// What solver.tolerance chooses for an error of `millimetres`, what it costs, and the cheapest
/// step that is the same for all muscles and as right.
nlohmann::ordered_json tolerance_of(const std::string& scene, double millimetres,
                                    std::vector<std::string> overrides, int repetitions);
/// Contact of 1 to 56 of the scene in one; drawn to `picture`, an SVG.
nlohmann::ordered_json contact_of_copies(const std::string& scene,
                                         const std::filesystem::path& picture);

/// Whole bakes of the scene on one thread, by stage: a table of wall and CPU seconds, medians of
/// `runs`. With `pictures` it draws them, and a row says what one of them costs, ms. `against` is
/// the folder of another build, whose bakes take turns with these, or empty. The CPU time of a
/// build that does not report it by stage is known as a whole only.
std::string whole_bakes(const std::string& scene, const std::filesystem::path& against, int runs,
                        bool pictures);

}  // namespace thew::tools
