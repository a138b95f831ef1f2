// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/cache/version.h"
#include "sim/fidelity/planner.h"
#include "sim/stage_clock.h"

namespace thew::tools {

/// What is said of a bake: report.json holds it for programs, report.html for people.
struct Report {
  std::string thew = kVersion;
  std::string scene;
  double fps = 24.0;
  std::vector<int> frames;
  int threads = 1;
  std::string hash;

  struct Solver {
    std::string integrator, volume;
    int substeps = 1;
    std::string chosen_because = {};
    std::optional<FidelityPlan> plan = {};  ///< where the scene gives a tolerance
    double tolerance_m = 0.0, plan_seconds = 0.0;
  } solver;

  struct Muscle {
    std::string name;
    int vertices = 0, triangles = 0;
    double rest_volume_m3 = 0.0;
    double max_volume_error = 0.0, max_substep_volume_error = 0.0;  ///< |V - V0| / V0, as solved
    double max_volume_error_written = 0.0;                          ///< of the cache's positions
    int zones = 0;                ///< 0: one multiplier for the whole
    double max_zone_error = 0.0;  ///< of any zone, over its own volume at rest
    double max_attachment_gap_m = 0.0;
    std::vector<double> length_m, belly_area_ratio,
        volume_error_written;  ///< by frame; the last for the chart
  };
  std::vector<Muscle> muscles;

  struct Skin {
    int triangles = 0;  ///< 0: no skin
    double max_penetration_m = 0.0,
           max_poke_through_m = 0.0;                    ///< into flesh; flesh out of the skin
    std::vector<double> penetration_m, poke_through_m;  ///< by frame, for the chart
    std::optional<double> max_covered_penetration_m;    ///< of a character's own skin
    std::optional<double> max_volume_error;             ///< |V - V0| / V0, of a layer, as solved
    double max_volume_error_written = 0.0;
    bool keeps_volume = false;  ///< [skin] volume = "exact"
  } skin;

  struct Contact {
    double max_penetration_m = 0.0;
    std::vector<int> intersecting_triangle_pairs;  ///< by frame
  } contact;

  /// What stood in for a muscle's solve, in frames of one rung and one cause.
  struct Rung {
    std::string muscle;
    std::vector<int> frames;
    std::string rung, because;
    double max_penetration_m = 0.0;  ///< of the muscle, in these frames
  };
  std::vector<Rung> rungs;

  /// Frames solved by themselves in which a pinched muscle found no rest.
  struct Swing {
    std::string muscle;
    std::vector<int> frames;
    std::vector<double> swing_m;  ///< by frame: what an iteration still moves a node by
    std::size_t worst() const;    ///< place of the largest
  };
  std::vector<Swing> swings;

  /// The stages make up the total. Pictures are drawn beside the others: `render` is, on the wall,
  /// what the bake had to wait for them, and of the processors all that they took.
  struct Seconds {
    sim::Seconds total, setup, settle, measure, report, rig, muscles, contact, skin, write, render;
  } seconds;

  /// Where all this comes from. None of it is in the cache, whose bytes depend on the scene alone.
  struct Origin {
    std::string scene, scene_hash, command, commit, date, host, renderer, directory = {};
  } origin;
  /// What lies beside the report, by paths relative to it.
  std::vector<std::string> files;

  /// The largest of a quantity that a bound can limit, and where it was: a muscle, or "skin".
  struct Worst {
    std::string quantity;
    double measured = 0.0;  ///< m, or relative where the quantity is an error
    int frame = 0;
    std::string part;  ///< "": it is 0 everywhere
  };
  std::vector<Worst> worst;
  std::vector<int> pictured;  ///< frames of the contact sheet's thumbnails
  int sheet_columns = 1;

  struct Bound {
    std::string quantity;
    double measured = 0.0, limit = 0.0;
    bool met() const { return measured <= limit; }
  };
  bool double_precision = false;  ///< of the cache
  std::vector<Bound> bounds;      ///< on what is written
  std::vector<std::string> warnings;
};

/// A figure of a quantity that a bound can limit, as people read it: lengths in mm.
std::string quantity_text(const std::string& quantity, double value);

/// What report.json holds. A number that is not finite is Error(kOutput) naming it.
std::string report_as_json(const Report& report);
/// One file that needs no other: text, drawings, what report_viewer() made ("" for none), and the
/// picture at `contact_sheet` (a PNG; "" for none).
std::string report_as_html(const Report& report, const std::filesystem::path& contact_sheet,
                           const std::string& viewer = "");

/// FOLDER/report.json and FOLDER/report.html, durably.
void write_report(const std::filesystem::path& folder, const Report& report,
                  const std::filesystem::path& contact_sheet, const std::string& viewer = "");

}  // namespace thew::tools
