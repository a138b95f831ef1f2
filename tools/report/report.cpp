// SPDX-License-Identifier: Apache-2.0
#include "tools/report/report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rig/types.h"
#include "sim/cache/durable_file.h"
#include "tools/base/printing.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

ordered_json muscle_as_json(const Report::Muscle& muscle) {
  ordered_json out = {{"name", muscle.name},
                      {"vertices", muscle.vertices},
                      {"triangles", muscle.triangles},
                      {"rest_volume_m3", muscle.rest_volume_m3},
                      {"max_volume_error", muscle.max_volume_error},
                      {"max_volume_error_written", muscle.max_volume_error_written},
                      {"max_substep_volume_error", muscle.max_substep_volume_error},
                      {"max_attachment_gap_m", muscle.max_attachment_gap_m},
                      {"length_m", muscle.length_m},
                      {"belly_area_ratio", muscle.belly_area_ratio}};
  if (muscle.zones > 0)
    out.update({{"zones", muscle.zones}, {"max_zone_error", muscle.max_zone_error}});
  return out;
}

double saved(double work, double uniform) { return uniform > 0.0 ? 1.0 - work / uniform : 0.0; }

ordered_json chosen_as_json(const ChosenMuscle& muscle) {
  return {{"level", level_name(muscle.level)},
          {"iterations", muscle.iterations},
          {"chosen_because", muscle.reason},
          {"error_probed_m", muscle.probed_error},
          {"error_checked_m", muscle.checked_error},
          {"error_refined_m", muscle.refined_error},
          {"work_per_frame", muscle.work},
          {"work_saved", saved(muscle.work, muscle.uniform_work)}};
}

ordered_json plan_as_json(const FidelityPlan& plan, double tolerance, double seconds) {
  return {{"tolerance_m", tolerance},
          {"frames_probed", plan.probed},
          {"frames_checked", plan.checked},
          {"uniform_substeps", plan.uniform_substeps},
          {"uniform_iterations", plan.uniform_iterations},
          {"uniform_keeps_it", plan.uniform_keeps},
          {"work_per_frame", plan.work},
          {"uniform_work_per_frame", plan.uniform_work},
          {"work_saved", saved(plan.work, plan.uniform_work)},
          {"probe_work", plan.probe_work},
          {"probe_seconds", seconds},
          {"raised", plan.raised}};
}

ordered_json origin_as_json(const Report::Origin& from) {
  return {{"scene", from.scene},       {"scene_hash", from.scene_hash},
          {"command", from.command},   {"commit", from.commit},
          {"date", from.date},         {"host", from.host},
          {"renderer", from.renderer}, {"directory", from.directory}};
}

ordered_json seconds_as_json(const Report::Seconds& s, double sim::Seconds::*clock) {
  return {{"total", s.total.*clock},     {"setup", s.setup.*clock},     {"settle", s.settle.*clock},
          {"measure", s.measure.*clock}, {"report", s.report.*clock},   {"rig", s.rig.*clock},
          {"muscles", s.muscles.*clock}, {"contact", s.contact.*clock}, {"skin", s.skin.*clock},
          {"write", s.write.*clock},     {"render", s.render.*clock}};
}

ordered_json worst_as_json(const Report& report) {
  ordered_json worst = ordered_json::array();
  for (const Report::Worst& most : report.worst) {
    worst.push_back({{"quantity", most.quantity},
                     {"measured", most.measured},
                     {"frame", most.frame},
                     {"part", most.part}});
  }
  return worst;
}

ordered_json swings_as_json(const Report& report) {
  ordered_json swings = ordered_json::array();
  for (const Report::Swing& swing : report.swings) {
    swings.push_back({{"muscle", swing.muscle},
                      {"frames", swing.frames},
                      {"swing_m", swing.swing_m},
                      {"max_swing_m", swing.swing_m[swing.worst()]}});
  }
  return swings;
}

