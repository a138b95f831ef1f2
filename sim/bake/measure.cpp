// SPDX-License-Identifier: Apache-2.0
#include "sim/bake/measure.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "muscles/volume.h"
#include "sim/solver/contacts.h"
#include "sim/solver/drive.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "skin/depth.h"

namespace thew::sim {
namespace {

bool has_free_node(const Muscle& muscle, int triangle) {
  const Triangle& t = muscle.rest.triangles[triangle];
  return !muscle.driven[t[0]] || !muscle.driven[t[1]] || !muscle.driven[t[2]];
}

using Attachment = Measuring::Attachment;
using Meeting = Measuring::Meeting;

std::array<Attachment, 2> find_attachments(const Muscle& muscle) {
  std::array<Attachment, 2> ends;
  for (const bool origin : {true, false}) {
    Attachment& end = ends[origin ? 0 : 1];
    end.away = 1e30;
    for (size_t i = 0; i < muscle.shape.along.size(); ++i) {
      const double s = muscle.shape.along[i];
      const double away =
          (origin ? s : muscle.shape.rest_path_length - s) + muscle.shape.offset[i].norm();
      if (away < end.away) end = {static_cast<int>(i), away};
    }
  }
  return ends;
}

double attachment_gap(const Muscle& muscle, const std::array<Attachment, 2>& ends,
                      const State& state, const Points& x) {
  double gap = 0.0;
  if (!muscle.shape.fixed_to.empty()) return gap;
  const PathPoint* points[] = {&muscle.shape.path.points.front(), &muscle.shape.path.points.back()};
  for (int k = 0; k < 2; ++k) {
    const Vec3 anchor = state.pose[points[k]->body] * points[k]->position;
    gap = std::max(gap, (to_vec(x[ends[k].node]) - anchor).norm() - ends[k].away);
  }
  return gap;
}

const Surface& skin_surface(const Model& model) {
  return model.skinned ? model.skinned->surface : model.skin.surface;
}

}  // namespace

namespace {

// All pairs that are measured, those of the skin first, since they take longest. Of the skin itself
// its layer is measured, and of a character's own skin the muscles alone.
std::vector<Meeting> find_meetings(const Model& model) {
  std::vector<Meeting> meetings;
  const int muscles = static_cast<int>(model.muscles.size()), skin = model.colliders();
  const auto add = [&](int one, int other) {
    Meeting& meeting = meetings.emplace_back();
    meeting.one = one;
    meeting.other = other;
  };
  if (model.has_skin && !model.skinned) add(skin, skin);
  for (int c = 0; model.has_skin && c < skin; ++c) {
    const bool is_bone = c >= muscles && c < below_skin(model);
    if (!is_bone || !model.skinned) add(skin, c);
  }
  for (int m = 0; model.contact.enabled && m < muscles; ++m) {
    for (int other = m; other < model.colliders(); ++other) {
      if (!model.ignore[m][other]) add(m, other);
    }
  }
  return meetings;
}

}  // namespace

Measuring start_measuring(const Model& model, const State& initial) {
  Measuring out;
  out.meetings = find_meetings(model);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    const Muscle& muscle = model.muscles[m];
    out.rest_areas.push_back(
        mean_belly_area(muscle, initial.muscles[m].pose, initial.muscles[m].x));
    out.attachments.push_back(find_attachments(muscle));
  }
  for (const Collider& it : colliders_of(model, initial)) {
    out.shells.push_back(make_shell(*it.surface, static_cast<int>(it.x->size())));
  }
  if (!model.has_skin) return out;
  out.shells.push_back(make_shell(skin_surface(model), static_cast<int>(initial.skin.x.size())));
  if (model.skinned) {  // vertices at the place of another one have no triangles
    std::erase_if(out.shells.back().loose,
                  [&](int vertex) { return model.skinned->map_back[vertex] != vertex; });
  }
  return out;
}

