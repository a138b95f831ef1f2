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

using rig::SkinWeights;

// The weights of the skin; of a layer its shares of bodies.
SkinWeights weights_of(const sim::Model& model) {
  if (model.skinned) return model.skinned->weights;
  const skin::SkinModel& skin = model.skin;
  SkinWeights weights;
  for (size_t b = 0; b < skin.bind_pose.size(); ++b) {
    weights.links.push_back({static_cast<int>(b), Affine(skin.bind_pose[b].inverse())});
  }
  for (size_t i = 0; i < skin.rest.size(); ++i) {
    weights.first.push_back(static_cast<int>(weights.link.size()));
    for (int k = 0; k < 4 && skin.bodies[i][k] >= 0; ++k) {
      weights.link.push_back(skin.bodies[i][k]);
      weights.weight.push_back(skin.shares[i][k]);
    }
  }
  weights.first.push_back(static_cast<int>(weights.link.size()));
  return weights;
}

// m, in the bind pose.
std::vector<Vec3> base_of(const sim::Model& model) {
  if (model.skinned) return model.skinned->mesh.vertices;
  std::vector<Vec3> base;
  for (const Point& row : model.skin.rest) base.push_back(to_vec(row));
  return base;
}

std::vector<Affine> bodies_of(const sim::State& state) {
  if (!state.bodies.empty()) return state.bodies;
  return {state.pose.begin(), state.pose.end()};
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
  const SkinWeights skinning = weights_of(model);
  const std::vector<Vec3> in_bind = base_of(model);
  const std::vector<int> moving = moving_joints(model.skeleton);
  const size_t count = poses.size(), vertices = in_bind.size();
  int widest = 1;
  for (size_t i = 0; i < vertices; ++i) {
    widest = std::max(widest, skinning.first[i + 1] - skinning.first[i]);
  }
  const auto columns = static_cast<size_t>(widest);
  const auto& triangles = model.skin.surface.triangles;
  NamedArray joints = array("joints", Type::kFloat64, {count, moving.size()}),
             base = array("base", Type::kFloat64, {vertices, 3}),
             corners = array("triangles", Type::kInt32, {triangles.size(), 3}),
             influences = array("influences", Type::kInt32, {vertices, columns}),
             weights = array("weights", Type::kFloat64, {vertices, columns}),
             transforms = array("transforms", Type::kFloat64, {count, skinning.links.size(), 3, 4}),
             displacement = array("displacement", Type::kFloat32, {count, vertices, 3}),
             rungs = array("rungs", Type::kInt32, {count});
  for (const Vec3& v : in_bind) append(v, base);
  for (const Triangle& t : triangles)
    corners.values.insert(corners.values.end(), t.begin(), t.end());
  for (size_t i = 0; i < vertices; ++i) {
    for (int k = skinning.first[i]; k < skinning.first[i] + widest; ++k) {
      const bool is_there = k < skinning.first[i + 1];
      influences.values.push_back(is_there ? skinning.link[k] : 0);
      weights.values.push_back(is_there ? skinning.weight[k] : 0.0);
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
    std::vector<Affine> links;
    link_transforms(skinning, bodies_of(state), links);
    for (const Affine& link : links) append(link, transforms);
    const sim::BakeFrame frame = bake.read(static_cast<int>(p));
    rungs.values.push_back(rung_of(model, bake, frame));
    for (size_t i = 0; i < vertices; ++i) {
      const Affine blend = blended_transform(skinning, links, static_cast<int>(i));
      append(bounded_inverse(blend.linear()) * (frame.positions[skin][i] - blend * in_bind[i]),
             displacement);
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