// JSON has no word for what is not a number; the library would write null in silence.
void check_finite(const ordered_json& value, const std::string& place) {
  if (value.is_number_float() && !std::isfinite(value.get<double>())) {
    throw Error(ErrorCode::kOutput, "report.json: " + place +
                                        " is not finite; see the frame in which it ceased to be, "
                                        "with thew inspect on the bake");
  }
  if (!value.is_structured()) return;
  for (const auto& [key, child] : value.items()) check_finite(child, place + "/" + key);
}

}  // namespace

std::size_t Report::Swing::worst() const {
  return std::max_element(swing_m.begin(), swing_m.end()) - swing_m.begin();
}

std::string report_as_json(const Report& report) {
  ordered_json muscles = ordered_json::array(), bounds = ordered_json::array();
  for (const Report::Muscle& muscle : report.muscles) muscles.push_back(muscle_as_json(muscle));
  for (const Report::Bound& bound : report.bounds) {
    bounds.push_back({{"quantity", bound.quantity},
                      {"measured", bound.measured},
                      {"limit", bound.limit},
                      {"met", bound.met()}});
  }
  ordered_json solver = {{"integrator", report.solver.integrator},
                         {"volume", report.solver.volume},
                         {"substeps", report.solver.substeps},
                         {"chosen_because", report.solver.chosen_because}};
  if (report.solver.plan) {
    solver["fidelity"] =
        plan_as_json(*report.solver.plan, report.solver.tolerance_m, report.solver.plan_seconds);
    for (std::size_t m = 0; m < report.muscles.size(); ++m) {
      muscles[m]["fidelity"] = chosen_as_json(report.solver.plan->muscles[m]);
    }
  }
  ordered_json skin = {{"triangles", report.skin.triangles},
                       {"max_penetration_m", report.skin.max_penetration_m},
                       {"max_poke_through_m", report.skin.max_poke_through_m}};
  if (report.skin.max_covered_penetration_m) {
    skin["max_covered_penetration_m"] = *report.skin.max_covered_penetration_m;
  }
  if (report.skin.max_volume_error) {
    skin["max_volume_error"] = *report.skin.max_volume_error;
    skin["max_volume_error_written"] = report.skin.max_volume_error_written;
  }
  ordered_json rungs = ordered_json::array();
  for (const Report::Rung& rung : report.rungs) {
    rungs.push_back({{"muscle", rung.muscle},
                     {"frames", rung.frames},
                     {"rung", rung.rung},
                     {"because", rung.because},
                     {"max_penetration_m", rung.max_penetration_m}});
  }
  const ordered_json all = {
      {"thew", report.thew},
      {"scene", report.scene},
      {"fps", report.fps},
      {"frames", report.frames},
      {"threads", report.threads},
      {"hash", report.hash},
      {"solver", solver},
      {"muscles", muscles},
      {"skin", skin},
      {"contact",
       {{"max_penetration_m", report.contact.max_penetration_m},
        {"intersecting_triangle_pairs", report.contact.intersecting_triangle_pairs}}},
      {"worst", worst_as_json(report)},
      {"rungs", rungs},
      {"swings", swings_as_json(report)},
      {"origin", origin_as_json(report.origin)},
      {"seconds", seconds_as_json(report.seconds, &sim::Seconds::wall)},
      {"cpu_seconds", seconds_as_json(report.seconds, &sim::Seconds::cpu)},
      {"bounds", bounds},
      {"warnings", report.warnings}};
  check_finite(all, "");
  return json_text(all, 1) + "\n";
}

void write_report(const std::filesystem::path& folder, const Report& report,
                  const std::filesystem::path& contact_sheet, const std::string& viewer) {
  create_folders(folder);
  write_durably(folder / "report.json", report_as_json(report));
  write_durably(folder / "report.html", report_as_html(report, contact_sheet, viewer));
}

}  // namespace thew::tools
