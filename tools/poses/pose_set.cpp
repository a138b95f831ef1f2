// SPDX-License-Identifier: Apache-2.0
#include "tools/poses/pose_set.h"

#include <algorithm>

#include "rig/text.h"
#include "sim/bake/measure.h"
#include "sim/solver/drive.h"
#include "sim/solver/state_archive.h"
#include "tools/poses/ranges.h"

namespace thew::tools {
namespace {

using rig::Affine;
using sim::NamedArray;

// Linear blend skinning of a skin: links to bodies, and so many influences of each vertex.
struct Blend {
  std::vector<Vec3> base;  // m, in the bind pose
  std::vector<int> body;   // by link
  std::vector<Affine> from_bind;
  std::vector<std::vector<std::pair<int, double>>> influences;  // by vertex: link, weight

  std::size_t widest() const {
    std::size_t most = 1;
    for (const auto& row : influences) most = std::max(most, row.size());
    return most;
  }
  Affine at(std::size_t vertex, const std::vector<Affine>& links) const {
    Affine sum;
    sum.matrix().setZero();
    for (const auto& [link, weight] : influences[vertex])
      sum.matrix() += weight * links[link].matrix();
    return sum;
  }
};

Blend blend_of(const sim::Model& model) {
  Blend blend;
  if (model.skinned) {
    const rig::SkinWeights& weights = model.skinned->weights;
    blend.base = model.skinned->mesh.vertices;
    for (const auto& link : weights.links) {
      blend.body.push_back(link.body);
      blend.from_bind.push_back(link.from_bind);
    }
    blend.influences.resize(blend.base.size());
    for (size_t i = 0; i < blend.base.size(); ++i) {
      for (int k = weights.first[i]; k < weights.first[i + 1]; ++k) {
        blend.influences[i].emplace_back(weights.link[k], weights.weight[k]);
      }
    }
    return blend;
  }
  const skin::SkinModel& skin = model.skin;  // a layer's shares of bodies are its weights
  for (const Point& row : skin.rest) blend.base.push_back(to_vec(row));
  for (size_t b = 0; b < skin.bind_pose.size(); ++b) {
    blend.body.push_back(static_cast<int>(b));
    blend.from_bind.emplace_back(skin.bind_pose[b].inverse());
  }
  blend.influences.resize(blend.base.size());
  for (size_t i = 0; i < blend.base.size(); ++i) {
    for (int k = 0; k < 4 && skin.bodies[i][k] >= 0; ++k) {
      blend.influences[i].emplace_back(skin.bodies[i][k], skin.shares[i][k]);
    }
  }
  return blend;
}

// By link, from the bind pose to that of the state.
std::vector<Affine> links_at(const Blend& blend, const sim::State& state) {
  std::vector<Affine> links;
  for (size_t l = 0; l < blend.body.size(); ++l) {
    const int body = blend.body[l];
    const Affine world = state.bodies.empty() ? Affine(state.pose[body]) : state.bodies[body];
    links.push_back(world * blend.from_bind[l]);
  }
  return links;
}

NamedArray array(const char* name, NamedArray::Type type, std::vector<std::size_t> shape) {
  NamedArray out{name, type, std::move(shape), {}};
  std::size_t count = 1;
  for (const std::size_t n : out.shape) count *= n;
  out.values.reserve(count);
  return out;
}

void append(const Vec3& v, NamedArray& out) {
  out.values.insert(out.values.end(), v.begin(), v.end());
}

void append(const Affine& transform, NamedArray& out) {
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 4; ++column)
      out.values.push_back(transform.matrix()(row, column));
  }
}

// The worst rung that any muscle was on.
int rung_of(const sim::Model& model, const sim::BakeReader& bake, const sim::BakeFrame& frame) {
  int worst = 0;
  for (const auto& muscle : unflatten(model, bake.info().metric_names, frame.metrics).muscles) {
    if (muscle.rung > sim::Rung::kSubsteps) worst = std::max(worst, static_cast<int>(muscle.rung));
  }
  return worst;
}

}  // namespace

PoseSet make_pose_set(const sim::Model& model, const std::vector<std::vector<double>>& poses,
                      const sim::BakeReader& bake) {
  if (!model.has_skin) {
    throw Error(ErrorCode::kUsage,
                model.source + ": has no skin, and poses are of a skin; give it one");
  }
  using Type = NamedArray::Type;
  const Blend blend = blend_of(model);
  const std::vector<int> moving = moving_joints(model.skeleton);
  const size_t count = poses.size(), vertices = blend.base.size(), widest = blend.widest();
  const auto& triangles = model.skin.surface.triangles;
  NamedArray joints = array("joints", Type::kFloat64, {count, moving.size()}),
             base = array("base", Type::kFloat64, {vertices, 3}),
             corners = array("triangles", Type::kInt32, {triangles.size(), 3}),
             influences = array("influences", Type::kInt32, {vertices, widest}),
             weights = array("weights", Type::kFloat64, {vertices, widest}),
             transforms = array("transforms", Type::kFloat64, {count, blend.body.size(), 3, 4}),
             displacement = array("displacement", Type::kFloat32, {count, vertices, 3}),
             rungs = array("rungs", Type::kInt32, {count});
  for (const Vec3& v : blend.base) append(v, base);
  for (const Triangle& t : triangles)
    corners.values.insert(corners.values.end(), t.begin(), t.end());
  for (const auto& row : blend.influences) {
    for (size_t k = 0; k < widest; ++k) {
      influences.values.push_back(k < row.size() ? row[k].first : 0);
      weights.values.push_back(k < row.size() ? row[k].second : 0.0);
    }
  }
  const auto& meshes = bake.info().meshes;
  const int skin = static_cast<int>(
      std::find_if(meshes.begin(), meshes.end(),
                   [](const auto& mesh) { return mesh.kind == sim::BakeMesh::Kind::kSkin; }) -
      meshes.begin());
  sim::State state = sim::initial_state(model);
  for (size_t p = 0; p < count; ++p) {
    joints.values.insert(joints.values.end(), poses[p].begin(), poses[p].end());
    drive_bones(model, static_cast<double>(p) / model.fps, state);
    const std::vector<Affine> links = links_at(blend, state);
    for (const Affine& link : links) append(link, transforms);
    const sim::BakeFrame frame = bake.read(static_cast<int>(p));
    rungs.values.push_back(rung_of(model, bake, frame));
    for (size_t i = 0; i < vertices; ++i) {
      const Affine there = blend.at(i, links);
      append(Vec3(there.inverse() * frame.positions[skin][i] - blend.base[i]), displacement);
    }
  }
  std::string names;
  for (const int body : moving) {
    names += (names.empty() ? "" : "\n") + model.skeleton.joint_names[body];
  }
  return {{{"format", "thew-poses 1"},
           {"units", "m, rad"},
           {"up_axis", "Y"},
           {"scene", model.name},
           {"scene_hash", model.hash},
           {"joint_names", names}},
          {std::move(joints), std::move(base), std::move(corners), std::move(influences),
           std::move(weights), std::move(transforms), std::move(displacement), std::move(rungs)}};
}

}  // namespace thew::tools
