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

constexpr int kSections = 24;  // across a belly, for its mean area

// Area (m^2) of the section through `point` across `tangent`, over the triangles whose nodes lie
// within `reach` (m) of `along` on the rest curve: half the sum of crossings' cross products,
// closed or not.
double section_area(const Muscle& muscle, const Points& x, double along, double reach,
                    const Vec3& point, const Vec3& tangent) {
  double area = 0.0;
  for (const Triangle& t : muscle.rest.triangles) {
    double height[3];
    bool near = true;
    for (int k = 0; k < 3; ++k) {
      near = near && std::abs(muscle.shape.along[t[k]] - along) < reach;
      height[k] = tangent.dot(to_vec(x[t[k]]) - point);
    }
    if (!near) continue;
    Vec3 in = Vec3::Zero(), out = Vec3::Zero();
    int crossings = 0;
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((height[k] < 0.0) == (height[next] < 0.0)) continue;
      const double s = height[k] / (height[k] - height[next]);
      const Vec3 p = (1.0 - s) * to_vec(x[t[k]]) + s * to_vec(x[t[next]]) - point;
      (height[k] < 0.0 ? in : out) = p;
      ++crossings;
    }
    if (crossings == 2) area += 0.5 * tangent.dot(out.cross(in));
  }
  return std::abs(area);
}

bool has_free_node(const Muscle& muscle, int triangle) {
  const Triangle& t = muscle.rest.triangles[triangle];
  return !muscle.driven[t[0]] || !muscle.driven[t[1]] || !muscle.driven[t[2]];
}

Points free_nodes(const Muscle& muscle, const Points& x) {
  Points free;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!muscle.driven[i]) free.push_back(x[i]);
  }
  return free;
}

double attachment_gap(const Muscle& muscle, const State& state, const Points& x) {
  double gap = 0.0;
  if (!muscle.shape.fixed_to.empty()) return gap;
  for (const PathPoint* end :
       {&muscle.shape.path.points.front(), &muscle.shape.path.points.back()}) {
    const Vec3 anchor = state.pose[end->body] * end->position;
    const bool origin = end == &muscle.shape.path.points.front();
    // The node that is nearest to this end of the path at rest is taken for the attached one.
    double best = 1e30, distance = 0.0;
    for (size_t i = 0; i < x.size(); ++i) {
      const double s = muscle.shape.along[i];
      const double from_end =
          (origin ? s : muscle.shape.rest_path_length - s) + muscle.shape.offset[i].norm();
      if (from_end < best) {
        best = from_end;
        distance = (to_vec(x[i]) - anchor).norm();
      }
    }
    gap = std::max(gap, distance - best);
  }
  return std::max(gap, 0.0);
}

}  // namespace

double section_area_at(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u) {
  const auto& belly = muscle.shape.belly;
  const double length = belly[1] - belly[0], along = belly[0] + u * length;
  Vec3 point, tangent;
  curve_at(muscle.shape, pose, along, point, tangent);
  return section_area(muscle, x, along, std::max(0.35 * length, muscle.shape.lengths.section_reach),
                      point, tangent);
}

double mean_belly_area(const Muscle& muscle, const CarriedPose& pose, const Points& x) {
  if (!muscle.shape.fixed_to.empty()) return 1.0;  // no path, no sections
  double sum = 0.0;
  for (int k = 0; k < kSections; ++k) {
    sum += section_area_at(muscle, pose, x, (k + 0.5) / kSections);
  }
  return sum / kSections;
}

std::vector<double> rest_belly_areas(const Model& model, const State& initial) {
  std::vector<double> areas;
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    areas.push_back(
        mean_belly_area(model.muscles[m], initial.muscles[m].pose, initial.muscles[m].x));
  }
  return areas;
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

