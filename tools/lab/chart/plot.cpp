// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/chart/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/svg_chart.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

constexpr double kWidth = 860, kHeight = 560;  // px
constexpr double kLeft = 70, kRight = 200, kTop = 44, kBottom = 100;
constexpr int kColours = 12;                 // that chart_colour() has
constexpr double kLetter = 6.6, kLine = 13;  // of labels, px, about
constexpr const char* kStyle =
    "<style>.cost text{font:12px system-ui,sans-serif;fill:#1d2329}.cost .head{font-size:15px;"
    "font-weight:600}.cost .soft{fill:#5c6670}.cost .bad{fill:#b3261e}.cost .strong{font-weight:"
    "700}</style>\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n";

/// A logarithmic axis from `from` to `to` px.
struct Axis {
  double low = 0.0, high = 1.0;  // decades
  double from = 0.0, to = 1.0;
  std::vector<double> ticks;

  double at(double value) const {
    const double decade = value > 0.0 ? std::max(std::log10(value), low) : low;
    return from + (to - from) * (decade - low) / (high - low);
  }
};

Axis axis_of(const std::vector<double>& values, double from, double to) {
  double least = 0.0, most = 0.0;
  for (const double value : values) {
    if (!(value > 0.0)) continue;
    least = least > 0.0 ? std::min(least, value) : value;
    most = std::max(most, value);
  }
  if (!(least > 0.0)) least = most = 1e-16;
  Axis axis{std::log10(least) - 0.15, std::log10(most) + 0.15, from, to, {}};
  const int step = static_cast<int>(std::ceil((axis.high - axis.low) / 8.0));
  for (int d = static_cast<int>(std::floor(axis.low)); d <= axis.high; d += step) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      if (factor > 1.0 && axis.high - axis.low > 3.0) continue;
      const double tick = factor * std::pow(10.0, d), decade = std::log10(tick);
      if (decade >= axis.low && decade <= axis.high) axis.ticks.push_back(tick);
    }
  }
  return axis;
}

struct Family {
  const char* name;
  const char* colour;
};
Family family_of(const ChartPoint& point) {
  const ChartSetting& setting = point.setting;
  if (point.colour >= 0) return {point.peer.c_str(), chart_colour(point.colour)};
  if (!point.peer.empty())
    return {point.peer.c_str(), chart_colour(setting.integrator == "FEM" ? 8 : 7)};
  if (setting.integrator == "explicit") return {"explicit", chart_colour(3)};
  if (setting.integrator == "xpbd") return {"xpbd", chart_colour(4)};
  if (setting.integrator == "quasi_static") return {"quasi_static", chart_colour(6)};
  if (setting.substeps == 1) return {"local_global, 1 substep", chart_colour(0)};
  if (setting.substeps == 2) return {"local_global, 2 substeps", chart_colour(1)};
  if (setting.substeps == 4) return {"local_global, 4 substeps", chart_colour(2)};
  return {"local_global, other", chart_colour(10)};
}

// A dot about (x, y); a square where the colours have come round, as a thirteenth method's.
std::string dot_of(const ChartPoint& point, double x, double y, const std::string& attributes) {
  if (point.colour < kColours) {
    return "<circle cx=\"" + svg_px(x) + "\" cy=\"" + svg_px(y) + "\" r=\"4.5\" " + attributes;
  }
  return "<rect x=\"" + svg_px(x - 4) + "\" y=\"" + svg_px(y - 4) + "\" width=\"8\" height=\"8\" " +
         attributes;
}

std::string label_of(const ChartPoint& point) {
  if (!point.peer.empty()) return point.label;
  const ChartSetting& setting = point.setting;
  const bool is_explicit = setting.integrator == "explicit";
  std::string label = std::to_string(setting.substeps);
  if (!is_explicit) label += "×" + std::to_string(setting.iterations);
  if (setting.integrator == "quasi_static") label = "rest";
  if (setting.volume != "exact" || is_explicit) label += " " + setting.volume;
  return label + (point.is_default ? " (the scene's)" : "");
}

/// Where text may still stand.
struct Box {
  double x0, y0, x1, y1;
  bool meets(const Box& b) const { return x0 < b.x1 && b.x0 < x1 && y0 < b.y1 && b.y0 < y1; }
};

