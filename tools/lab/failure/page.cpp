// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "tools/base/svg_chart.h"
#include "tools/lab/base/table.h"
#include "tools/lab/failure/maps.h"

namespace thew::tools {
namespace {

constexpr double kCell = 42, kRow = 24, kPlotLeft = 66, kPlotTop = 40, kPlotBottom = 40;  // px

constexpr Verdict kVerdicts[] = {Verdict::kAccurate, Verdict::kRecovered, Verdict::kDegraded,
                                 Verdict::kDiverged, Verdict::kNotRun};

const char* colour_of(Verdict verdict) {
  constexpr const char* kColours[] = {"#2e7d5b", "#d9a320", "#5b8fd6", "#b3261e", "#8b949c"};
  return kColours[static_cast<int>(verdict)];
}

// Told apart without colour as well: what is not accurate has its mechanism's letter.
std::string sign_of(const MapCell& cell) {
  if (cell.verdict == Verdict::kAccurate) return "✓";
  return mechanism_text(cell.mechanism).sign;
}

std::string column_name(double value) { return value >= 1e9 ? "all" : number(value); }

bool has_figures(const MapCell& cell) { return !cell.inferred && cell.failure.empty(); }

std::string told(const MapCell& cell) {
  std::string text = verdict_name(cell.verdict);
  if (cell.mechanism != Mechanism::kNone) {
    text += std::string(", ") + mechanism_text(cell.mechanism).name;
  }
  if (cell.inferred) return text + ": not run, all cells around it say so";
  if (!cell.failure.empty()) return text + ": " + cell.failure;
  return text + ": volume error " + readable(cell.volume_error) + ", at the end " +
         readable(cell.last_volume) + "; inverted triangles " + std::to_string(cell.inverted) +
         ", at the end " + std::to_string(cell.last_inverted) + "; energy at rest times " +
         readable(cell.growth) + "; speed " + readable(cell.speed) + " sizes/s; " +
         readable(100.0 * cell.distance) + " % from the finest step";
}

}  // namespace

std::string draw_map(const StabilityMap& map) {
  const double width = kPlotLeft + kCell * static_cast<double>(map.columns.size()) + 8;
  const double bottom = kPlotTop + kRow * static_cast<double>(map.steps.size());
  std::string svg = "<svg class=\"map\" viewBox=\"0 0 " + svg_px(width) + " " +
                    svg_px(bottom + kPlotBottom) + "\" width=\"" + svg_px(width) +
                    "\" role=\"img\" xmlns=\"http://www.w3.org/2000/svg\">\n<style>.map "
                    "text{font:12px system-ui,sans-serif;fill:#1d2329}.map .head{font-weight:600}"
                    ".map .on{fill:#fff;font-weight:600}</style>\n";
  svg += svg_text(0, 16, map.quantity, " class=\"head\"");
  svg += svg_text(0, 33, "step, s");
  for (size_t s = 0; s < map.steps.size(); ++s) {
    const double y = kPlotTop + kRow * static_cast<double>(s);
    svg += svg_text(kPlotLeft - 8, y + 17, readable(map.steps[s], 4), " text-anchor=\"end\"");
    for (size_t c = 0; c < map.columns.size(); ++c) {
      const MapCell& cell = map.cells[s][c];
      const double x = kPlotLeft + kCell * static_cast<double>(c);
      const std::string colour = colour_of(cell.verdict);
      svg += "<g><rect x=\"" + svg_px(x + 0.5) + "\" y=\"" + svg_px(y + 0.5) + "\" width=\"" +
             svg_px(kCell - 3) + "\" height=\"" + svg_px(kRow - 3) + "\" stroke=\"" + colour +
             "\" fill=\"" + (cell.inferred ? "#fff" : colour) + "\"/>" +
             svg_text(x + kCell / 2 - 1, y + 16, sign_of(cell),
                      cell.inferred ? " text-anchor=\"middle\" style=\"fill:" + colour + "\""
                                    : " class=\"on\" text-anchor=\"middle\"") +
             "<title>" + escape_html(told(cell)) + "</title></g>\n";
    }
  }
  for (size_t c = 0; c < map.columns.size(); ++c) {
    svg += svg_text(kPlotLeft + kCell * (static_cast<double>(c) + 0.5), bottom + 14,
                    column_name(map.columns[c]), " text-anchor=\"middle\"");
  }
  svg += svg_text((kPlotLeft + width) / 2, bottom + 32, map.unit, " text-anchor=\"middle\"");
  return svg + "</svg>\n";
}

std::string maps_csv(const std::vector<StabilityMap>& maps) {
  Table table;
  table.head = {"method",
                "quantity",
                "value",
                "step_s",
                "verdict",
                "mechanism",
                "run",
                "volume_error",
                "last_volume_error",
                "inverted",
                "last_inverted",
                "energy_growth",
                "speed_sizes_per_s",
                "distance_from_finest"};
  for (const StabilityMap& map : maps) {
    for (size_t s = 0; s < map.steps.size(); ++s) {
      for (size_t c = 0; c < map.columns.size(); ++c) {
        const MapCell& cell = map.cells[s][c];
        std::vector<std::string>& row = table.rows.emplace_back();
        row = {map.method,
               map.quantity,
               column_name(map.columns[c]),
               readable(map.steps[s], 6),
               verdict_name(cell.verdict),
               mechanism_text(cell.mechanism).name,
               cell.inferred ? "no" : "yes"};
        if (has_figures(cell)) {
          row.insert(row.end(), {readable(cell.volume_error, 6), readable(cell.last_volume, 6),
                                 std::to_string(cell.inverted), std::to_string(cell.last_inverted),
                                 readable(cell.growth, 6), readable(cell.speed, 6),
                                 readable(cell.distance, 6)});
        }
        row.resize(table.head.size());
      }
    }
  }
  return csv_of(table);
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
                                        {"verdict", verdict_name(cell.verdict)},
                                        {"mechanism", mechanism_text(cell.mechanism).name},
                                        {"run", !cell.inferred}};
        if (!cell.failure.empty()) entry["failure"] = cell.failure;
        if (has_figures(cell)) {
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

namespace {

// What is known of the cells of one map that one mechanism holds.
struct Region {
  int cells = 0, run = 0;
  std::map<Verdict, int> verdicts;
  size_t first_step = 1000, last_step = 0, first_column = 1000, last_column = 0;
  double volume = 0.0, speed = 0.0, distance = 0.0;
  int inverted = 0;
};

std::map<Mechanism, Region> regions_in(const StabilityMap& map) {
  std::map<Mechanism, Region> out;
  for (size_t s = 0; s < map.steps.size(); ++s) {
    for (size_t c = 0; c < map.columns.size(); ++c) {
      const MapCell& cell = map.cells[s][c];
      if (cell.verdict == Verdict::kAccurate) continue;
      Region& region = out[cell.mechanism];
      ++region.cells;
      region.run += !cell.inferred;
      ++region.verdicts[cell.verdict];
      region.first_step = std::min(region.first_step, s);
      region.last_step = std::max(region.last_step, s);
      region.first_column = std::min(region.first_column, c);
      region.last_column = std::max(region.last_column, c);
      region.volume = std::max(region.volume, cell.volume_error);
      region.inverted = std::max(region.inverted, cell.inverted);
      region.speed = std::max(region.speed, cell.speed);
      region.distance = std::max(region.distance, cell.distance);
    }
  }
  return out;
}

std::string range(const std::string& first, const std::string& last) {
  return first == last ? first : first + " to " + last;
}

std::string figures_of(Mechanism mechanism, const Region& region) {
  switch (mechanism) {
    case Mechanism::kVolumeLost:
    case Mechanism::kVolumeSoft:
      return "volume error up to " + number(region.volume, 2);
    case Mechanism::kFolded:
    case Mechanism::kFoldedThere:
      return "inverted triangles up to " + std::to_string(region.inverted);
    case Mechanism::kMoving:
      return "up to " + number(region.speed, 2) + " sizes a second";
    case Mechanism::kElsewhere:
      return "up to " + number(100.0 * region.distance, 2) + " % of its size from the finest";
    default:
      return "";
  }
}

// Of another's region: what Thew's default makes of the same values, at any of its steps.
std::string default_there(const std::vector<StabilityMap>& maps, const StabilityMap& map,
                          const Region& region) {
  for (const StabilityMap& ours : maps) {
    if (ours.method != "local_global" || ours.quantity != map.quantity) continue;
    int cells = 0, accurate = 0;
    for (const auto& row : ours.cells) {
      for (size_t c = region.first_column; c <= region.last_column; ++c) {
        ++cells;
        accurate += row[c].verdict == Verdict::kAccurate;
      }
    }
    return "local_global of the same values: accurate in " + std::to_string(accurate) + " of " +
           std::to_string(cells) + " cells, steps of " + number(ours.steps.front()) + " to " +
           number(ours.steps.back()) + " s";
  }
  return "";
}

std::string thew_there(const std::vector<StabilityMap>& maps, const StabilityMap& map,
                       Mechanism mechanism, const Region& region) {
  if (!map.is_thew) return default_there(maps, map, region);
  for (const auto& [of, what] : map.with_rungs) {
    if (of == mechanism) return what;
  }
  return mechanism_text(mechanism).thew;
}

}  // namespace

Table regions_of(const std::vector<StabilityMap>& maps) {
  Table table{"regions.csv",
              "Where each method fails, by what, and what Thew does there",
              "Of Thew's own: the region's coarsest step once more as a bake runs it, with frames "
              "divided and what stands in for a failed step. Of others: Thew's default at the same "
              "values.",
              {"method", "quantity", "values", "steps, s", "cells (run)", "verdict", "mechanism",
               "figure", "Thew there"},
              {}};
  for (const StabilityMap& map : maps) {
    for (const auto& [mechanism, region] : regions_in(map)) {
      std::string verdicts;
      for (const auto& [verdict, count] : region.verdicts) {
        verdicts += (verdicts.empty() ? "" : ", ") + std::string(verdict_name(verdict));
      }
      table.rows.push_back(
          {map.method, map.quantity,
           range(column_name(map.columns[region.first_column]),
                 column_name(map.columns[region.last_column])) +
               " " + map.unit,
           range(number(map.steps[region.first_step]), number(map.steps[region.last_step])),
           std::to_string(region.cells) + " (" + std::to_string(region.run) + ")", verdicts,
           mechanism_text(mechanism).name, figures_of(mechanism, region),
           thew_there(maps, map, mechanism, region)});
    }
  }
  return table;
}

Table verdicts_of(const std::vector<StabilityMap>& maps) {
  Table table{"verdicts.csv",
              "Cells of each method by verdict",
              "Run: those that were; the others are told by what surrounds them. Checked: of the "
              "others, one in eight was run after all; how many of these were not as told.",
              {"method", "what", "cells", "run", "checked", "not as told"},
              {}};
  for (const Verdict verdict : kVerdicts) table.head.emplace_back(verdict_name(verdict));
  for (size_t first = 0; first < maps.size();) {
    size_t last = first;
    int cells = 0, run = 0, checked = 0, differed = 0;
    std::map<Verdict, int> counts;
    for (; last < maps.size() && maps[last].method == maps[first].method; ++last) {
      checked += maps[last].checked;
      differed += maps[last].differed;
      for (const auto& row : maps[last].cells) {
        for (const MapCell& cell : row) {
          ++cells;
          run += !cell.inferred;
          ++counts[cell.verdict];
        }
      }
    }
    std::vector<std::string>& row = table.rows.emplace_back();
    row = {maps[first].method, maps[first].what};
    for (const int count : {cells, run, checked, differed}) row.push_back(std::to_string(count));
    for (const Verdict verdict : kVerdicts) row.push_back(std::to_string(counts[verdict]));
    first = last;
  }
  return table;
}

namespace {

constexpr const char* kIntroduction =
    "<p>The scene's first muscle as a body by itself, with its material: loaded in 0.6 s (struck: "
    "as fast as said), held for 0.6 s, let go in 0.6 s, left at rest for 0.6 s. Stiffness, weights "
    "and shortened edges under a squeeze to 60 % of the height; twisted by its ends, elsewhere "
    "between two planes. The methods of others are those of the page of related work, "
    "each at the first of its settings, with a step of its own: explicit ones need shorter steps "
    "than Thew, which divides its own where it is explicit. Weights are Thew's alone. quasi_static "
    "goes from frame to frame here; a bake solves each of its frames by itself.</p>\n";

constexpr const char* kCriteria =
    "<p>Accurate: in each frame a volume error of at most 1e-9, no inverted triangle (normal "
    "against the mean of its neighbours') and no growth of energy beyond 5 % while the rig rests "
    "(of others: of the kinetic energy); at the end slower than 0.05 of its size a second and "
    "within 2 % of its size (RMS) of the same method's run with the finest step. Recovered: only "
    "the end is so. Diverged: the solver gave up or nodes flew off, the energy grew tenfold while "
    "the rig rested, or the volume ends off by more than 1 %. Degraded: the rest. Not run: "
    "explicit steps beyond the work that a cell may take. Each cell's tooltip has its "
    "figures.</p>\n<p>Filled cells were run. A cell that is drawn as an outline was not: of every "
    "second row and column all were run, and those at the corners of the blocks that it lies in "
    "and borders on agree; no run cell that touches it says otherwise.</p>\n";

std::string key() {
  std::string html = "<p>";
  for (const Verdict verdict : kVerdicts) {
    html += "<span style=\"background:" + std::string(colour_of(verdict)) +
            ";color:#fff;padding:2px 8px;margin-right:8px\">" + verdict_name(verdict) + "</span>";
  }
  return html + "</p>\n";
}

Table mechanisms() {
  Table table{"", "Mechanisms", "", {"", "criterion", "why", "what Thew does"}, {}};
  for (int k = 2; k <= static_cast<int>(Mechanism::kVolumeSoft); ++k) {
    const MechanismText& text = mechanism_text(static_cast<Mechanism>(k));
    table.rows.push_back({text.sign, text.name, text.why, text.thew});
  }
  return table;
}

}  // namespace

std::string maps_html(const std::string& scene, const std::vector<StabilityMap>& maps,
                      double cpu_minutes) {
  std::string html = kIntroduction + key() + kCriteria;
  html += html_of(mechanisms()) + html_of(verdicts_of(maps));
  const Table regions = regions_of(maps);
  for (size_t first = 0; first < maps.size();) {
    const std::string& method = maps[first].method;
    html += "<h2>" + escape_html(method) + "</h2>\n<p class=\"soft\">" +
            escape_html(maps[first].what) + "</p>\n<div class=\"maps\">\n";
    for (; first < maps.size() && maps[first].method == method; ++first) {
      html += draw_map(maps[first]);
    }
    Table own = regions;
    own.title = method + ": where it fails";
    std::erase_if(own.rows, [&](const auto& row) { return row[0] != method; });
    for (auto& row : own.rows) row.erase(row.begin());
    own.head.erase(own.head.begin());
    html += "</div>\n" + (own.rows.empty() ? "" : html_of(own));
  }
  html += "<p class=\"soft\">" + number(cpu_minutes, 2) + " CPU minutes.</p>\n";
  return html_page(scene + ": where methods fail",
                   "main { max-width: 1320px; } td, th { white-space: normal; } "
                   ".maps { display: flex; flex-wrap: wrap; gap: 18px; } "
                   ".maps svg { height: auto; max-width: 100%; }",
                   html);
}

}  // namespace thew::tools
