// SPDX-License-Identifier: Apache-2.0
#include "tools/base/svg_chart.h"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>

namespace thew::tools {
namespace {

constexpr double kWidth = 640, kHeight = 330;  // px, of a chart whose labels need no more
constexpr double kLeft = 56, kRight = 150, kTop = 34, kBottom = 40;
constexpr double kLabelHeight = 14, kLetter = 6.6;  // px, about
constexpr int kLinesInColour = 12;
constexpr double kLowestDecade = -17;  // below it a double relative to 1 has no digits

double height_of(const LineChart& chart) {
  const double labels = kLabelHeight * static_cast<double>(chart.lines.size());
  return std::max(kHeight, kTop + labels + kBottom);
}

// What the longest label needs beside the lines.
double right_of(const LineChart& chart) {
  std::size_t letters = 0;
  for (const ChartLine& line : chart.lines) letters = std::max(letters, line.name.size());
  return std::max(kRight, 20.0 + kLetter * static_cast<double>(letters));
}

// `more`: attributes.
std::string begin(const std::string& title, const std::string& unit, double height,
                  const std::string& more = "") {
  return "<svg viewBox=\"0 0 " + svg_px(kWidth) + " " + svg_px(height) + "\"" + more +
         " role=\"img\" xmlns=\"http://www.w3.org/2000/svg\" aria-label=\"" + escape_html(title) +
         "\">\n<text x=\"0\" y=\"14\" class=\"title\">" + escape_html(title) +
         (unit.empty() ? "" : "<tspan dx=\"8\" class=\"unit\">" + escape_html(unit) + "</tspan>") +
         "</text>\n";
}

/// Where values and frames lie on the paper, and what is written at the axis.
struct Scale {
  double low = 0.0, high = 1.0;  // decades where logarithmic
  bool logarithmic = false;
  std::vector<double> ticks;
  double height = kHeight;  // px