FrameMeasures measure(const Model& model, const std::vector<double>& rest_areas, Parallel& parallel,
                      State& state) {
  FrameMeasures out;
  const int count = state.count();
  out.muscles.resize(count);
  refit_all(model, parallel, state);
  const std::vector<Collider> colliders = colliders_of(model, state);
  std::vector<double> deepest(count, 0.0), outside(count, 0.0);
  std::vector<int> pairs(count, 0);
  const Surface& skin = model.skinned ? model.skinned->surface : model.skin.surface;
  if (model.has_skin) refit_bvh(skin, state.skin.x, state.skin.bvh);
  parallel.each(count, [&](int m) {
    const Muscle& muscle = model.muscles[m];
    const MuscleState& now = state.muscles[m];
    MuscleMeasures& measures = out.muscles[m];
    measures.volume_error =
        std::abs(enclosed_volume(now.x, muscle.rest.triangles) / muscle.rest_volume - 1.0);
    measures.substep_volume_error = now.substep_volume_error;
    measures.zone_error = zone_error(muscle, now);
    measures.length = now.pose.path_length;
    const double area = mean_belly_area(muscle, now.pose, now.x);
    measures.area_ratio = rest_areas[m] > 0.0 ? area / rest_areas[m]
                                              : 1.0;  // 0 where the path runs outside the surface
    measures.attachment_gap = attachment_gap(muscle, state, now.x);
    measures.rung = now.ladder.frame_rung;
    measures.cause = now.ladder.cause;
    if (model.skinned) outside[m] = farthest_outside(skin, state.skin.bvh, state.skin.x, now.x);
    if (!model.contact.enabled) return;
    const Points free = free_nodes(muscle, now.x);
    for (size_t other = 0; other < colliders.size(); ++other) {
      if (model.ignore[m][other]) continue;
      const Collider& them = colliders[other];
      if (static_cast<int>(other) != m) {
        deepest[m] = std::max(deepest[m], deepest_inside(*them.surface, *them.bvh, *them.x, free));
      }
      if (static_cast<int>(other) < m) continue;  // each pair once
      const auto crossing = crossing_triangles(*colliders[m].surface, now.bvh, now.x, *them.surface,
                                               *them.bvh, *them.x);
      for (const auto& [mine, theirs] : crossing) {
        const bool other_free =
            static_cast<int>(other) < count && has_free_node(model.muscles[other], theirs);
        pairs[m] +=
            has_free_node(muscle, mine) || other_free;  // a pair of tendons meets where both attach
      }
    }
  });
  for (int m = 0; m < count; ++m) {
    out.muscles[m].penetration = deepest[m];
    out.contact_penetration = std::max(out.contact_penetration, deepest[m]);
    out.intersecting_pairs += pairs[m];
    out.unreached += state.muscles[m].unreached;
    out.weight_fallbacks += state.muscles[m].weight_fallbacks;
    out.zone_fallbacks += state.muscles[m].zone_fallbacks;
  }
  if (model.skinned) {
    out.skin.max_penetration = deepest_inside(muscles_of(model, state), state.skin.x);
    for (const double depth : outside) {  // negative or 0 where no muscle is outside
      out.skin.max_poke_through = std::max(out.skin.max_poke_through, depth);
    }
  } else if (model.has_skin) {
    out.skin = measure_skin(model.skin, colliders, state.skin);
  }
  return out;
}

double written_volume_error(const BakeMesh& mesh, const std::vector<Vec3>& positions,
                            bool double_precision) {
  TriMesh now{positions, mesh.rest.triangles};
  if (!double_precision) {
    for (Vec3& p : now.vertices) p = p.unaryExpr(&as_float);
  }
  return std::abs(enclosed_volume(now) / enclosed_volume(mesh.rest) - 1.0);
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
    number("length/" + names[m], muscle.length);
    number("area_ratio/" + names[m], muscle.area_ratio);
    number("attachment_gap/" + names[m], muscle.attachment_gap);
    number("penetration/" + names[m], muscle.penetration);
    whole("rung/" + names[m], muscle.rung);
    whole("rung_because/" + names[m], muscle.cause);
  }
  number("skin_penetration", measures.skin.max_penetration);
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
