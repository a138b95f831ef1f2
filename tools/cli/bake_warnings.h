// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "sim/bake/bake.h"
#include "tools/report/report.h"

namespace thew::tools {

/// A line for each joint between two bones of a character that its motion moves from where it is at
/// rest, by 5 mm or 2 % of the bone above: with the bone, the farthest frame and millimetres.
std::vector<std::string> joints_out_of_place(const Model& model, const std::vector<int>& frames);

/// The model's, and after them what the bake found; `reader` is of its complete cache.
std::vector<std::string> bake_warnings(const Model& model, const std::vector<int>& frames,
                                       const BakeResult& result, const BakeReader& reader);

/// That muscles still moved, so that it shows, as the settle phase ended; else empty.
std::string not_at_rest(const Model& model, const BakeResult& result);

/// By muscle, the frames in which it found no rest.
std::vector<Report::Swing> swings_of(const Model& model, const std::vector<int>& frames,
                                     const std::vector<FrameMeasures>& measures);

/// A line for each of these muscles: frames, millimetres, and the frame of the most.
std::vector<std::string> swinging_muscles(const std::vector<Report::Swing>& swings);
/// A line for each muscle that is on a rung in a frame and not in the next one, where frames are
/// solved by themselves and nothing blends them.
std::vector<std::string> rungs_that_pop(const Model& model, const std::vector<int>& frames,
                                        const std::vector<FrameMeasures>& measures);

/// That a skin that is to keep its volume could not, how far it is off and where; else empty.
std::string skin_too_full(const Model& model, const std::vector<int>& frames,
                          const std::vector<FrameMeasures>& measures);

}  // namespace thew::tools
