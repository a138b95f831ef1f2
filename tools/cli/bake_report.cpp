// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/bake_report.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <map>

#include "tools/cli/bake_warnings.h"

namespace thew::tools {
namespace {

double largest(const std::vector<double>& values) {
  return values.empty() ? 0.0 : *std::max_element(values.begin(), values.end());
}

Report::Solver solver_of(const Scene& scene, const BakeResult& result) {
  Report::Solver solver = {scene.solver.integrator,
                           scene.solver.volume,
                           scene.solver.substeps,
                           "set by the scene",
                           {},
                           0.0,
                           0.0};
  if (result.plan) {
    solver.substeps = result.plan->fidelity.substeps;
    solver.chosen_because = "the scene gives a tolerance; what each muscle got is below";
    solver.plan = result.plan;
    solver.tolerance_m = scene.solver.tolerance->position;
    solver.plan_seconds = result.seconds.plan.wall;
  }
  return solver;
}

Report::Muscle muscle_of(const Model& model, size_t m, const BakeResult& result) {
  const Muscle& muscle = model.muscles[m];
  Report::Muscle row;
  row.name = muscle.name;
  row.vertices = static_cast<int>(muscle.rest.vertices.size());
  row.triangles = static_cast<int>(muscle.rest.triangles.size());
  row.rest_volume_m3 = muscle.rest_volume;
  row.zones = muscle.zones.count();
  for (const FrameMeasures& frame : result.measures) {
    const MuscleMeasures& at = frame.muscles[m];
    row.volume_error_written.push_back(at.volume_error_written);
    row.length_m.push_back(at.length);
    row.belly_area_ratio.push_back(at.area_ratio);
    row.max_volume_error = std::max(row.max_volume_error, at.volume_error);
    row.max_substep_volume_error = std::max(row.max_substep_volume_error, at.substep_volume_error);
    row.max_attachment_gap_m = std::max(row.max_attachment_gap_m, at.attachment_gap);
    row.max_zone_error = std::max(row.max_zone_error, at.zone_error);
  }
  row.max_volume_error_written = largest(row.volume_error_written);
  return row;
}

// By muscle, the rungs from the least on, and their causes.
std::vector<Report::Rung> rungs_of(const Model& model, const std::vector<int>& frames,
                                   const BakeResult& result) {
  std::vector<Report::Rung> rows;
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    std::map<std::pair<Rung, Cause>, Report::Rung> taken;
    for (size_t f = 0; f < result.measures.size() && f < frames.size(); ++f) {
      const MuscleMeasures& at = result.measures[f].muscles[m];
      if (at.rung == Rung::kNone) continue;
      Report::Rung& row = taken[{at.rung, at.cause}];
      row.frames.push_back(frames[f]);
      row.max_penetration_m = std::max(row.max_penetration_m, at.penetration);
    }
    for (auto& [what, row] : taken) {
      row.muscle = model.muscles[m].name;
      row.rung = kRungs[static_cast<int>(what.first)];
      row.because = cause_text(what.second).effect;
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

// The largest of the whole bake, in the first frame that has it: of what is written, where that is
// another figure.
std::vector<Report::Worst> worst_of(const Model& model, const std::vector<int>& frames,
                                    const BakeResult& result, bool skin_keeps_volume) {
  std::vector<Report::Worst> all;
  for (const char* quantity :
       {"volume_error", "substep_volume_error", "attachment_gap", "penetration", "poke_through"}) {
    all.push_back({quantity, 0.0, frames.empty() ? 0 : frames.front(), ""});
  }
  for (size_t f = 0; f < result.measures.size() && f < frames.size(); ++f) {
    const FrameMeasures& at = result.measures[f];
    const auto raise = [&](size_t quantity, double value, const std::string& part) {
      Report::Worst& most = all[quantity];
      if (value > most.measured) most.measured = value, most.frame = frames[f], most.part = part;
    };
    for (size_t m = 0; m < model.muscles.size(); ++m) {
      const std::string& name = model.muscles[m].name;
      raise(0, at.muscles[m].volume_error_written, name);
      raise(1, at.muscles[m].substep_volume_error, name);
      raise(2, at.muscles[m].attachment_gap, name);
      raise(3, at.muscles[m].penetration, name);
    }
    if (skin_keeps_volume) raise(0, at.skin_volume_error_written, "skin");
    raise(3, at.skin.max_penetration, "skin");
    raise(4, at.skin.max_poke_through, "skin");
  }
  return all;
}

double measured(const std::string& quantity, const Report& report) {
  return std::find_if(report.worst.begin(), report.worst.end(),
                      [&](const Report::Worst& most) { return most.quantity == quantity; })
      ->measured;
}

// Now, or when SOURCE_DATE_EPOCH says: ISO 8601, UTC.
std::string date() {
  const char* given = std::getenv("SOURCE_DATE_EPOCH");
  const std::time_t now = given ? std::strtoll(given, nullptr, 10) : std::time(nullptr);
  std::tm utc{};
  char text[64];
  if (!gmtime_r(&now, &utc) || !std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc)) {
    return "unknown";
  }
  return text;
}

std::string host() {
  char name[256] = {};
  return gethostname(name, sizeof name - 1) == 0 ? name : "unknown";
}

Report::Origin origin_of(const Scene& scene, const Model& model, const CommandOptions& options) {
  return {std::filesystem::absolute(scene.file).lexically_normal().string(),
          model.hash,
          options.command,
          options.commit,
          date(),
          host(),
          "none",
          options.directory};
}

}  // namespace

Report make_report(const Scene& scene, const Model& model, const CommandOptions& options,
                   const std::vector<int>& frames, const BakeResult& result) {
  Report report;
  report.scene = scene.name;
  report.fps = scene.fps;
  report.frames = frames;
  report.threads = result.threads;
  report.hash = result.hash;
  report.double_precision = scene.output.double_precision;
  report.origin = origin_of(scene, model, options);
  report.solver = solver_of(scene, result);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    report.muscles.push_back(muscle_of(model, m, result));
  }
  report.rungs = rungs_of(model, frames, result);
  report.swings = swings_of(model, frames, result.measures);
  std::vector<double> volume_error, written;  // of a skin layer
  report.skin.triangles = static_cast<int>(model.skin.surface.triangles.size());
  for (const FrameMeasures& frame : result.measures) {
    report.skin.penetration_m.push_back(frame.skin.max_penetration);
    report.skin.poke_through_m.push_back(frame.skin.max_poke_through);
    if (model.skinned) {
      report.skin.max_covered_penetration_m = std::max(
          report.skin.max_covered_penetration_m.value_or(0.0), frame.skin.max_covered_penetration);
    }
    if (model.has_skin && !model.skinned) {
      volume_error.push_back(frame.skin.volume_error);
      written.push_back(frame.skin_volume_error_written);
    }
    report.contact.max_penetration_m =
        std::max(report.contact.max_penetration_m, frame.contact_penetration);
    report.contact.intersecting_triangle_pairs.push_back(frame.intersecting_pairs);
  }
  if (!volume_error.empty()) report.skin.max_volume_error = largest(volume_error);
  report.skin.max_volume_error_written = largest(written);
  report.skin.keeps_volume =
      report.skin.max_volume_error.has_value() && model.skin.settings.keeps_volume;
  report.skin.max_penetration_m = largest(report.skin.penetration_m);
  report.skin.max_poke_through_m = largest(report.skin.poke_through_m);
  report.worst = worst_of(model, frames, result, report.skin.keeps_volume);
  for (const Bound& bound : scene.bounds) {
    report.bounds.push_back({bound.quantity, measured(bound.quantity, report), bound.limit});
  }
  report.warnings = bake_warnings(model, frames, result, BakeReader(options.out / "bake.h5"));
  return report;
}

std::vector<std::string> files_beside_report(const std::filesystem::path& folder,
                                             const std::vector<SceneView>& views) {
  std::vector<std::string> files = {"report.json", "bake.h5"};
  if (views.empty()) return files;
  files.push_back("frames/");
  for (const SceneView& view : views) {
    const std::string movie = "frames/" + view.name + ".mp4";
    if (std::filesystem::exists(folder / movie)) files.push_back(movie);
  }
  return files;
}

}  // namespace thew::tools