// Beside the point, above or below it, wherever it meets nothing; none of these: no label, the
// point's tooltip has its name.
std::string place_label(const ChartPoint& point, double x, double y, std::vector<Box>& taken) {
  const std::string label = label_of(point);
  const double width = kLetter * static_cast<double>(label.size());
  const double gap = point.is_default ? 12 : 8;
  const std::array<std::array<double, 2>, 6> places = {{{x + gap, y - kLine / 2},
                                                        {x - gap - width, y - kLine / 2},
                                                        {x - width / 2, y - gap - kLine},
                                                        {x - width / 2, y + gap},
                                                        {x + 4, y - gap - kLine},
                                                        {x + 4, y + gap}}};
  for (const auto& [left, top] : places) {
    const Box box{left, top, left + width, top + kLine};
    if (left < kLeft || box.x1 > kWidth - kRight + 4 || box.y1 > kHeight - kBottom) continue;
    if (std::any_of(taken.begin(), taken.end(), [&](const Box& b) { return b.meets(box); })) {
      continue;
    }
    taken.push_back(box);
    return svg_text(left, top + kLine - 3, label, point.is_default ? " class=\"strong\"" : "");
  }
  return "";
}

std::string draw_axes(const Axis& x, const Axis& y, const std::string& what) {
  std::string svg;
  const double right = kWidth - kRight, bottom = kHeight - kBottom;
  for (const double tick : x.ticks) {
    svg += svg_line(x.at(tick), kTop, x.at(tick), bottom, "stroke=\"#e3e6e9\"");
    svg += svg_text(x.at(tick), bottom + 17, readable(tick, 3),
                    " class=\"soft\" text-anchor=\"middle\"");
  }
  for (const double tick : y.ticks) {
    svg += svg_line(kLeft, y.at(tick), right, y.at(tick), "stroke=\"#e3e6e9\"");
    svg += svg_text(kLeft - 8, y.at(tick) + 4, readable(tick, 3),
                    " class=\"soft\" text-anchor=\"end\"");
  }
  svg += svg_text((kLeft + right) / 2, bottom + 36, "CPU ms a frame, one thread",
                  " text-anchor=\"middle\"");
  return svg + svg_text(0, 0, what,
                        " text-anchor=\"middle\" transform=\"translate(16," +
                            svg_px((kTop + bottom) / 2) + ") rotate(-90)\"");
}

// Of a family of which no run came to a point: "failed", or "given up" where none was begun.
std::string why_no_point(const Chart& chart, const std::string& family) {
  std::string why = "given up";
  for (const ChartPoint& point : chart.points) {
    if (family_of(point).name != family) continue;
    if (point.failure.empty()) return "";
    if (!point.failure.starts_with(kGivenUp)) why = "failed";
  }
  return why;
}

std::string draw_legend(const Chart& chart) {
  std::string svg;
  std::vector<std::string> told;
  const double x = kWidth - kRight + 16;
  double y = kTop + 10;
  const auto row = [&](const std::string& mark, const std::string& text) {
    svg += "<g transform=\"translate(" + svg_px(x) + "," + svg_px(y) + ")\">" + mark + "</g>\n" +
           svg_text(x + 14, y + 4, text);
    y += 20;
  };
  for (const ChartPoint& point : chart.points) {
    const Family family = family_of(point);
    if (std::find(told.begin(), told.end(), family.name) != told.end()) continue;
    told.push_back(family.name);
    const std::string none = why_no_point(chart, family.name);
    if (none.empty()) {
      row(dot_of(point, 0, 0, "fill=\"" + std::string(family.colour) + "\"/>"), family.name);
    } else {
      row("<path d=\"M-4-4L4 4M4-4L-4 4\" stroke=\"#b3261e\" stroke-width=\"1.8\"/>",
          family.name + (": " + none));
    }
  }
  row("<circle r=\"4.5\" fill=\"#fff\" stroke=\"#5c6670\" stroke-width=\"1.8\"/>",
      "volume not exact");
  const auto some = [&](const auto& is) {
    return std::any_of(chart.points.begin(), chart.points.end(), is);
  };
  const bool has_own = some([](const ChartPoint& p) { return p.is_default; });
  if (has_own)
    row("<circle r=\"8\" fill=\"none\" stroke=\"#1d2329\" stroke-width=\"2\"/>",
        "the scene's setting");
  row("<line x1=\"-8\" x2=\"8\" stroke=\"#1d2329\" stroke-dasharray=\"4 3\"/>",
      "none cheaper is better");
  if (some([](const ChartPoint& p) { return p.peer.empty(); }))
    svg += svg_text(x - 8, y + 4, "labels: substeps × iterations", " class=\"soft\"");
  return svg;
}

