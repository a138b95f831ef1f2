// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/scale_plot.h"

#include <algorithm>
#include <cmath>

#include "tools/base/svg_chart.h"

namespace thew::tools {

std::string draw_scale(const std::string& title, const std::vector<ScalePoint>& points) {
  constexpr double kLeft = 70, kRight = 560, kTop = 44, kBottom = 320;  // px
  double most = 1.0, least = 1e9;
  for (const ScalePoint& point : points) {
    most = std::max({most, point.milliseconds, point.expected});
    least = std::min({least, point.milliseconds, point.expected});
  }
  const double low = std::floor(std::log10(least)), high = std::ceil(std::log10(most));
  const double last = std::max(1.0, std::log2(points.back().copies));
  const auto x = [&](int copies) { return kLeft + (kRight - kLeft) * std::log2(copies) / last; };
  const auto y = [&](double ms) {
    return kBottom - (kBottom - kTop) * (std::log10(ms) - low) / (high - low);
  };
  std::string svg =
      "<svg class=\"scale\" viewBox=\"0 0 640 370\" role=\"img\" "
      "xmlns=\"http://www.w3.org/2000/svg\">\n<style>.scale "
      "text{font:12px system-ui,sans-serif;fill:#1d2329}.scale .head{font-size:15px;font-weight:"
      "600}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" +
      svg_text(kLeft, 24, title, " class=\"head\"");
  for (double decade = low; decade <= high; ++decade) {
    const double ms = std::pow(10.0, decade);
    svg += svg_line(kLeft, y(ms), kRight, y(ms), "stroke=\"#e3e6e9\"");
    svg += svg_text(kLeft - 8, y(ms) + 4, readable(ms), " text-anchor=\"end\"");
  }
  std::string expected, marks;
  for (const ScalePoint& point : points) {
    const double px = x(point.copies);
    svg += svg_line(px, kTop, px, kBottom, "stroke=\"#e3e6e9\"");
    svg += svg_text(px, kBottom + 17, std::to_string(point.copies), " text-anchor=\"middle\"");
    expected += svg_px(px) + "," + svg_px(y(point.expected)) + " ";
    marks += "<circle cx=\"" + svg_px(px) + "\" cy=\"" + svg_px(y(point.milliseconds)) +
             "\" r=\"4.5\" fill=\"" + chart_colour(0) + "\"/>\n";
  }
  svg += "<polyline points=\"" + expected +
         "\" fill=\"none\" stroke=\"#1d2329\" stroke-dasharray=\"4 3\"/>\n" + marks;
  svg += svg_text((kLeft + kRight) / 2, kBottom + 38, "copies in one scene",
                  " text-anchor=\"middle\"");
  svg += svg_text(kLeft + 12, kTop + 18, "contact, ms a frame; dashed: n log n from one copy");
  return svg + "</svg>\n";
}

}  // namespace thew::tools
