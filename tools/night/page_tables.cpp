// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <map>

#include "tools/base/html_page.h"
#include "tools/base/svg_chart.h"
#include "tools/base/text.h"
#include "tools/night/page_pieces.h"

namespace thew::tools {
namespace {

std::string shot_row(const Page& page, const NightShot& shot) {
  std::vector<Cell> cells = {text_cell(page.link(shot)), text_cell(html_badge(shot.state)),
                             number_cell(shot.frames, std::to_string(shot.frames))};
  if (shot.frames != shot.wanted_frames) {
    cells.back().html += "<small> of " + std::to_string(shot.wanted_frames) + "</small>";
  }
  for (const std::string& quantity : page.quantities) {
    const Report::Bound* bound = shot.bound(quantity);
    const Report::Worst* worst = shot.worst_of(quantity);
    if (!bound && !worst) {
      cells.push_back(no_cell());
      continue;
    }
    const double value = bound ? bound->measured : worst->measured;
    const bool is_ratio = quantity.find("error") != std::string::npos;
    cells.push_back(number_cell(value, readable(is_ratio ? value : 1e3 * value),
                                bound && !bound->met() ? "worse" : ""));
  }
  if (!shot.has_report()) {
    cells.resize(cells.size() + 5, no_cell());
  } else {
    const int rungs = shot.rung_frames();
    cells.push_back(number_cell(rungs, std::to_string(rungs)));
    cells.push_back(count_cell(shot.warnings.size()));
    cells.push_back(number_cell(shot.total.wall, duration_text(shot.total.wall)));
    cells.push_back(number_cell(shot.total.cpu, duration_text(shot.total.cpu)));
    const double a_frame = shot.frames > 0 ? shot.total.cpu / shot.frames : 0.0;
    cells.push_back(number_cell(a_frame, readable(a_frame)));
  }
  if (page.night.compared) {
    std::string what;
    for (const ShotChange& one : shot.changes) what += (what.empty() ? "" : ", ") + one.what;
    cells.push_back(text_cell(escape_html(what)));
  }
  return html_row(cells);
}

std::string without_numbers(const std::string& text) {
  std::string kind;
  for (const char c : text) {
    const bool is_digit = std::isdigit(static_cast<unsigned char>(c)) != 0;
    if (!is_digit) kind += c;
    if (is_digit && !kind.ends_with('#')) kind += '#';
  }
  return kind;
}

}  // namespace

std::string bounds_part(const Page& page) {
  std::string summary, missed;
  std::size_t misses = 0;
  std::vector<std::pair<double, std::string>> rows;
  for (const std::string& quantity : page.quantities) {
    std::size_t bound = 0, over = 0;
    const NightShot* worst = nullptr;
    double worst_ratio = -1.0;
    for (const NightShot& shot : page.night.shots) {
      const Report::Bound* one = shot.bound(quantity);
      if (!one) continue;
      ++bound;
      const double ratio = one->limit > 0.0    ? one->measured / one->limit
                           : one->measured > 0 ? 1e9
                                               : 0.0;
      if (ratio > worst_ratio) worst = &shot, worst_ratio = ratio;
      if (one->met()) continue;
      ++over;
      const Report::Worst* at = shot.worst_of(quantity);
      rows.emplace_back(
          ratio,
          html_row({text_cell(page.link(shot)), text_cell(in_words(quantity)),
                    number_cell(one->measured, quantity_text(quantity, one->measured), "worse"),
                    number_cell(one->limit, quantity_text(quantity, one->limit)),
                    number_cell(ratio, ratio < 1e9 ? readable(ratio) : "–"),
                    at ? number_cell(at->frame, std::to_string(at->frame)) : no_cell(),
                    text_cell(at ? escape_html(in_words(at->part)) : "–")}));
    }
    if (!worst) continue;
    const Report::Bound* one = worst->bound(quantity);
    summary += html_row({text_cell(escape_html(in_words(quantity))), count_cell(bound),
                         count_cell(over, over ? "worse" : "better"),
                         number_cell(worst_ratio, quantity_text(quantity, one->measured)),
                         number_cell(one->limit, quantity_text(quantity, one->limit)),
                         text_cell(page.link(*worst))});
    misses += over;
  }
  if (summary.empty()) return "<h2>Bounds</h2>\n<p>No scene sets a quality bound.</p>\n";
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  for (const auto& [unused, html] : rows) missed += html;
  std::string html =
      "<h2>Bounds</h2>\n" +
      html_table({{"Bound", true}, {"Bakes"}, {"Missed"}, {"Worst"}, {"Allowed"}, {"In", true}},
                 summary);
  if (misses > 0) {
    html += html_fold(misses <= kOpen, counted(static_cast<long>(misses), "bound") + " not met",
                      html_table({{"Bake", true},
                                  {"Bound", true},
                                  {"Is"},
                                  {"Allowed"},
                                  {"Times"},
                                  {"Frame"},
                                  {"Where", true}},
                                 missed));
  }
  return html;
}

std::string rungs_part(const Page& page) {
  struct Kind {
    std::size_t bakes = 0, frames = 0;
    double deepest = 0.0;
    const NightShot* most = nullptr;
    std::size_t most_frames = 0;
  };
  std::map<std::array<std::string, 3>, Kind> kinds;
  for (const NightShot& shot : page.night.shots) {
    for (const Report::Rung& rung : shot.rungs) {
      Kind& kind = kinds[{rung.rung, rung.muscle, rung.because}];
      ++kind.bakes;
      kind.frames += rung.frames.size();
      kind.deepest = std::max(kind.deepest, rung.max_penetration_m);
      if (!kind.most || rung.frames.size() > kind.most_frames) {
        kind.most = &shot;
        kind.most_frames = rung.frames.size();
      }
    }
  }
  if (kinds.empty()) return "";
  std::string rows;
  for (const auto& [key, kind] : kinds) {
    rows += html_row({text_cell(escape_html(in_words(key[1]))), text_cell(in_words(key[0])),
                      count_cell(kind.bakes), count_cell(kind.frames),
                      number_cell(kind.deepest, readable(1e3 * kind.deepest) + " mm"),
                      text_cell(page.link(*kind.most)), text_cell(escape_html(key[2]), "long")});
  }
  return "<h2>Rungs</h2>\n<p>What stood in where a muscle could not be solved as elsewhere.</p>\n" +
         html_table({{"Muscle", true},
                     {"Rung", true},
                     {"Bakes"},
                     {"Frames"},
                     {"Deepest"},
                     {"Most of them in", true},
                     {"Because", true}},
                    rows);
}

std::string swings_part(const Page& page) {
  struct Kind {
    std::size_t bakes = 0, frames = 0;
    double most = 0.0;  // m
    const NightShot* shot = nullptr;
    int frame = 0;
  };
  std::map<std::string, Kind> kinds;
  for (const NightShot& shot : page.night.shots) {
    for (const Report::Swing& swing : shot.swings) {
      Kind& kind = kinds[swing.muscle];
      ++kind.bakes;
      kind.frames += swing.frames.size();
      const std::size_t worst = swing.worst();
      if (kind.shot && swing.swing_m[worst] <= kind.most) continue;
      kind.most = swing.swing_m[worst];
      kind.shot = &shot;
      kind.frame = swing.frames[worst];
    }
  }
  if (kinds.empty()) return "";
  std::string rows;
  for (const auto& [muscle, kind] : kinds) {
    rows += html_row(
        {text_cell(escape_html(in_words(muscle))), count_cell(kind.bakes), count_cell(kind.frames),
         number_cell(kind.most, readable(1e3 * kind.most) + " mm"),
         text_cell(page.link(*kind.shot)), number_cell(kind.frame, std::to_string(kind.frame))});
  }
  return "<h2>Pinched muscles</h2>\n<p>What found no rest in frames that are solved by "
         "themselves.</p>\n" +
         html_table(
             {{"Muscle", true}, {"Bakes"}, {"Frames"}, {"Swing"}, {"Most in", true}, {"Frame"}},
             rows);
}

std::string cost_part(const Page& page) {
  NightShot sum;
  for (const NightShot& shot : page.night.shots) {
    sum.total += shot.total;
    for (std::size_t i = 0; i < kStages.size(); ++i) sum.stages[i] += shot.stages[i];
  }
  if (sum.total.wall <= 0.0) return "";
  std::string rows;
  for (std::size_t i = 0; i < kStages.size(); ++i) {
    const sim::Seconds& stage = sum.stages[i];
    const double share = sum.total.cpu > 0.0 ? 100.0 * stage.cpu / sum.total.cpu : 0.0;
    const std::string bar =
        "<i class=\"bar\" style=\"width:" + readable(std::clamp(share, 0.0, 100.0)) + "px\"></i>";
    rows += html_row({text_cell(kStages[i]), number_cell(stage.cpu, duration_text(stage.cpu)),
                      number_cell(share, readable(share, 2) + " %"), text_cell(bar),
                      number_cell(stage.wall, duration_text(stage.wall))});
  }
  return "<h2>Time and cost by stage</h2>\n<p>" + duration_text(sum.total.cpu) +
         " of processors in all, which is what a farm bills; one bake after the other they would "
         "take " +
         duration_text(sum.total.wall) + ".</p>\n" +
         html_table({{"Stage", true}, {"Processor time"}, {"Share"}, {"", true}, {"Time"}}, rows);
}

std::string shots_part(const Page& page) {
  std::vector<Head> heads = {{"Bake", true}, {"State", true}, {"Frames"}};
  for (const std::string& quantity : page.quantities) {
    const bool is_ratio = quantity.find("error") != std::string::npos;
    heads.push_back({in_words(quantity) + (is_ratio ? "" : "<br>mm")});
  }
  for (const char* head :
       {"Rungs<br>frames", "Warnings", "Time", "Processor<br>time", "Processor<br>s a frame"}) {
    heads.push_back({head});
  }
  if (page.night.compared) heads.push_back({"Changes", true});
  std::string rows;
  for (const NightShot& shot : page.night.shots) rows += shot_row(page, shot);
  std::string states;
  for (std::size_t i = 0; i < kShotStates.size(); ++i) {
    const auto state = static_cast<ShotState>(i);
    if (page.night.count(state) > 0) states += "<option>" + state_text(state) + "</option>";
  }
  return "<h2>All bakes</h2>\n<p class=\"tools\" hidden><input type=\"search\" id=\"find\" "
         "placeholder=\"Part of a name\" aria-label=\"Part of a name\"> <select id=\"state\" "
         "aria-label=\"State\"><option value=\"\">any state</option>" +
         states + "</select> <span class=\"soft\" id=\"shown\"></span></p>\n" +
         html_table(heads, rows, " id=\"bakes\"");
}

// By what they say, whatever the numbers in them.
std::string warnings_part(const Page& page) {
  struct Kind {
    std::string example;
    std::vector<const NightShot*> bakes;
  };
  std::map<std::string, Kind> kinds;
  for (const NightShot& shot : page.night.shots) {
    for (const std::string& warning : shot.warnings) {
      Kind& kind = kinds[without_numbers(warning)];
      if (kind.example.empty()) kind.example = warning;
      if (kind.bakes.empty() || kind.bakes.back() != &shot) kind.bakes.push_back(&shot);
    }
  }
  if (kinds.empty()) return "";
  std::vector<const Kind*> order;
  for (const auto& [unused, kind] : kinds) order.push_back(&kind);
  std::stable_sort(order.begin(), order.end(),
                   [](const Kind* a, const Kind* b) { return a->bakes.size() > b->bakes.size(); });
  std::string html = "<h2>Warnings</h2>\n";
  for (const Kind* kind : order) {
    std::string names;
    for (const NightShot* shot : kind->bakes)
      names += (names.empty() ? "" : ", ") + page.link(*shot);
    const std::size_t count = kind->bakes.size();
    html += html_fold(
        false,
        "<b>" + counted(static_cast<long>(count), "bake") + "</b> " + escape_html(kind->example),
        "<p>" + names + "</p>\n");
  }
  return html;
}

}  // namespace thew::tools