// Runs that could not go on have no error: they stand below the axis, by name, an integrator's
// together: "explicit: 1 exact, 4 exact".
std::string draw_failed(const Chart& chart) {
  std::string names, last;
  int failed = 0;
  for (const ChartPoint& point : chart.points) {
    if (point.failure.empty()) continue;
    const std::string name = point_name(point), family = name.substr(0, name.find(' '));
    names += family == last ? "," : (failed == 0 ? "" : "; ") + family + ":";
    names += name.substr(family.size());
    last = family;
    ++failed;
  }
  const std::string runs = std::to_string(chart.points.size()) + " runs failed or given up";
  const double y = kHeight - kBottom + 64;
  if (failed == 0) return svg_text(kLeft, y, "none of " + runs, " class=\"soft\"");
  std::string svg = "<rect x=\"" + svg_px(kLeft - 6) + "\" y=\"" + svg_px(y - 16) + "\" width=\"" +
                    svg_px(kWidth - kLeft) + "\" height=\"44\" fill=\"#fbeceb\"/>\n" +
                    svg_text(kLeft, y, std::to_string(failed) + " of " + runs, " class=\"bad\"");
  const std::size_t fits = static_cast<std::size_t>((kWidth - kLeft - 10) / kLetter);
  if (names.size() > fits) names = names.substr(0, fits - 20) + " ... (chart.csv)";
  return svg + svg_text(kLeft, y + 18, "✕ " + names, " class=\"bad\"");
}

}  // namespace

std::string draw_cost(const Chart& whole, double ChartPoint::*error, const std::string& what) {
  Chart chart = whole;
  std::erase_if(chart.points, [&](const ChartPoint& point) {
    return point.failure.empty() && point.*error < 0.0;  // it has no such error
  });
  std::vector<double> costs, errors;
  for (const ChartPoint& point : chart.points) {
    if (!point.failure.empty()) continue;
    costs.push_back(point.milliseconds);
    errors.push_back(point.*error);
  }
  const Axis x = axis_of(costs, kLeft, kWidth - kRight);
  const Axis y = axis_of(errors, kHeight - kBottom, kTop);
  std::string svg = "<svg class=\"cost\" viewBox=\"0 0 " + svg_px(kWidth) + " " + svg_px(kHeight) +
                    "\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">\n" + kStyle;
  const std::string title = chart.scene + ", " + std::to_string(chart.muscles) +
                            (chart.muscles == 1 ? " muscle, " : " muscles, ") +
                            std::to_string(chart.nodes) + " nodes, " +
                            std::to_string(chart.frames) + " frames: " + what;
  svg += svg_text(kLeft, 24, title, " class=\"head\"") + draw_axes(x, y, what);
  const std::vector<std::size_t> front = pareto_front(chart.points, error);
  std::string path, marks, labels;
  std::vector<Box> taken;
  std::vector<std::size_t> order = front;  // the front is labelled first
  for (std::size_t i = 0; i < chart.points.size(); ++i) {
    const ChartPoint& point = chart.points[i];
    if (!point.failure.empty()) continue;
    const double px = x.at(point.milliseconds), py = y.at(point.*error);
    taken.push_back({px - 5, py - 5, px + 5, py + 5});
    if (point.is_default) order.insert(order.begin(), i);
    order.push_back(i);
    const std::string colour = family_of(point).colour;
    const std::string& volume = point.setting.volume;
    const bool exact = volume.starts_with("exact") || volume.starts_with("zonal");
    const std::string place = "cx=\"" + svg_px(px) + "\" cy=\"" + svg_px(py) + "\"";
    marks += "<g>" +
             dot_of(point, px, py,
                    "fill=\"" + (exact ? colour : "#fff") + "\" stroke=\"" + colour +
                        "\" stroke-width=\"1.8\"/>") +
             "<title>" + escape_html(point_name(point)) + ": " + readable(point.milliseconds) +
             " ms, " + readable(point.*error) + "</title></g>\n";
    if (!point.is_default) continue;
    marks += "<circle class=\"default\" " + place +
             " r=\"8\" fill=\"none\" stroke=\"#1d2329\" stroke-width=\"2\"/>\n";
  }
  for (const std::size_t i : front) {
    path += svg_px(x.at(chart.points[i].milliseconds)) + "," +
            svg_px(y.at(chart.points[i].*error)) + " ";
  }
  svg += "<polyline points=\"" + path +
         "\" fill=\"none\" stroke=\"#1d2329\" stroke-dasharray=\"4 3\"/>\n";
  std::vector<char> labelled(chart.points.size(), 0);
  for (const std::size_t i : order) {
    if (labelled[i]) continue;
    labelled[i] = 1;
    labels += place_label(chart.points[i], x.at(chart.points[i].milliseconds),
                          y.at(chart.points[i].*error), taken);
  }
  return svg + marks + labels + draw_legend(chart) + draw_failed(chart) + "</svg>\n";
}