std::vector<std::string> rest_overlaps(const Model& model) {
  const double reported = model.lengths.reported_overlap;
  std::vector<std::string> lines;
  if (!model.contact.enabled) return lines;
  State state = initial_state(model);
  Parallel one(1);
  refit_all(model, one, state);
  const std::vector<Collider> colliders = colliders_of(model, state);
  double deepest = 0.0;
  Point at = {};
  const auto measure_depth = [&](int m, const Collider& them) {
    for (size_t i = 0; i < state.muscles[m].x.size(); ++i) {
      if (model.muscles[m].driven[i]) continue;
      const Point& x = state.muscles[m].x[i];
      const double depth = deepest_inside(*them.surface, *them.bvh, *them.x, {x});
      if (depth > deepest) deepest = depth, at = x;
    }
  };
  for (int m = 0; m < state.count(); ++m) {
    for (int other = m + 1; other < model.colliders(); ++other) {
      if (model.ignore[m][other]) continue;
      deepest = reported;
      measure_depth(m, colliders[other]);
      if (other < state.count()) measure_depth(other, colliders[m]);
      if (deepest <= reported) continue;
      char text[160];
      std::snprintf(text, sizeof text, "by %.1f mm at (%.4g, %.4g, %.4g)", 1e3 * deepest, at[0],
                    at[1], at[2]);
      lines.push_back("muscle \"" + model.muscles[m].name + "\" and \"" +
                      model.surfaces[other].name + "\" overlap at rest, " + text +
                      "; settling parts them: move one of them, or name both in contact.ignore");
    }
  }
  return lines;
}

namespace {

double zone_error(const Muscle& muscle, const MuscleState& now) {
  if (muscle.zones.count() == 0) return 0.0;
  std::vector<double> wanted, found;
  zone_targets(muscle, now.target, wanted);
  volumes_before(muscle.zones, now.x, muscle.rest.triangles, found);
  return zone_error(muscle.zones, found, wanted);
}

}  // namespace