  double y(double value) const {
    double at = value;
    if (logarithmic) at = value > 0.0 ? std::max(std::log10(value), low) : low;
    return kTop + (height - kTop - kBottom) * (high - at) / (high - low);
  }
};

// Steps of 1, 2 or 5 times a power of ten, five to ten of them.
double round_step(double range) {
  const double step = std::pow(10.0, std::floor(std::log10(range / 5.0)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (range / (factor * step) <= 6.0) return factor * step;
  }
  return 10.0 * step;
}

Scale linear_scale(double low, double high) {
  if (low == 0.0 && high == 0.0) high = 1.0;
  if (high - low < 1e-9 * std::max(std::abs(high), 1e-3)) {  // a flat line, in the middle
    const double half = std::max(0.05 * std::abs(high), 1e-3);
    low -= half, high += half;
  }
  const double step = round_step(high - low);
  Scale scale;
  scale.low = step * std::floor(low / step);
  scale.high = step * std::ceil(high / step);
  const int steps = static_cast<int>(std::lround((scale.high - scale.low) / step));
  for (int i = 0; i <= steps; ++i) scale.ticks.push_back(scale.low + i * step);
  return scale;
}

Scale logarithmic_scale(double smallest, double largest) {
  Scale scale;
  scale.logarithmic = true;
  scale.low = std::max(std::floor(std::log10(smallest)) - 1.0, kLowestDecade);
  scale.high = std::max(std::ceil(std::log10(largest)), scale.low + 1.0);
  const double step = std::ceil((scale.high - scale.low) / 7.0);
  for (double t = scale.low; t <= scale.high; t += step) {
    scale.ticks.push_back(std::pow(10.0, t));
  }
  return scale;
}

Scale scale_of(const LineChart& chart) {
  std::vector<double> values;
  for (const ChartLine& line : chart.lines) {
    values.insert(values.end(), line.values.begin(), line.values.end());
  }
  if (chart.limit) values.push_back(*chart.limit);
  if (chart.logarithmic) {
    std::erase_if(values, [](double v) { return !(v > 0.0); });
    if (values.empty()) return logarithmic_scale(1e-16, 1e-12);
  }
  if (values.empty()) return linear_scale(0.0, 1.0);
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return chart.logarithmic ? logarithmic_scale(*low, *high) : linear_scale(*low, *high);
}

std::string decade(double value) {
  const int exponent = static_cast<int>(std::lround(std::log10(value)));
  return exponent == 0 ? "1" : "1e" + std::to_string(exponent);
}

double x_of(const LineChart& chart, int x) {
  const double first = chart.x.front(), last = chart.x.back();
  const double share = last > first ? (x - first) / (last - first) : 0.5;
  return kLeft + share * (kWidth - kLeft - right_of(chart));
}

std::string axes(const LineChart& chart, const Scale& scale) {
  const double right = kWidth - right_of(chart), bottom = scale.height - kBottom;
  std::string svg;
  for (const double tick : scale.ticks) {
    const double y = scale.y(tick);
    const bool floor = scale.logarithmic && tick == scale.ticks.front();
    svg += svg_line(kLeft, y, right, y, "class=\"grid\"");
    // Rounding leaves some 1e-17 where a tick is zero.
    const double near = std::abs(tick) < 1e-12 * (scale.high - scale.low) ? 0.0 : tick;
    svg += svg_text(kLeft - 6, y + 4,
                    floor ? "0" : (scale.logarithmic ? decade(tick) : readable(near, 4)),
                    " class=\"tick\" text-anchor=\"end\"");
  }
  const Scale frames = linear_scale(chart.x.front(), chart.x.back());
  for (const double tick : frames.ticks) {
    if (tick != std::floor(tick) || tick < chart.x.front() || tick > chart.x.back()) continue;
    svg += svg_text(x_of(chart, static_cast<int>(tick)), bottom + 16, readable(tick, 6),
                    " class=\"tick\" text-anchor=\"middle\"");
  }
  svg +=
      svg_text((kLeft + right) / 2, bottom + 32, "frame", " class=\"tick\" text-anchor=\"middle\"");
  if (chart.limit) {
    const double y = scale.y(*chart.limit);
    svg += svg_line(kLeft, y, right, y, "class=\"limit\"");
    svg += svg_text(kLeft + 6, y + 13, "bound " + readable(*chart.limit), " class=\"limit\"");
  }
  return svg;
}

double spread(const LineChart& chart, const Scale& scale, std::size_t x) {
  double low = scale.height, high = 0.0;
  for (const ChartLine& line : chart.lines) {
    low = std::min(low, scale.y(line.values[x]));
    high = std::max(high, scale.y(line.values[x]));
  }
  return high - low;
}

// Where labels have to stand to tell lines apart: at the end, or where a motion that comes back to
// its beginning spreads them widest.
std::size_t place_of_labels(const LineChart& chart, const Scale& scale) {
  const std::size_t end = chart.x.size() - 1;
  std::size_t widest = end;
  for (std::size_t x = 0; x < end; ++x) {
    if (spread(chart, scale, x) > spread(chart, scale, widest)) widest = x;
  }
  return spread(chart, scale, end) > 0.5 * spread(chart, scale, widest) ? end : widest;
}

// Pushed apart from the top down, then back up where they ran out of paper.
std::vector<double> label_heights(const LineChart& chart, const Scale& scale) {
  std::vector<std::size_t> order(chart.lines.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::vector<double> y(chart.lines.size());
  const std::size_t place = place_of_labels(chart, scale);
  for (const std::size_t i : order) y[i] = scale.y(chart.lines[i].values[place]);
  std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return y[a] < y[b]; });
  double above = kTop - kLabelHeight;
  for (const std::size_t i : order) above = y[i] = std::max(y[i], above + kLabelHeight);
  double below = scale.height - kBottom + kLabelHeight;
  for (auto i = order.rbegin(); i != order.rend(); ++i) {
    below = y[*i] = std::min(y[*i], below - kLabelHeight);
  }
  return y;
}

std::string draw_line(const LineChart& chart, const Scale& scale, std::size_t i, double label_y) {
  const ChartLine& line = chart.lines[i];
  assert(line.values.size() == chart.x.size());
  const std::string colour = chart_colour(i);
  const bool dashed = i >= kLinesInColour;
  std::string points;
  for (std::size_t k = 0; k < line.values.size(); ++k) {
    points += svg_px(x_of(chart, chart.x[k])) + "," + svg_px(scale.y(line.values[k])) + " ";
  }
  const double end_x = x_of(chart, chart.x.back()), end_y = scale.y(line.values.back());
  std::string svg = "<g stroke=\"" + colour + "\"><title>" + escape_html(line.name) + "</title>\n";
  svg += "<polyline points=\"" + points + "\"" + (dashed ? " stroke-dasharray=\"5 3\"" : "") +
         " class=\"line\"/>\n";
  if (line.values.size() == 1) {
    svg += "<circle cx=\"" + svg_px(end_x) + "\" cy=\"" + svg_px(end_y) + "\" r=\"2.5\"/>\n";
  }
  svg += svg_line(end_x + 2, end_y, kWidth - right_of(chart) + 12, label_y, "class=\"leader\"");
  svg += "</g>\n";
  return svg + svg_text(kWidth - right_of(chart) + 16, label_y + 4, line.name,
                        " class=\"label\" fill=\"" + colour + "\"");
}

}  // namespace

std::string svg_px(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed, 1);
  return {text, end.ptr};
}

