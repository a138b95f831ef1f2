// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/base/text.h"

namespace thew::tools {

/// Pieces of SVG: a coordinate; a text; a line. `more`: attributes.
std::string svg_px(double value);
std::string svg_text(double x, double y, const std::string& text, const std::string& more = "");
std::string svg_line(double x0, double y0, double x1, double y1, const std::string& more);

/// The i-th of twelve colours that can be told apart on white; later ones repeat.
const char* chart_colour(std::size_t i);

struct ChartLine {
  std::string name;
  std::vector<double> values;  ///< by x
};

/// Lines against frames, each labelled at its end. On a logarithmic axis what is zero lies on the
/// floor. The drawing says by data-frames and data-plot where its first and last frame are.
struct LineChart {
  std::string title;
  std::string unit;  ///< of the values, "" for a ratio
  std::vector<int> x;
  std::vector<ChartLine> lines;
  bool logarithmic = false;
  std::optional<double> limit;  ///< drawn across, "bound"
};
std::string draw_chart(const LineChart& chart);

struct BarChart {
  std::string title, unit;
  std::vector<std::pair<std::string, double>> bars;
};
std::string draw_chart(const BarChart& chart);

}  // namespace thew::tools
