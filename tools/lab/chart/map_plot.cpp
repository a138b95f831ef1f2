// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <nlohmann/json.hpp>

#include "tools/base/svg_chart.h"
#include "tools/lab/base/table.h"
#include "tools/lab/chart/maps.h"

namespace thew::tools {
namespace {

constexpr double kCell = 62, kRow = 26, kLeft = 78, kTop = 40, kBottom = 40;  // px

// Told apart without colour as well: each has its sign.
const char* colour_of(Verdict verdict) {
  constexpr const char* kColours[] = {"#2e7d5b", "#e3b23c", "#5b8fd6", "#b3261e", "#e3e6e9"};
  return kColours[static_cast<int>(verdict)];
}
const char* sign_of(Verdict verdict) {
  constexpr const char* kSigns[] = {"✓", "~", "↺", "✕", ""};
  return kSigns[static_cast<int>(verdict)];
}

std::string column_name(double value) { return value >= 1e9 ? "all" : readable(value); }

std::string told(const MapCell& cell) {
  std::string text = verdict_name(cell.verdict);
  if (!cell.failure.empty()) return text + ": " + cell.failure;
  return text + ": volume error " + readable(cell.volume_error) + ", at the end " +
         readable(cell.last_volume) + "; inverted triangles " + std::to_string(cell.inverted) +
         ", at the end " + std::to_string(cell.last_inverted) + "; energy at rest times " +
         readable(cell.growth) + "; speed " + readable(cell.speed) + " sizes/s; " +
         readable(100.0 * cell.distance) + " % from the finest step";
}

}  // namespace

std::string draw_map(const StabilityMap& map) {
  const double width = kLeft + kCell * static_cast<double>(map.columns.size()) + 8;
  const double bottom = kTop + kRow * static_cast<double>(map.steps.size());
  std::string svg = "<svg class=\"map\" viewBox=\"0 0 " + svg_px(width) + " " +
                    svg_px(bottom + kBottom) + "\" width=\"" + svg_px(width) +
                    "\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">\n<style>.map "
                    "text{font:12px system-ui,sans-serif;fill:#1d2329}.map .head{font-weight:600}"
                    ".map .on{fill:#fff;font-size:14px}</style>\n";
  svg += svg_text(0, 16, map.method + ": " + map.quantity, " class=\"head\"");
  svg += svg_text(0, 33, "step, s");
  for (size_t s = 0; s < map.steps.size(); ++s) {
    const double y = kTop + kRow * static_cast<double>(s);
    svg += svg_text(kLeft - 8, y + 17, readable(map.steps[s], 4), " text-anchor=\"end\"");
    for (size_t c = 0; c < map.columns.size(); ++c) {
      const MapCell& cell = map.cells[s][c];
      const double x = kLeft + kCell * static_cast<double>(c);
      svg += "<g><rect x=\"" + svg_px(x) + "\" y=\"" + svg_px(y) + "\" width=\"" +
             svg_px(kCell - 2) + "\" height=\"" + svg_px(kRow - 2) + "\" fill=\"" +
             colour_of(cell.verdict) + "\"/>" +
             svg_text(x + kCell / 2 - 1, y + 17, sign_of(cell.verdict),
                      " class=\"on\" text-anchor=\"middle\"") +
             "<title>" + escape_html(told(cell)) + "</title></g>\n";
    }
  }
  for (size_t c = 0; c < map.columns.size(); ++c) {
    svg += svg_text(kLeft + kCell * (static_cast<double>(c) + 0.5), bottom + 14,
                    column_name(map.columns[c]), " text-anchor=\"middle\"");
  }
  svg += svg_text((kLeft + width) / 2, bottom + 32, map.unit, " text-anchor=\"middle\"");
  return svg + "</svg>\n";
}

std::string maps_csv(const std::vector<StabilityMap>& maps) {
  std::string text =
      "method,quantity,value,step_s,verdict,volume_error,last_volume_error,inverted,last_inverted,"
      "energy_growth,speed_sizes_per_s,distance_from_finest\n";
  for (const StabilityMap& map : maps) {
    for (size_t s = 0; s < map.steps.size(); ++s) {
      for (size_t c = 0; c < map.columns.size(); ++c) {
        const MapCell& cell = map.cells[s][c];
        text += map.method + "," + map.quantity + "," + column_name(map.columns[c]) + "," +
                readable(map.steps[s], 6) + "," + verdict_name(cell.verdict);
        if (!cell.failure.empty()) {
          text += ",,,,,,,\n";
          continue;
        }
        text += "," + readable(cell.volume_error, 6) + "," + readable(cell.last_volume, 6) + "," +
                std::to_string(cell.inverted) + "," + std::to_string(cell.last_inverted) + "," +
                readable(cell.growth, 6) + "," + readable(cell.speed, 6) + "," +
                readable(cell.distance, 6) + "\n";
      }
    }
  }
  return text;
}

std::string maps_json(const std::vector<StabilityMap>& maps) {
  nlohmann::ordered_json out;
  for (const StabilityMap& map : maps) {
    nlohmann::ordered_json one = {
        {"method", map.method}, {"quantity", map.quantity}, {"unit", map.unit}};
    for (size_t s = 0; s < map.steps.size(); ++s) {
      for (size_t c = 0; c < map.columns.size(); ++c) {
        const MapCell& cell = map.cells[s][c];
        nlohmann::ordered_json entry = {{"value", column_name(map.columns[c])},
                                        {"step_s", map.steps[s]},
                                        {"verdict", verdict_name(cell.verdict)}};
        if (!cell.failure.empty()) {
          entry["failure"] = cell.failure;
        } else {
          entry["volume_error"] = cell.volume_error;
          entry["last_volume_error"] = cell.last_volume;
          entry["inverted"] = cell.inverted;
          entry["last_inverted"] = cell.last_inverted;
          entry["energy_growth"] = cell.growth;
          entry["speed_sizes_per_s"] = cell.speed;
          entry["distance_from_finest"] = cell.distance;
        }
        one["cells"].push_back(entry);
      }
    }
    out.push_back(one);
  }
  return out.dump(2) + "\n";
}

std::string maps_html(const std::string& scene, const std::vector<StabilityMap>& maps) {
  std::string html =
      "<p class=\"soft\">The scene's first muscle as a body by itself, "
      "with its material and the exact volume: loaded in 0.6 s (struck: as fast as said), held for "
      "0.6 s, let go in 0.6 s, left at rest for 0.6 s. Stiffness, weights and overlap under a "
      "squeeze to 60 % of the height; twisted by its ends, elsewhere between two planes.</p>\n<p>";
  for (const Verdict verdict : {Verdict::kAccurate, Verdict::kRecovered, Verdict::kDegraded,
                                Verdict::kDiverged, Verdict::kNotRun}) {
    html += "<span style=\"background:" + std::string(colour_of(verdict)) +
            ";color:#fff;padding:2px 8px;margin-right:8px\">" + sign_of(verdict) + " " +
            verdict_name(verdict) + "</span>";
  }
  html +=
      "</p>\n<p>Accurate: in each frame a volume error of at most 1e-9, no inverted triangle "
      "(normal against the mean of its neighbours') and no growth of energy beyond 5 % while the "
      "rig rests; at the end slower than 0.05 of its size a second and within 2 % of its size "
      "(RMS) "
      "of the same method's run with the finest step. Recovered: only the end is so. Diverged: the "
      "solver gave up, the energy grew tenfold while the rig rested, or the volume ends off by "
      "more "
      "than 1 %. Degraded: the rest. Not run: explicit steps beyond the work that a cell may "
      "take. Each cell's tooltip has its figures.</p>\n";
  std::string method;
  for (const StabilityMap& map : maps) {
    if (map.method != method) {
      if (!method.empty()) html += "</div>\n";
      html += "<h2>" + escape_html(map.method) + "</h2>\n<div class=\"maps\">\n";
      method = map.method;
    }
    html += draw_map(map);
  }
  return html_page(scene + ": where methods fail",
                   ".maps { display: flex; flex-wrap: wrap; gap: 18px; }", html + "</div>\n");
}

}  // namespace thew::tools