std::string svg_text(double x, double y, const std::string& text, const std::string& more) {
  return "<text x=\"" + svg_px(x) + "\" y=\"" + svg_px(y) + "\"" + more + ">" + escape_html(text) +
         "</text>\n";
}

std::string svg_line(double x0, double y0, double x1, double y1, const std::string& more) {
  return "<line x1=\"" + svg_px(x0) + "\" y1=\"" + svg_px(y0) + "\" x2=\"" + svg_px(x1) +
         "\" y2=\"" + svg_px(y1) + "\" " + more + "/>\n";
}

const char* chart_colour(std::size_t i) {
  static constexpr const char* kColours[kLinesInColour] = {
      "#0072b2", "#c9480c", "#00855f", "#b5559a", "#7a5200", "#2f9bd6",
      "#a3122a", "#5e3c99", "#5a8f00", "#c98a00", "#444b54", "#0a7f86"};
  return kColours[i % kLinesInColour];
}

std::string draw_chart(const LineChart& chart) {
  if (chart.x.empty() || chart.lines.empty()) return "";
  Scale scale = scale_of(chart);
  scale.height = height_of(chart);
  // For a script that turns a place into a frame.
  const std::string places = " data-frames=\"" + std::to_string(chart.x.front()) + " " +
                             std::to_string(chart.x.back()) + "\" data-plot=\"" + svg_px(kLeft) +
                             " " + svg_px(kWidth - right_of(chart)) + " " + svg_px(kTop) + " " +
                             svg_px(scale.height - kBottom) + "\"";
  std::string svg = begin(chart.title, chart.unit, scale.height, places) + axes(chart, scale);
  const std::vector<double> labels = label_heights(chart, scale);
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    svg += draw_line(chart, scale, i, labels[i]);
  }
  return svg + "</svg>\n";
}

std::string draw_chart(const BarChart& chart) {
  constexpr double kBarLeft = 84, kBarRight = 110, kRow = 34;
  double largest = 0.0;
  for (const auto& [name, value] : chart.bars) largest = std::max(largest, value);
  const double height = kTop + kRow * static_cast<double>(chart.bars.size()) + 6;
  std::string svg = begin(chart.title, chart.unit, height);
  for (std::size_t i = 0; i < chart.bars.size(); ++i) {
    const auto& [name, value] = chart.bars[i];
    const double y = kTop + kRow * static_cast<double>(i);
    const double width =
        largest > 0.0 ? (kWidth - kBarLeft - kBarRight) * std::max(value, 0.0) / largest : 0.0;
    svg += svg_text(kBarLeft - 8, y + 17, name, " class=\"tick\" text-anchor=\"end\"");
    svg += "<rect x=\"" + svg_px(kBarLeft) + "\" y=\"" + svg_px(y) + "\" width=\"" +
           svg_px(std::max(width, 1.0)) + "\" height=\"" + svg_px(kRow - 10) +
           "\" rx=\"2\" fill=\"" + chart_colour(0) + "\"/>\n";
    svg += svg_text(kBarLeft + width + 8, y + 17, readable(value) + " " + chart.unit,
                    " class=\"label\"");
  }
  return svg + "</svg>\n";
}

}  // namespace thew::tools
