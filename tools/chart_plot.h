// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tools/chart_run.h"

namespace thew {

/// CPU ms a frame against one of a point's errors, both logarithmic; carries its own style.
std::string draw_cost(const Chart& chart, double ChartPoint::*error, const std::string& what);

std::string chart_csv(const Chart& chart);
std::string chart_json(const Chart& chart);
/// One file, no network.
std::string chart_html(const Chart& chart);

}  // namespace thew