std::string write_picture(const std::filesystem::path& png, const std::filesystem::path& svg) {
  const Temporary out(png);
  const int code =
      run_program({"rsvg-convert", "--width", "1720", "--output", out.path.string(), svg.string()});
  if (code == 0) {
    place_durably(out.path, png);
    return "";
  }
  if (code == kNotFound) return "";
  return png.string() + ": rsvg-convert ended with " + std::to_string(code) +
         " and drew nothing; the chart is in " + svg.string();
}

std::string chart_csv(const Chart& chart) {
  std::string text =
      "integrator,volume,substeps,iterations,default,front,failed,cpu_ms_per_frame,"
      "largest_mm,rms_mm,percent_of_muscle,own_mm,volume_error,penetration_mm\n";
  for (const ChartPoint& point : chart.points) {
    const ChartSetting& s = point.setting;
    text += s.integrator + "," + s.volume + "," + std::to_string(s.substeps) + "," +
            std::to_string(s.iterations) + "," + (point.is_default ? "1," : "0,") +
            (point.on_front ? "1," : "0,") + (point.failure.empty() ? "0" : "1");
    for (const double value : {point.milliseconds, point.largest_mm, point.rms_mm, point.percent,
                               point.own_mm, point.volume_error, point.penetration_mm}) {
      text += "," + (point.failure.empty() && value >= 0.0 ? readable(value, 6) : std::string());
    }
    text += "\n";
  }
  return text;
}

namespace {

nlohmann::ordered_json json_of(const ChartPoint& point) {
  nlohmann::ordered_json out = {{"integrator", point.setting.integrator},
                                {"volume", point.setting.volume},
                                {"substeps", point.setting.substeps}};
  if (point.setting.integrator != "explicit") out["iterations"] = point.setting.iterations;
  if (!point.failure.empty()) {
    out["failure"] = point.failure;
    return out;
  }
  out["default"] = point.is_default;
  out["front"] = point.on_front;
  out["cpu_ms_per_frame"] = point.milliseconds;
  out["largest_mm"] = point.largest_mm;
  out["rms_mm"] = point.rms_mm;
  out["percent_of_muscle"] = point.percent;
  if (point.own_mm >= 0.0) out["own_mm"] = point.own_mm;
  out["volume_error"] = point.volume_error;
  out["penetration_mm"] = point.penetration_mm;
  return out;
}

nlohmann::ordered_json json_of(const Refinement& refinement) {
  nlohmann::ordered_json out = {{"integrator", refinement.integrator}};
  for (const ChartSetting& setting : refinement.settings) {
    out["settings"].push_back(setting_name(setting));
  }
  if (!refinement.failure.empty()) {
    out["failure"] = refinement.failure;
    return out;
  }
  out["largest_mm_to_next"] = refinement.largest_mm;
  out["rms_mm_to_next"] = refinement.rms_mm;
  out["order"] = refinement.order;
  out["largest_mm_from_reference"] = refinement.apart_mm;
  return out;
}

// "" where there is none.
std::string figure_of(double value) { return value >= 0.0 ? number(value) : ""; }

}  // namespace

