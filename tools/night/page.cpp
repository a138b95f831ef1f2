// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/version.h"
#include "tools/base/html_page.h"
#include "tools/base/signals.h"
#include "tools/base/text.h"
#include "tools/night/page_pieces.h"

namespace thew::tools {

// night.css, night.js
extern const char *const kNightCss, *const kNightJs;

namespace {

constexpr std::size_t kPictures = 24;  // so that the page stays small

std::string verdict(const Night& night) {
  const auto all = static_cast<long>(night.shots.size());
  if (night.is_good()) {
    return "<p class=\"verdict good\"><b>" +
           (all == 1 ? "The bake is" : "All " + counted(all, "bake") + " are") +
           " done and within the bounds.</b></p>\n";
  }
  std::string html = "<p class=\"verdict bad\"><b>" +
                     std::to_string(all - night.count(ShotState::kDone)) + " of " +
                     counted(all, "bake") + " need a look:</b> ";
  bool first = true;
  for (const ShotState state : {ShotState::kFailed, ShotState::kUnreadable, ShotState::kMissing,
                                ShotState::kUnfinished, ShotState::kMissed}) {
    const int count = night.count(state);
    if (count == 0) continue;
    html += (first ? "" : ", ") + std::to_string(count) + " " + state_text(state);
    first = false;
  }
  return html + ".</p>\n";
}

std::string fact(const std::string& name, const std::string& value, const std::string& more) {
  return "<div><dt>" + name + "</dt><dd>" + value + " <small>" + more + "</small></dd></div>\n";
}

std::string facts(const Night& night) {
  sim::Seconds total;
  long frames = 0, rungs = 0, bakes = 0;
  for (const NightShot& shot : night.shots) {
    total += shot.total;
    frames += shot.frames;
    rungs += shot.rung_frames();
    bakes += shot.has_report();
  }
  return "<dl>\n" +
         fact("Bakes", std::to_string(night.shots.size()),
              std::to_string(night.count(ShotState::kDone)) + " done") +
         fact("Frames", std::to_string(frames), "completed") +
         fact("Cost", readable(total.cpu / 3600.0) + " CPU h",
              frames ? readable(total.cpu / static_cast<double>(frames)) + " s a frame" : "") +
         fact("Time", duration_text(total.wall),
              bakes ? duration_text(total.wall / static_cast<double>(bakes)) + " a bake" : "") +
         fact("Rungs", std::to_string(rungs), "frames of muscles") + "</dl>\n";
}

std::string faults(const Page& page) {
  std::string html, commands;
  std::size_t count = 0;
  for (const NightShot& shot : page.night.shots) {
    if (shot.state == ShotState::kDone || shot.state == ShotState::kMissed) continue;
    ++count;
    html += "<li><h3>" + page.link(shot) + " " + html_badge(shot.state) + "</h3>\n<p>" +
            escape_html(shot.why) + "</p>\n";
    if (shot.again.empty()) {
      html += "<p class=\"soft\">Nothing here says by which command it is baked.</p>";
    } else {
      html += "<pre>" + escape_html(shot.again) + "</pre>";
      commands += escape_html(shot.again) + "\n";
    }
    html += "</li>\n";
  }
  if (count == 0) return "";
  html = "<ul class=\"faults\">\n" + html + "</ul>\n";
  if (count > 1 && !commands.empty()) {
    html += html_fold(false, "The commands as one script", "<pre>" + commands + "</pre>\n");
  }
  return "<h2>To run again</h2>\n" + html;
}

std::string changes(const Page& page) {
  const Night& night = page.night;
  if (!night.compared) return "";
  std::string rows[3][2];  // by way; first what became of bakes, then their figures
  std::size_t counts[3] = {}, other_scene = 0, other_positions = 0, is_new = 0;
  for (const NightShot& shot : night.shots) {
    bool scene = false;
    for (const ShotChange& one : shot.changes) {
      scene = scene || one.what == "scene";
      if (one.what == "new") {
        ++is_new;
      } else if (one.what == "scene") {
        ++other_scene;
      } else if (one.what == "positions") {
        other_positions += !scene;
      } else {
        const auto way = static_cast<std::size_t>(one.way);
        static constexpr const char* kLooks[] = {"worse", "better", ""};
        const std::string is =
            "<span class=\"" + std::string(kLooks[way]) + "\">" + escape_html(one.is) + "</span>";
        rows[way][one.what != "state"] +=
            html_row({text_cell(page.link(shot)), text_cell(escape_html(one.what)),
                      text_cell(escape_html(one.was) + " → " + is)});
        ++counts[way];
      }
    }
  }
  std::string html =
      "<h2>Since the last run" + (night.against.empty() ? "" : ", " + escape_html(night.against)) +
      "</h2>\n<p>" + std::to_string(counts[0]) + " for the worse, " + std::to_string(counts[1]) +
      " for the better, " + std::to_string(counts[2]) + " others. " + counted(is_new, "bake") +
      " new, " + counted(other_scene, "bake") + " of another scene, " +
      counted(other_positions, "bake") + " with other positions of the same scene.</p>\n";
  if (!night.gone.empty()) {
    std::string names;
    for (const std::string& name : night.gone) names += (names.empty() ? "" : ", ") + name;
    html += "<p>Gone: " + escape_html(names) + ".</p>\n";
  }
  std::string all;
  for (const auto& [states, figures] : rows) all += states + figures;
  return html +
         (all.empty() ? "" : html_table({{"Bake", true}, {"What", true}, {"Was → is", true}}, all));
}

std::string gallery(const Page& page) {
  const std::vector<WorstFrame> worst = worst_frames(page.night, kPictures);
  if (worst.empty()) return "";
  std::string html = "<h2>Worst frames</h2>\n<div class=\"gallery\">\n";
  for (const WorstFrame& one : worst) {
    stop_if_interrupted();
    const std::string picture = thumbnail(one);
    html += html_figure(picture.empty() ? "<div class=\"blank\">no picture</div>\n" : picture,
                        "<b>" + page.link(*one.shot) + "</b><br>" + escape_html(one.what));
  }
  return html + "</div>\n";
}

}  // namespace

std::string night_as_html(const Night& night, const std::filesystem::path& folder) {
  const Page page{night, std::filesystem::absolute(folder).lexically_normal(),
                  quantities_of(night)};
  const std::string name = escape_html(night.name), days = escape_html(night.days());
  return html_page(
      name + " – bakes", kNightCss,
      "<h1>" + name + "</h1>\n<p class=\"soft\">" +
          counted(static_cast<long>(night.shots.size()), "bake") + " of muscles and skin" +
          (days.empty() ? "" : ", " + days) + "</p>\n" + verdict(night) + facts(night) +
          faults(page) + changes(page) + bounds_part(page) + gallery(page) + rungs_part(page) +
          swings_part(page) + cost_part(page) + shots_part(page) + warnings_part(page) +
          "<footer>Thew " + sim::kVersion +
          ". The same for programs: thew report --json FILE. Each bake's own page is linked by its "
          "name. SI units unless stated.</footer>\n",
      kNightJs);
}

}  // namespace thew::tools