namespace {

// All that is measured of one muscle alone.
MuscleMeasures measure_muscle(const Model& model, const Measuring& measuring, int m,
                              const State& state) {
  const Muscle& muscle = model.muscles[m];
  const MuscleState& now = state.muscles[m];
  MuscleMeasures measures;
  measures.volume_error =
      std::abs(enclosed_volume(now.x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
  measures.substep_volume_error = now.substep_volume_error;
  measures.zone_error = zone_error(muscle, now);
  measures.activation = now.activation;
  measures.length = now.pose.path_length;
  const double area = mean_belly_area(muscle, now.pose, now.x), rest = measuring.rest_areas[m];
  if (rest > 0.0) measures.area_ratio = area / rest;  // 0 where the path runs outside the surface
  measures.attachment_gap = attachment_gap(muscle, measuring.attachments[m], state, now.x);
  if (state.way && has_forces(now.level) && now.residual > model.lengths.converged_motion) {
    measures.swing = now.residual;
  }
  measures.rung = now.ladder.frame_rung;
  measures.cause = now.ladder.cause;
  return measures;
}

// All bodies in their places: muscles, bones, the skin.
std::vector<PlacedShell> place_shells(const Model& model, const Measuring& measuring,
                                      const State& state) {
  std::vector<PlacedShell> placed;
  for (const Collider& it : colliders_of(model, state)) {
    placed.push_back({it.surface, it.bvh, it.x, &measuring.shells[placed.size()]});
  }
  if (model.has_skin) {
    placed.push_back({&skin_surface(model), &state.skin.bvh, &state.skin.x,
                      &measuring.shells.back(), model.skinned ? &measuring.bare : nullptr});
  }
  return placed;
}

// Tells the vertices of a character's skin that are seen from those of them that lie inside other
// skin.
void find_bare(const Model& model, const State& state, Measuring& measuring) {
  if (!model.skinned) return;
  std::vector<Collider> muscles = colliders_of(model, state);
  muscles.resize(state.muscles.size());
  measuring.covered = find_covered(*model.skinned, muscles, state.skin.x, state.skin.bvh);
  measuring.bare = model.skinned->seen;
  for (size_t i = 0; i < measuring.covered.size(); ++i) {
    if (measuring.covered[i]) measuring.bare[i] = 0;
  }
}

void measure_meeting(const Model& model, const Measuring& measuring, const SkinState& skin,
                     const std::vector<PlacedShell>& placed, Meeting& meeting) {
  PlacedShell one = placed[meeting.one], other = placed[meeting.other];
  meeting.crossings = 0;
  if (meeting.one == model.colliders() && meeting.other == meeting.one &&
      same_bytes(skin.crossings_at, skin.x)) {
    meeting.crossings = static_cast<int>(skin.crossings.size());
    return;
  }
  find_near_crossings(*one.surface, *one.bvh, *one.x, *other.surface, *other.bvh, *other.x,
                      meeting.near);
  const int muscles = static_cast<int>(model.muscles.size());
  const bool is_skin = meeting.one == model.colliders(), itself = meeting.one == meeting.other;
  const auto is_free = [&](int body, int triangle) {
    return body < muscles && has_free_node(model.muscles[body], triangle);
  };
  for (const auto& pair : meeting.near) {
    if (is_skin && !itself) break;  // that skin and flesh cross is told by the depths
    // A pair of tendons meets where both attach.
    const bool counts = is_skin || is_free(meeting.one, pair[0]) || is_free(meeting.other, pair[1]);
    meeting.crossings +=
        counts && are_crossing(*one.surface, *one.x, *other.surface, *other.x, pair);
  }
  if (itself) return;
  if (is_skin && meeting.other < below_skin(model)) {
    meeting.outside = farthest_outside(other, one, meeting.near, 1);
  } else if (!is_skin) {
    one.counted = &model.muscles[meeting.one].free_nodes;
    if (meeting.other < muscles) {
      other.counted = &model.muscles[meeting.other].free_nodes;
      meeting.depth_of_other = deepest_inside(other, one, meeting.near, 1);
    }
  }
  meeting.depth_of_one = deepest_inside(one, other, meeting.near, 0);
  meeting.depth_of_covered = 0.0;
  if (!is_skin || measuring.covered.empty()) return;
  one.counted = &measuring.covered;
  meeting.depth_of_covered = deepest_inside(one, other, meeting.near, 0);
}

void add_meeting(const Model& model, const Meeting& meeting, FrameMeasures& out) {
  const auto raise = [](double& value, double by) { value = std::max(value, by); };
  if (meeting.one == model.colliders()) {
    raise(out.skin.max_penetration, meeting.depth_of_one);
    raise(out.skin.max_covered_penetration, meeting.depth_of_covered);
    raise(out.skin.max_poke_through, meeting.outside);
    out.skin.intersecting_pairs += meeting.crossings;
    return;
  }
  raise(out.muscles[meeting.one].penetration, meeting.depth_of_one);
  if (meeting.other < static_cast<int>(out.muscles.size())) {
    raise(out.muscles[meeting.other].penetration, meeting.depth_of_other);
  }
  out.intersecting_pairs += meeting.crossings;
}

}  // namespace

FrameMeasures measure(const Model& model, Measuring& measuring, Parallel& parallel, State& state) {
  FrameMeasures out;
  const int count = state.count();
  out.muscles.resize(count);
  refit_all(model, parallel, state);
  if (model.has_skin) fit_tree(skin_surface(model), state.skin);
  find_bare(model, state, measuring);
  const std::vector<PlacedShell> placed = place_shells(model, measuring, state);
  const int meetings = static_cast<int>(measuring.meetings.size());
  parallel.each(meetings + count, [&](int i) {
    if (i < meetings) {
      measure_meeting(model, measuring, state.skin, placed, measuring.meetings[i]);
    } else {
      out.muscles[i - meetings] = measure_muscle(model, measuring, i - meetings, state);
    }
  });
  for (const Meeting& meeting : measuring.meetings) add_meeting(model, meeting, out);
  for (int m = 0; m < count; ++m) {
    out.contact_penetration = std::max(out.contact_penetration, out.muscles[m].penetration);
    out.unreached += state.muscles[m].unreached;
    out.weight_fallbacks += state.muscles[m].weight_fallbacks;
    out.zone_fallbacks += state.muscles[m].zone_fallbacks;
  }
  if (model.has_skin && !model.skinned) {
    const double volume = enclosed_volume(state.skin.x, model.skin.surface.triangles);
    out.skin.volume_error = std::abs(volume - model.skin.volume) / model.skin.volume;
  }
  return out;
}

double written_volume_error(const BakeMesh& mesh, const std::vector<Vec3>& positions,
                            bool double_precision) {
  std::vector<Vec3> now = positions;
  if (!double_precision) {
    for (Vec3& p : now) p = p.unaryExpr(&as_float);
  }
  return std::abs(enclosed_volume(now, mesh.rest.triangles) / enclosed_volume(mesh.rest) - 1.0);
}

void measure_written(const Model& model, const BakeInfo& info,
                     const std::vector<std::vector<Vec3>>& positions, FrameMeasures& measures) {
  for (size_t m = 0; m < info.meshes.size(); ++m) {
    const BakeMesh& mesh = info.meshes[m];
    const bool muscle = mesh.kind == BakeMesh::Kind::kMuscle;
    const bool layer = mesh.kind == BakeMesh::Kind::kSkin && !model.skinned;
    if (!muscle && !layer) continue;
    (muscle ? measures.muscles[m].volume_error_written : measures.skin_volume_error_written) =
        written_volume_error(mesh, positions[m], info.double_precision);
  }
}

namespace {

// Names and values from one list, so that they cannot differ.
template <typename Visit>
void visit(const std::vector<std::string>& names, FrameMeasures& measures, Visit&& number) {
  const auto whole = [&](const std::string& name, auto& value) {
    double real = static_cast<double>(value);
    number(name, real);
    value = static_cast<std::decay_t<decltype(value)>>(static_cast<int>(real));
  };
  for (size_t m = 0; m < names.size(); ++m) {
    MuscleMeasures& muscle = measures.muscles[m];
    number("volume_error/" + names[m], muscle.volume_error);
    number("volume_error_written/" + names[m], muscle.volume_error_written);
    number("substep_volume_error/" + names[m], muscle.substep_volume_error);
    number("zone_error/" + names[m], muscle.zone_error);
    number("activation/" + names[m], muscle.activation);
    number("length/" + names[m], muscle.length);
    number("area_ratio/" + names[m], muscle.area_ratio);
    number("attachment_gap/" + names[m], muscle.attachment_gap);
    number("penetration/" + names[m], muscle.penetration);
    number("swing/" + names[m], muscle.swing);
    whole("rung/" + names[m], muscle.rung);
    whole("rung_because/" + names[m], muscle.cause);
  }
  number("skin_penetration", measures.skin.max_penetration);
  number("skin_covered_penetration", measures.skin.max_covered_penetration);
  number("skin_poke_through", measures.skin.max_poke_through);
  whole("skin_intersecting_pairs", measures.skin.intersecting_pairs);
  number("skin_volume_error", measures.skin.volume_error);
  number("skin_volume_error_written", measures.skin_volume_error_written);
  number("contact_penetration", measures.contact_penetration);
  whole("intersecting_pairs", measures.intersecting_pairs);
  whole("unreached", measures.unreached);
  whole("weight_fallbacks", measures.weight_fallbacks);
  whole("zone_fallbacks", measures.zone_fallbacks);
}

}  // namespace

std::vector<std::string> measure_names(const Model& model) {
  std::vector<std::string> muscles, names;
  for (const Muscle& muscle : model.muscles) muscles.push_back(muscle.name);
  FrameMeasures measures;
  measures.muscles.resize(muscles.size());
  visit(muscles, measures, [&](const std::string& name, double&) { names.push_back(name); });
  return names;
}

std::vector<double> flatten(const FrameMeasures& measures) {
  std::vector<double> numbers;
  FrameMeasures copy = measures;
  visit(std::vector<std::string>(copy.muscles.size()), copy,
        [&](const std::string&, double& value) { numbers.push_back(value); });
  return numbers;
}

FrameMeasures unflatten(const Model& model, const std::vector<std::string>& names,
                        const std::vector<double>& numbers) {
  std::map<std::string, double> by_name;
  for (size_t i = 0; i < std::min(names.size(), numbers.size()); ++i)
    by_name[names[i]] = numbers[i];
  std::vector<std::string> muscles;
  for (const Muscle& muscle : model.muscles) muscles.push_back(muscle.name);
  FrameMeasures measures;
  measures.muscles.resize(muscles.size());
  visit(muscles, measures, [&](const std::string& name, double& value) {
    const auto found = by_name.find(name);
    if (found == by_name.end()) {
      throw Error(ErrorCode::kInput, "the bake does not have " + name +
                                         ", which this version of Thew measures; bake it anew");
    }
    value = found->second;
  });
  for (const MuscleMeasures& muscle : measures.muscles) {
    if (muscle.rung < Rung::kNone || muscle.rung > Rung::kCarried || muscle.cause < Cause::kNone ||
        muscle.cause > Cause::kJump) {
      throw Error(ErrorCode::kInput,
                  "the bake has a rung that no version of Thew takes; bake it anew");
    }
  }
  return measures;
}

}  // namespace thew::sim