Table points_of(const Chart& chart) {
  Table table{"",
              "Each setting",
              "Errors are distances from " + setting_name(chart.reference) +
                  ", over all nodes and frames. Front: nothing cheaper is nearer.",
              {"setting", "CPU ms a frame", "time over the scene's own", "largest, mm", "RMS, mm",
               "% of the muscle", "from its own finest, mm", "volume error", "penetration, mm", ""},
              {}};
  double own = 0.0;
  for (const ChartPoint& point : chart.points) {
    if (point.is_default) own = point.milliseconds;
  }
  for (const ChartPoint& point : chart.points) {
    std::vector<std::string>& row = table.rows.emplace_back(table.head.size());
    row.front() = point_name(point) + (point.is_default ? " (the scene's)" : "");
    row.back() = point.failure.empty() ? (point.on_front ? "front" : "") : point.failure;
    if (!point.failure.empty()) continue;
    const double over = own > 0.0 ? point.milliseconds / own : -1.0;
    int column = 0;
    for (const double value :
         {point.milliseconds, over, point.largest_mm, point.rms_mm, point.percent, point.own_mm,
          point.volume_error, point.penetration_mm}) {
      row[++column] = figure_of(value);
    }
  }
  return table;
}

Table refinements_of(const Chart& chart) {
  Table table{
      "",
      "Does each integrator converge, and to the same?",
      "Each line halves the step of the one above. Order: log2 of a difference (RMS) over "
      "the next one, 1 for a method of first order. The last difference is how far to "
      "trust the errors of position.",
      {"setting", "to the next, largest, mm", "RMS, mm", "order", "finest from the reference, mm"},
      {}};
  for (const Refinement& refinement : chart.refinements) {
    if (!refinement.failure.empty()) {
      table.rows.push_back({refinement.integrator, refinement.failure, "", "", ""});
      continue;
    }
    for (std::size_t k = 0; k < refinement.settings.size(); ++k) {
      const bool finest = k + 1 == refinement.settings.size();
      table.rows.push_back({setting_name(refinement.settings[k]),
                            finest ? "" : number(refinement.largest_mm[k]),
                            finest ? "" : number(refinement.rms_mm[k]),
                            k < refinement.order.size() ? number(refinement.order[k]) : "",
                            finest ? number(refinement.apart_mm) : ""});
    }
  }
  return table;
}

std::string chart_json(const Chart& chart) {
  nlohmann::ordered_json out = {{"scene", chart.scene},
                                {"muscles", chart.muscles},
                                {"nodes", chart.nodes},
                                {"frames", chart.frames},
                                {"timed_frames", chart.timed_frames},
                                {"repetitions", chart.repetitions}};
  out["reference"] = setting_name(chart.reference);
  for (const ChartPoint& point : chart.points) out["runs"].push_back(json_of(point));
  for (const Refinement& refinement : chart.refinements) {
    out["refinements"].push_back(json_of(refinement));
  }
  return out.dump(2) + "\n";
}

std::string chart_html(const Chart& chart, const std::string& more) {
  std::string html =
      "<p class=\"soft\">Here the muscles without the skin. Errors: distance of each node, over "
      "all " +
      std::to_string(chart.frames) + " frames, from " + escape_html(setting_name(chart.reference)) +
      ". Cost: CPU time of one thread over the first " + std::to_string(chart.timed_frames) +
      " frames, median of " + std::to_string(chart.repetitions) +
      " interleaved repetitions. Each explicit substep is divided further, for each muscle into "
      "what its own stability asks for.</p>\n";
  const auto add = [&](double ChartPoint::*error, const std::string& what) {
    html += "<figure>" + draw_cost(chart, error, what) + "</figure>\n";
  };
  html += "<h2>Position</h2>\n";
  add(&ChartPoint::largest_mm, "largest position error, mm");
  add(&ChartPoint::rms_mm, "RMS position error, mm");
  add(&ChartPoint::own_mm, "largest distance from the integrator's own finest run, mm");
  html += "<h2>Volume and contact</h2>\n";
  add(&ChartPoint::volume_error, "largest volume error");
  add(&ChartPoint::penetration_mm, "deepest penetration, mm");
  html += "<h2>All runs</h2>\n" + html_of(points_of(chart)) + html_of(refinements_of(chart)) + more;
  return html_page(chart.scene + ": speed against accuracy", "", html);
}

}  // namespace thew::tools
