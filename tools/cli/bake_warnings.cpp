// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/bake_warnings.h"

#include <algorithm>
#include <cstdio>

#include "sim/lone_frame.h"
#include "sim/solver/character_rig.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "skin/depth.h"
#include "tools/base/text.h"

namespace thew::tools {
namespace {

constexpr double kShows = 5e-3;  // m, of a muscle outside its character's skin

// Empty where all lie under the skin, or stand out by less than shows.
std::string flesh_outside(const Model& model, const std::vector<int>& frames,
                          const BakeResult& result, const BakeReader& reader) {
  const auto& measures = result.measures;
  const auto worst =
      std::max_element(measures.begin(), measures.end(), [](const auto& a, const auto& b) {
        return a.skin.max_poke_through < b.skin.max_poke_through;
      });
  if (!model.skinned || worst == measures.end() || worst->skin.max_poke_through <= kShows ||
      measures.size() != frames.size()) {
    return "";
  }
  const auto at = worst - measures.begin();
  const BakeFrame frame = reader.read(static_cast<int>(at));
  const std::vector<BakeMesh>& meshes = reader.info().meshes;
  const Surface& surface = model.skinned->surface;
  Points skin;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (meshes[m].kind == BakeMesh::Kind::kSkin) skin = to_points(frame.positions[m]);
  }
  const Bvh bvh = build_bvh(surface, skin);
  double most = -1.0;
  std::string which;
  for (size_t m = 0; m < meshes.size(); ++m) {
    if (meshes[m].kind != BakeMesh::Kind::kMuscle) continue;
    const double outside = farthest_outside(surface, bvh, skin, to_points(frame.positions[m]));
    if (outside > most) most = outside, which = meshes[m].name;
  }
  char line[120];
  std::snprintf(line, sizeof line, " stands out of the character's skin by %.1f mm in frame %d, ",
                1e3 * worst->skin.max_poke_through, frames[at]);
  return "muscle \"" + which + "\"" + line +
         "farther than any elsewhere; thinner muscles, or another place of their paths, keep them "
         "in";
}

}  // namespace

std::vector<std::string> joints_out_of_place(const Model& model, const std::vector<int>& frames) {
  constexpr double kOff = 5e-3, kShare = 0.02;
  struct Joint {
    int above, below;  // bodies
    Vec3 place;        // m, in `above`, at rest
    double off = 0.0;
    int frame = 0;
  };
  if (!model.character || !is_animated(model)) return {};
  State state = initial_state(model);
  std::vector<Joint> joints;
  const auto add = [&](int above, int below) {
    if (above < 0) return;
    joints.push_back({above, below, state.pose[above].inverse() * state.pose[below].translation()});
  };
  for (const Forearm& forearm : model.character->forearms) {
    const int humerus = bone_above(model, forearm.body);
    add(humerus, forearm.ulna);
    if (humerus >= 0) add(bone_above(model, humerus), humerus);
    for (const Bone& bone : model.bones) {
      // A hand: its bones hang on the forearm, with no other bone between.
      int b = model.skeleton.parent[bone.body];
      while (b >= 0 && b != forearm.body) b = model.skeleton.parent[b];
      if (b == forearm.body && bone_above(model, bone.body) == humerus) {
        add(forearm.radius, bone.body);
      }
    }
  }
  for (const int frame : frames) {
    drive_bones(model, (frame - model.first_frame) / model.fps, state);
    for (Joint& joint : joints) {
      const Vec3 now = state.pose[joint.above].inverse() * state.pose[joint.below].translation();
      const double off = (now - joint.place).norm();
      if (off > joint.off) joint.off = off, joint.frame = frame;
    }
  }
  std::vector<std::string> lines;
  for (const Joint& joint : joints) {
    if (joint.off <= std::min(kOff, kShare * joint.place.norm())) continue;
    char line[120];
    std::snprintf(line, sizeof line, " is out of joint by %.1f mm in frame %d; ", 1e3 * joint.off,
                  joint.frame);
    const std::vector<std::string>& names = model.skeleton.body_names;
    lines.push_back("\"" + names[joint.below] + "\" on \"" + names[joint.above] + "\"" + line +
                    "the motion's joints lie elsewhere than the character's, and muscles across it "
                    "are drawn out");
  }
  return lines;
}

std::string skin_too_full(const Model& model, const std::vector<int>& frames,
                          const std::vector<FrameMeasures>& measures) {
  constexpr double kHeld = 1e-9;
  const auto worst = std::max_element(
      measures.begin(), measures.end(),
      [](const auto& a, const auto& b) { return a.skin.volume_error < b.skin.volume_error; });
  if (!model.has_skin || !model.skin.settings.keeps_volume || worst == measures.end() ||
      worst->skin.volume_error <= kHeld || measures.size() != frames.size()) {
    return "";
  }
  char line[160];
  std::snprintf(line, sizeof line,
                "skin: %.2g of its volume off in frame %d, where what is below leaves no room; "
                "more fat over it at rest gives some",
                worst->skin.volume_error, frames[worst - measures.begin()]);
  return line;
}

