// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "tools/lab/base/table.h"
#include "tools/lab/chart/run.h"

namespace thew::tools {

/// CPU ms a frame against one of a point's errors, both logarithmic; carries its own style.
std::string draw_cost(const Chart& chart, double ChartPoint::*error, const std::string& what);

/// The same as a picture of 1,720 pixels' width, by rsvg-convert; written beside and renamed. Says
/// what went wrong, "" for nothing: that rsvg-convert is not installed is nothing either, and then
/// there is no picture.
std::string write_picture(const std::filesystem::path& png, const std::filesystem::path& svg);

/// All that was run, setting by setting; the refinements.
Table points_of(const Chart& chart);
Table refinements_of(const Chart& chart);

std::string chart_csv(const Chart& chart);
std::string chart_json(const Chart& chart);
/// One file, no network. `more`: what stands at its end.
std::string chart_html(const Chart& chart, const std::string& more = "");

}  // namespace thew::tools
