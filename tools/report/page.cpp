// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/cache/durable_file.h"
#include "tools/base/html_page.h"
#include "tools/base/svg_chart.h"
#include "tools/report/report.h"

namespace thew::tools {
namespace {

constexpr std::size_t kLargestPicture = std::size_t{1} << 26;  // bytes
std::string count(std::size_t n, const std::string& thing) {
  return std::to_string(n) + " " + thing + (n == 1 ? "" : "s");
}

std::string with_unit(const Report::Bound& bound, double value) {
  return quantity_text(bound.quantity, value);
}

std::string fact(const std::string& name, const std::string& value, const std::string& more = "") {
  return "<div><dt>" + name + "</dt><dd>" + escape_html(value) +
         (more.empty() ? "" : " <small>" + escape_html(more) + "</small>") + "</dd></div>\n";
}

std::string precision(const Report& report) {
  return report.double_precision ? "float64" : "float32";
}

// What a bound's figure is of, where there are two.
std::string bounded(const std::string& quantity) {
  return in_words(quantity) + (quantity == "volume_error" ? " as written" : "");
}

// " in frame 57 (brachialis)"
std::string place(const Report& report, const std::string& quantity) {
  for (const Report::Worst& most : report.worst) {
    if (most.quantity != quantity || most.part.empty()) continue;
    return " in frame " + std::to_string(most.frame) + " (" + in_words(most.part) + ")";
  }
  return "";
}

std::string verdict(const Report& report) {
  if (report.bounds.empty()) {
    return "<p class=\"verdict none\">The scene sets no quality bounds.</p>\n";
  }
  std::string failed;
  std::size_t failures = 0;
  for (const Report::Bound& bound : report.bounds) {
    if (bound.met()) continue;
    failed += (failures++ ? ", " : "") + bounded(bound.quantity) + " is " +
              with_unit(bound, bound.measured) + place(report, bound.quantity) + ", allowed " +
              with_unit(bound, bound.limit);
  }
  if (failures > 0) {
    return "<p class=\"verdict bad\"><b>" + std::to_string(failures) + " of " +
           count(report.bounds.size(), "bound") + " not met:</b> " + escape_html(failed) +
           ".</p>\n";
  }
  std::string met;
  for (const Report::Bound& bound : report.bounds) {
    met += (met.empty() ? "" : ", ") + bounded(bound.quantity) + " " +
           with_unit(bound, bound.measured) + " of " + with_unit(bound, bound.limit) + " allowed";
  }
  return "<p class=\"verdict good\"><b>All bounds met:</b> " + escape_html(met) + ".</p>\n";
}

std::string frame_range(const std::vector<int>& frames) {
  if (frames.empty()) return "none";
  return std::to_string(frames.front()) + " to " + std::to_string(frames.back());
}

std::string facts(const Report& report) {
  int triangles = 0;
  for (const Report::Muscle& muscle : report.muscles) triangles += muscle.triangles;
  const double frames = std::max<double>(1.0, static_cast<double>(report.frames.size()));
  std::string html = "<dl>\n";
  html += fact("Muscles", std::to_string(report.muscles.size()),
               std::to_string(triangles) + " triangles");
  html += fact("Skin", report.skin.triangles ? std::to_string(report.skin.triangles) : "none",
               report.skin.triangles ? "triangles" : "");
  html += fact("Frames", std::to_string(report.frames.size()),
               frame_range(report.frames) + " at " + readable(report.fps) + " fps");
  html += fact("Solver", report.solver.integrator,
               report.solver.volume + " volume, " + count(report.solver.substeps, "substep"));
  html += fact("Time", readable(report.seconds.total.wall) + " s",
               readable(1e3 * report.seconds.total.wall / frames) + " ms a frame, " +
                   count(report.threads, "thread"));
  html += "</dl>\n";
  if (!report.solver.chosen_because.empty()) {
    html += "<p class=\"soft\">Solver chosen because " + escape_html(report.solver.chosen_because) +
            ".</p>\n";
  }
  return html;
}

std::string picture(const Report& report, const std::filesystem::path& file, bool viewer) {
  if (file.empty()) return "";
  const std::string png = read_whole_file(file, kLargestPicture);
  std::string sheet = html_png("alt=\"Contact sheet of the baked frames\"", png);
  if (viewer && !report.pictured.empty()) {
    sheet = "<div class=\"sheet\">" + sheet + "<div style=\"grid-template-columns: repeat(" +
            std::to_string(report.sheet_columns) + ", 1fr)\">";
    for (const int frame : report.pictured) {
      const std::string number = std::to_string(frame);
      sheet += "<button type=\"button\" data-frame=\"" + number + "\" title=\"frame " + number +
               " in the viewer\"></button>";
    }
    sheet += "</div></div>\n";
  }
  return "<h2>Frames</h2>\n" +
         html_figure(sheet,
                     "Chosen frames in the order of time, the first and the last among them.");
}

// One for each quantity that a bound can limit and that is anywhere more than nothing.
std::string worst_frames(const Report& report) {
  std::string html;
  for (const Report::Worst& most : report.worst) {
    if (most.part.empty()) continue;
    html += " <button type=\"button\" data-frame=\"" + std::to_string(most.frame) + "\">" +
            bounded(most.quantity) + " " +
            escape_html(quantity_text(most.quantity, most.measured)) + " <small>" +
            std::to_string(most.frame) + ", " + escape_html(in_words(most.part)) +
            "</small></button>";
  }
  return html.empty() ? "" : "<p class=\"worst\">Worst frame by" + html + "</p>\n";
}

const Report::Bound* find_bound(const Report& report, const std::string& quantity) {
  const auto found = std::find_if(report.bounds.begin(), report.bounds.end(),
                                  [&](const auto& bound) { return bound.quantity == quantity; });
  return found == report.bounds.end() ? nullptr : &*found;
}

LineChart muscle_chart(const Report& report, const std::string& title, const std::string& unit,
                       std::vector<double> Report::Muscle::*values, double scale) {
  LineChart chart{title, unit, report.frames, {}, false, {}};
  for (const Report::Muscle& muscle : report.muscles) {
    ChartLine line{in_words(muscle.name), muscle.*values};
    if (line.values.size() != report.frames.size()) continue;  // not measured
    for (double& value : line.values) value *= scale;
    chart.lines.push_back(line);
  }
  return chart;
}

std::string time_chart(const std::string& title, const Report::Seconds& s,
                       double sim::Seconds::*clock) {
  return draw_chart(BarChart{title,
                             "s",
                             {{"setup", s.setup.*clock},
                              {"settle", s.settle.*clock},
                              {"rig", s.rig.*clock},
                              {"muscles", s.muscles.*clock},
                              {"contact", s.contact.*clock},
                              {"skin", s.skin.*clock},
                              {"measure", s.measure.*clock},
                              {"write", s.write.*clock},
                              {"render", s.render.*clock},
                              {"report", s.report.*clock}}});
}

std::string charts(const Report& report) {
  LineChart volume = muscle_chart(report, "Volume error as written", "|V − V0| / V0",
                                  &Report::Muscle::volume_error_written, 1.0);
  volume.logarithmic = true;
  if (const auto* bound = find_bound(report, "volume_error")) volume.limit = bound->limit;
  std::string html = "<h2>Frame by frame</h2>\n<div class=\"charts\">\n";
  html += html_figure(
      draw_chart(volume),
      "Deviation of each muscle's volume from its rest volume at the positions that the "
      "cache holds, " +
          precision(report) +
          "; logarithmic, 0 on the floor. The table has the solver's own as well.");
  html += html_figure(draw_chart(muscle_chart(report, "Musculotendon length", "mm",
                                              &Report::Muscle::length_m, 1e3)),
                      "Length of the path from origin to insertion.");
  html += html_figure(draw_chart(muscle_chart(report, "Belly section", "area / rest area",
                                              &Report::Muscle::belly_area_ratio, 1.0)),
                      "Mean section of the belly over that at rest: above 1 the muscle bulges.");
  if (report.skin.triangles > 0 && report.skin.penetration_m.size() == report.frames.size()) {
    LineChart skin{"Skin penetration", "mm", report.frames, {}, false, {}};
    skin.lines.push_back({"deepest", report.skin.penetration_m});
    if (report.skin.poke_through_m.size() == report.frames.size()) {
      skin.lines.push_back({"flesh outside", report.skin.poke_through_m});
    }
    for (auto& line : skin.lines) {
      for (double& value : line.values) value *= 1e3;
    }
    if (const auto* bound = find_bound(report, "penetration")) skin.limit = 1e3 * bound->limit;
    html += html_figure(
        draw_chart(skin),
        "Deepest skin node below the surface of a muscle or bone, and the farthest node of "
        "a muscle or bone outside the skin.");
  }
  const auto& pairs = report.contact.intersecting_triangle_pairs;
  if (pairs.size() == report.frames.size()) {
    LineChart chart{"Intersecting triangles", "pairs", report.frames, {}, false, {}};
    chart.lines.push_back({"muscles, bones", {pairs.begin(), pairs.end()}});
    html += html_figure(
        draw_chart(chart),
        "Pairs of triangles of different muscles and bones that pass through one another.");
  }
  html += html_figure(
      time_chart("Time by stage", report.seconds, &sim::Seconds::wall),
      "Wall-clock time of the whole bake; " + readable(report.seconds.total.wall) + " s in all.");
  html +=
      html_figure(time_chart("Processor time by stage", report.seconds, &sim::Seconds::cpu),
                  "Of all threads together; " + readable(report.seconds.total.cpu) + " s in all.");
  return html + "</div>\n";
}

std::string cell(const std::string& text) { return "<td>" + text + "</td>"; }

std::string row(const Report::Muscle& muscle, std::size_t index, bool zoned) {
  std::string length = "–", section = "–";
  if (!muscle.length_m.empty()) {
    const auto [low, high] = std::minmax_element(muscle.length_m.begin(), muscle.length_m.end());
    length = readable(1e3 * *low) + " – " + readable(1e3 * *high);
  }
  if (!muscle.belly_area_ratio.empty()) {
    section =
        readable(*std::max_element(muscle.belly_area_ratio.begin(), muscle.belly_area_ratio.end()));
  }
  return "<tr>" +
         cell(std::string("<i style=\"background:") + chart_colour(index) + "\"></i>" +
              escape_html(in_words(muscle.name))) +
         cell(std::to_string(muscle.vertices)) + cell(std::to_string(muscle.triangles)) +
         cell(readable(1e6 * muscle.rest_volume_m3, 4)) +
         cell(readable(muscle.max_volume_error_written)) + cell(readable(muscle.max_volume_error)) +
         cell(readable(muscle.max_substep_volume_error)) +
         (zoned ? cell(muscle.zones > 0 ? readable(muscle.max_zone_error) : "–") : "") +
         cell(readable(1e3 * muscle.max_attachment_gap_m)) + cell(length) + cell(section) +
         "</tr>\n";
}

std::string table(const Report& report) {
  const bool zoned = std::any_of(report.muscles.begin(), report.muscles.end(),
                                 [](const Report::Muscle& muscle) { return muscle.zones > 0; });
  std::string html =
      "<h2>Muscles</h2>\n<div class=\"wide\"><table><thead><tr><th>Muscle</th><th>Vertices</th>"
      "<th>Triangles</th><th>Rest volume<br>cm³</th><th>Volume error<br>as written</th>"
      "<th>Volume error<br>as solved</th><th>Volume error<br>in substeps</th>";
  if (zoned) html += "<th>Volume error<br>of a zone</th>";
  html +=
      "<th>Attachment gap<br>mm</th><th>Length<br>mm</th>"
      "<th>Largest section<br>of rest</th></tr></thead><tbody>\n";
  for (std::size_t i = 0; i < report.muscles.size(); ++i) html += row(report.muscles[i], i, zoned);
  return html +
         "</tbody></table></div>\n<p class=\"soft\">Errors and gaps are the largest of all "
         "frames.</p>\n";
}

std::string percent_saved(double work, double uniform) {
  return uniform > 0.0 ? readable(100.0 * (1.0 - work / uniform)) + " %" : "–";
}

std::string fidelity(const Report& report) {
  if (!report.solver.plan) return "";
  const FidelityPlan& plan = *report.solver.plan;
  std::string html =
      "<h2>Fidelity</h2>\n<p>Tolerance " + readable(1e3 * report.solver.tolerance_m) +
      " mm, which the error against the refined step and its own (from half its substeps) share, "
      "measured in " +
      count(plan.probed.size(), "probed frame") + " and " + count(plan.checked.size(), "other") +
      " checked after the choice. It saves " + percent_saved(plan.work, plan.uniform_work) +
      " of the work of all muscles alike (" + count(plan.uniform_substeps, "substep") + " of " +
      count(plan.uniform_iterations, "iteration") +
      (plan.uniform_keeps ? "" : ", which misses it") + "); the probes took " +
      readable(report.solver.plan_seconds) +
      " s.</p>\n<div class=\"wide\"><table><thead><tr><th>Muscle</th><th>Level</th>"
      "<th>Error in probes<br>mm</th><th>Error in checks<br>mm</th><th>Refined "
      "step<br>mm</th><th>Work<br>saved</th>"
      "<th>Because</th></tr></thead><tbody>\n";
  for (std::size_t m = 0; m < plan.muscles.size(); ++m) {
    const ChosenMuscle& chosen = plan.muscles[m];
    std::string level = level_name(chosen.level);
    if (chosen.iterations > 0) level += ", " + count(chosen.iterations, "iteration");
    html += "<tr>" + cell(escape_html(in_words(report.muscles[m].name))) + cell(level) +
            cell(readable(1e3 * chosen.probed_error)) + cell(readable(1e3 * chosen.checked_error)) +
            cell(readable(1e3 * chosen.refined_error)) +
            cell(percent_saved(chosen.work, chosen.uniform_work)) +
            cell(escape_html(chosen.reason)) + "</tr>\n";
  }
  return html +
         "</tbody></table></div>\n<p class=\"soft\">Work is counted: nodes times iterations, and "
         "searches for the closest point of another surface.</p>\n";
}

std::string contacts(const Report& report) {
  const auto& pairs = report.contact.intersecting_triangle_pairs;
  const auto most = std::max_element(pairs.begin(), pairs.end());
  std::string html = "<h2>Contact</h2>\n<p>Muscles and bones: deepest penetration " +
                     readable(1e3 * report.contact.max_penetration_m) + " mm";
  if (most != pairs.end() && pairs.size() == report.frames.size()) {
    html += *most == 0
                ? ", no intersecting triangles in any frame"
                : ", " + count(*most, "pair") + " of intersecting triangles at most (frame " +
                      std::to_string(report.frames[most - pairs.begin()]) + ")";
  }
  html += ".</p>\n";
  if (report.skin.triangles > 0) {
    html += "<p>Skin: deepest penetration " + readable(1e3 * report.skin.max_penetration_m) +
            " mm; muscle or bone stands out of it by " +
            readable(1e3 * report.skin.max_poke_through_m) + " mm at most" +
            (report.skin.max_covered_penetration_m.value_or(0.0) > 0.0
                 ? "; skin that lies inside other skin is " +
                       readable(1e3 * *report.skin.max_covered_penetration_m) + " mm deep in muscle"
                 : "") +
            (report.skin.keeps_volume
                 ? "; volume error at most " + readable(report.skin.max_volume_error_written) +
                       " as written, " + readable(*report.skin.max_volume_error) + " as solved"
                 : "") +
            ".</p>\n";
  }
  return html;
}

std::string rungs(const Report& report) {
  if (report.rungs.empty()) return "";
  std::string html =
      "<h2>Rungs</h2>\n<p>Where a muscle could not be solved as elsewhere: its frame was taken in "
      "smaller steps (substeps), contact let a pair of bodies pass (pair let pass), or it was its "
      "carried shape at its exact volume, blended in and out (carried).</p>\n<div "
      "class=\"wide\"><table><thead><tr><th>Muscle</th><th>Rung</th><th>Frames</th>"
      "<th>Deepest in muscle<br>or bone, mm</th><th>Because</th></tr></thead><tbody>\n";
  for (const Report::Rung& rung : report.rungs) {
    html += "<tr>" + cell(escape_html(in_words(rung.muscle))) + cell(in_words(rung.rung)) +
            cell(frame_list(rung.frames, "–")) + cell(readable(1e3 * rung.max_penetration_m)) +
            cell(escape_html(rung.because)) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string swings(const Report& report) {
  if (report.swings.empty()) return "";
  std::string html =
      "<h2>Pinched muscles</h2>\n<p>Frames in which a muscle between two bodies found no rest: its "
      "nodes swing by so much from iteration to iteration, and by as much the frame may be "
      "off.</p>\n<div class=\"wide\"><table><thead><tr><th>Muscle</th><th>Frames</th>"
      "<th>Swing, mm</th><th>in frame</th></tr></thead><tbody>\n";
  for (const Report::Swing& swing : report.swings) {
    const std::size_t worst = swing.worst();
    html += "<tr>" + cell(escape_html(in_words(swing.muscle))) +
            cell(frame_list(swing.frames, "–")) + cell(readable(1e3 * swing.swing_m[worst])) +
            cell(std::to_string(swing.frames[worst])) + "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string origin(const Report& report) {
  const Report::Origin& from = report.origin;
  std::string html = "<h2>Origin</h2>\n<div class=\"wide\"><table class=\"named\"><tbody>\n";
  const auto line = [&](const char* name, const std::string& value) {
    html += "<tr><th>" + std::string(name) + "</th><td>" + value + "</td></tr>\n";
  };
  line("Scene", "<code>" + escape_html(from.scene) + "</code>");
  line("Hash of the scene", "<code>" + escape_html(from.scene_hash) + "</code>");
  line("Hash of all positions", "<code>" + escape_html(report.hash) + "</code>");
  line("Command", "<code>" + escape_html(from.command) + "</code>");
  line("Program", "Thew " + escape_html(report.thew) + ", commit <code>" +
                      escape_html(from.commit) + "</code>");
  line("Date", escape_html(from.date));
  line("Host", escape_html(from.host));
  line("Renderer", escape_html(from.renderer));
  std::string files;
  for (const std::string& file : report.files) {
    const std::string name = escape_html(file);
    files += (files.empty() ? "" : " · ") + ("<a href=\"" + name + "\">" + name + "</a>");
  }
  if (!files.empty()) line("Files beside this page", files);
  return html + "</tbody></table></div>\n";
}

std::string warnings(const Report& report) {
  if (report.warnings.empty()) return "";
  std::string html = "<h2>Warnings</h2>\n<ul>\n";
  for (const std::string& warning : report.warnings) {
    html += "<li>" + escape_html(warning) + "</li>\n";
  }
  return html + "</ul>\n";
}

}  // namespace

std::string quantity_text(const std::string& quantity, double value) {
  const bool is_ratio = quantity.find("error") != std::string::npos;
  return is_ratio ? readable(value) : readable(1e3 * value) + " mm";
}

std::string report_as_html(const Report& report, const std::filesystem::path& contact_sheet,
                           const std::string& viewer) {
  const std::string name = escape_html(report.scene);
  return html_page(
      name + " – bake report", "",
      "<h1>" + name + "</h1>\n<p class=\"soft\">Bake of muscles and skin</p>\n" + verdict(report) +
          facts(report) + viewer + (viewer.empty() ? "" : worst_frames(report)) +
          picture(report, contact_sheet, !viewer.empty()) + charts(report) + table(report) +
          fidelity(report) + contacts(report) + rungs(report) + swings(report) + warnings(report) +
          origin(report) +
          "<footer>The same numbers for programs: report.json. Volume errors as written are those "
          "of the cache's positions, " +
          precision(report) +
          ", and bounds hold for them; all else is measured in double precision" +
          (report.double_precision ? "" : ", before rounding") +
          ". SI units unless stated.</footer>\n");
}

}  // namespace thew::tools