std::vector<Report::Swing> swings_of(const Model& model, const std::vector<int>& frames,
                                     const std::vector<FrameMeasures>& measures) {
  std::vector<Report::Swing> rows;
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    Report::Swing row{model.muscles[m].name, {}, {}};
    for (size_t f = 0; f < measures.size() && f < frames.size(); ++f) {
      const double swing = measures[f].muscles[m].swing;
      if (swing <= 0.0) continue;
      row.frames.push_back(frames[f]);
      row.swing_m.push_back(swing);
    }
    if (!row.frames.empty()) rows.push_back(std::move(row));
  }
  return rows;
}

std::vector<std::string> swinging_muscles(const std::vector<Report::Swing>& swings) {
  std::vector<std::string> lines;
  for (const Report::Swing& swing : swings) {
    const std::size_t worst = swing.worst();
    lines.push_back("muscle \"" + swing.muscle + "\" is pinched and finds no rest in frames " +
                    frame_list(swing.frames) + ": its nodes swing by up to " +
                    readable(1e3 * swing.swing_m[worst], 2) + " mm (frame " +
                    std::to_string(swing.frames[worst]) +
                    "); more room between the bodies that pinch it gives it rest");
  }
  return lines;
}

std::vector<std::string> rungs_that_pop(const Model& model, const std::vector<int>& frames,
                                        const std::vector<FrameMeasures>& measures) {
  constexpr int kNamed = 6;
  std::vector<std::string> lines;
  if (!stands_alone(model)) return lines;  // a rung is blended in and out
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    const auto is_on = [&](size_t f) { return measures[f].muscles[m].rung > Rung::kSubsteps; };
    std::string pops;
    int count = 0;
    for (size_t f = 0; f + 1 < measures.size() && f + 1 < frames.size(); ++f) {
      if (frames[f + 1] != frames[f] + 1 || is_on(f) == is_on(f + 1) || ++count > kNamed) continue;
      pops += (pops.empty() ? "" : ", ") + std::to_string(frames[f]) + " to " +
              std::to_string(frames[f + 1]);
    }
    if (count == 0) continue;
    if (count > kNamed) pops += ", and " + std::to_string(count - kNamed) + " times more";
    lines.push_back("muscle \"" + model.muscles[m].name +
                    "\" is on a rung in some frames and not in those beside them, each solved by "
                    "itself, so that it may pop from frame " +
                    pops + "; the report has them under rungs");
  }
  return lines;
}

std::string muscles_on_rungs(const BakeResult& result) {
  size_t frames = 0, all = 0;
  for (const FrameMeasures& frame : result.measures) {
    all += frame.muscles.size();
    for (const MuscleMeasures& muscle : frame.muscles) frames += muscle.rung > Rung::kSubsteps;
  }
  std::string line;
  if (frames > 0) {
    line = std::to_string(frames) + " of " + std::to_string(all) +
           " frames of a muscle could not be solved: contact let a pair pass, or the muscle was "
           "its carried shape; the report has them under rungs";
  }
  if (result.settled.rungs > 0) {
    line +=
        (line.empty() ? "" : "; ") + std::to_string(result.settled.rungs) + " more while settling";
  }
  return line;
}

std::string not_at_rest(const Model& model, const BakeResult& result) {
  constexpr double kSeen = 10.0;  // times what counts as rest, 0.04 mm a frame: less shows nowhere
  const Settled& settled = result.settled;
  if (model.settle <= 0.0 || result.resumed_frames > 0 || settled.converged ||
      settled.speed < kSeen * model.lengths.settled_speed) {
    return "";
  }
  char line[200];
  std::snprintf(line, sizeof line,
                "the settle phase ended after %.2f s with nodes at %.2g m/s; raise scene.settle",
                settled.seconds, settled.speed);
  return line;
}

std::vector<std::string> bake_warnings(const Model& model, const std::vector<int>& frames,
                                       const BakeResult& result, const BakeReader& reader) {
  std::vector<std::string> warnings = model.warnings;
  if (result.plan) {
    for (const std::string& what : result.plan->raised) {
      warnings.push_back("solver.tolerance: " + what);
    }
  }
  for (std::string& line : joints_out_of_place(model, frames)) warnings.push_back(std::move(line));
  char line[200];
  for (const std::string& warning : {not_at_rest(model, result), muscles_on_rungs(result),
                                     flesh_outside(model, frames, result, reader),
                                     skin_too_full(model, frames, result.measures)}) {
    if (!warning.empty()) warnings.push_back(warning);
  }
  for (const auto& lines : {swinging_muscles(swings_of(model, frames, result.measures)),
                            rungs_that_pop(model, frames, result.measures)}) {
    warnings.insert(warnings.end(), lines.begin(), lines.end());
  }
  int unreached = 0, fallbacks = 0, zones = 0;
  for (const FrameMeasures& frame : result.measures) {
    unreached += frame.unreached;
    fallbacks += frame.weight_fallbacks;
    zones += frame.zone_fallbacks;
  }
  if (unreached > 0) {
    warnings.push_back("the volume could not be reached in " + std::to_string(unreached) +
                       " steps");
  }
  if (fallbacks > 0) {
    warnings.push_back("even weights stood in for the authored ones in " +
                       std::to_string(fallbacks) + " iterations");
  }
  if (zones > 0) {
    warnings.push_back("the volume as a whole, not that of each zone, was held in " +
                       std::to_string(zones) + " iterations");
  }
  return warnings;
}

}  // namespace thew::tools
