// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <string>

#include "sim/cache/durable_file.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "skin/surface/surface.h"
#include "tools/lab/base/measures.h"
#include "tools/lab/base/play.h"
#include "tools/lab/bench/benches.h"
#include "tools/lab/bench/scale_plot.h"

namespace thew::tools {
namespace {

using Json = nlohmann::ordered_json;

void add_skeleton(const Skeleton& one, const Vec3& shift, const std::string& mark, Skeleton& all) {
  const int by = all.size();
  for (int b = 0; b < one.size(); ++b) {
    const bool is_root = one.parent[b] < 0;
    all.body_names.push_back(one.body_names[b] + mark);
    all.parent.push_back(is_root ? 0 : one.parent[b] + by);
    all.joint_in_parent.push_back(one.joint_in_parent[b]);
    if (is_root) all.joint_in_parent.back().pretranslate(shift);
    all.joint_names.push_back(one.joint_names[b] + mark);
    all.joint_types.push_back(one.joint_types[b]);
    all.joint_axes.push_back(one.joint_axes[b]);
    all.lower.push_back(one.lower[b]);
    all.upper.push_back(one.upper[b]);
    all.visuals.emplace_back();
  }
}

// CPU seconds of one search without memory, as near a bone as a node that touches it.
double price_of_query(const Model& model, const State& state) {
  const Surface& bone = model.surfaces[model.muscles.size()].surface;
  const BoneState& now = state.bones.front();
  const Points& from = now.x;
  constexpr int kRounds = 20;  // searches from each node, some milliseconds together
  double sum = 0.0;
  const double begin = cpu_seconds();
  for (int r = 0; r < kRounds; ++r) {
    for (const Point& p : from) {
      const Vec3 near = to_vec(p) + 2e-3 * Vec3(1.0, 0.1 * r, -0.5);
      sum += closest_point(bone, now.bvh, now.x, near, 0.01).distance;
    }
  }
  const double each = (cpu_seconds() - begin) / (kRounds * static_cast<double>(from.size()));
  return std::isfinite(sum) ? each : 0.0;
}

// The definition `count` times in a row, `apart` (m) along z, in one scene; without its skin.
ModelDef copies_of(const ModelDef& one, int count, double apart) {
  ModelDef all = one;
  all.skin.mesh = {};
  for (int k = 1; k < count; ++k) {
    const Vec3 shift(0.0, 0.0, k * apart);
    const int by = all.skeleton.size();
    const std::string mark = "#" + std::to_string(k);
    add_skeleton(one.skeleton, shift, mark, all.skeleton);
    for (size_t j = 0; j < one.clip.joints.size(); ++j) {
      all.clip.joints.push_back(one.clip.joints[j] + mark);
      for (size_t key = 0; key < all.clip.values.size(); ++key) {
        all.clip.values[key].push_back(one.clip.values[key][j]);
      }
    }
    for (MuscleDef muscle : one.muscles) {
      muscle.name += mark;
      for (Vec3& p : muscle.mesh.vertices) p += shift;
      for (PathPoint& point : muscle.path.points) {
        point.body += by;
        if (point.with >= 0) point.with += by;
      }
      for (WrapCylinder& wrap : muscle.path.wraps) wrap.body += by;
      for (int& body : muscle.fixed_to) body += body < 0 ? 0 : by;
      all.muscles.push_back(std::move(muscle));
    }
    for (Bone bone : one.bones) {
      bone.name += mark;
      bone.body += by;
      all.bones.push_back(std::move(bone));
    }
    for (const auto& [a, b] : one.contact.ignore)
      all.contact.ignore.push_back({a + mark, b + mark});
    for (const std::string& self : one.contact.self) all.contact.self.push_back(self + mark);
    for (const auto& [name, metres] : one.contact.thickness) {
      all.contact.thickness.push_back({name + mark, metres});
    }
    for (const auto& [name, by_node] : one.contact.thicknesses) {
      all.contact.thicknesses.push_back({name + mark, by_node});
    }
  }
  return all;
}

}  // namespace

Json contact_of_copies(const std::string& scene, const std::filesystem::path& picture) {
  const ModelDef one = define_model(read_scene(scene));
  const double frames = one.last_frame - one.first_frame;
  Json out = {{"scene", one.name}};
  std::vector<ScalePoint> points;
  double nodes_of_one = 0.0, first = 0.0;
  for (const MuscleDef& muscle : one.muscles) nodes_of_one += muscle.mesh.vertices.size();
  for (const int count : {1, 2, 4, 8, 16, 32, 64}) {
    const Model model = build_model(copies_of(one, count, 1.0));
    const Played run = play(model, settled_state(model));
    std::int64_t searches = 0;
    for (const MuscleState& muscle : run.state.muscles) {
      searches += muscle.memory.searches + muscle.face_memory.searches;
    }
    const int last = static_cast<int>(model.muscles.size() - one.muscles.size());
    const Point apart = run.state.muscles[last].x[0] - run.state.muscles[0].x[0];
    const double milliseconds = 1e3 * run.stages.contact.cpu / frames, nodes = count * nodes_of_one;
    const double price = price_of_query(model, run.state);
    if (count == 1) first = milliseconds;
    const double grown = count * std::log(nodes) / std::log(nodes_of_one);
    out["copies"].push_back(
        {{"copies", count},
         {"nodes", nodes},
         {"contact_ms_per_frame", milliseconds},
         {"over_n_log_n", milliseconds / (first * grown)},
         {"searches_per_node_and_frame", searches / (nodes * frames)},
         {"query_us", 1e6 * price},
         {"queries_worth_per_node_and_frame", 1e-3 * milliseconds / (price * nodes)},
         {"off_the_first_um", 1e6 * std::abs(apart[2] - (count - 1.0))}});
    points.push_back({count, milliseconds, first * grown});
  }
  replace_durably(picture, draw_scale("Contact of " + one.name + ", 1 to 64 of it", points));
  return out;
}

}  // namespace thew::tools
