// SPDX-License-Identifier: Apache-2.0
#include "tools/poses/pose_set.h"

#include <algorithm>

#include "rig/math.h"
#include "rig/text.h"
#include "sim/bake/measure.h"
#include "sim/solver/character_rig.h"
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

// Influences of the vertex that has most.
size_t widest_of(const SkinWeights& skinning) {
  int widest = 1;
  for (size_t i = 0; i + 1 < skinning.first.size(); ++i) {
    widest = std::max(widest, skinning.first[i + 1] - skinning.first[i]);
  }
  return static_cast<size_t>(widest);
}

void append_influences(const SkinWeights& skinning, size_t columns, NamedArray& influences,
                       NamedArray& weights) {
  for (size_t i = 0; i + 1 < skinning.first.size(); ++i) {
    for (int k = skinning.first[i]; k < skinning.first[i] + static_cast<int>(columns); ++k) {
      const bool is_there = k < skinning.first[i + 1];
      influences.values.push_back(is_there ? skinning.link[k] : 0);
      weights.values.push_back(is_there ? skinning.weight[k] : 0.0);
    }
  }
}

// Of any muscle: the worst rung that it was on, and the most by which it swung, m.
void append_faults(const sim::Model& model, const sim::BakeReader& bake,
                   const sim::BakeFrame& frame, NamedArray& rungs, NamedArray& swings) {
  int worst = 0;
  double most = 0.0;
  for (const auto& muscle : unflatten(model, bake.info().metric_names, frame.metrics).muscles) {
    if (muscle.rung > sim::Rung::kSubsteps) worst = std::max(worst, static_cast<int>(muscle.rung));
    most = std::max(most, muscle.swing);
  }
  rungs.values.push_back(worst);
  swings.values.push_back(most);
}

// How a body is turned in its parent against the bind pose: axis times angle, rad, at most half a
// turn.
Vec3 turn_of(const sim::CharacterRig& rig, const std::vector<Affine>& bodies, int body) {
  const int parent = rig.character.skeleton.parent[body];
  const auto in_parent = [&](const std::vector<Affine>& world) -> Mat3 {
    const Mat3 own = rig::rigid_part(world[body]).linear();
    return parent < 0 ? own : Mat3(rig::rigid_part(world[parent]).linear().transpose() * own);
  };
  const Eigen::Quaterniond turn(Mat3(in_parent(rig.rest).transpose() * in_parent(bodies)));
  const double sine = turn.vec().norm();
  if (sine == 0.0) return Vec3::Zero();
  const double side = turn.w() < 0.0 ? -1.0 : 1.0;
  return turn.vec() * (side * 2.0 * rig::arc_tan2(sine, side * turn.w()) / sine);
}

/// What the poses are told apart by: names of columns, and their values by pose.
struct Inputs {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
};

Inputs joint_values(const sim::Model& model, const std::vector<std::vector<double>>& poses) {
  Inputs inputs{{}, poses};
  for (const int body : moving_joints(model.skeleton)) {
    inputs.names.push_back(model.skeleton.joint_names[body]);
  }
  return inputs;
}

// Of the bodies that are turned in any pose.
Inputs body_turns(const sim::Model& model, const std::vector<std::vector<Affine>>& bodies) {
  constexpr double kTurned = 1e-9;  // rad
  const sim::CharacterRig& rig = *model.character;
  Inputs inputs;
  inputs.rows.resize(bodies.size());
  for (int b = 0; b < rig.character.skeleton.size(); ++b) {
    std::vector<Vec3> turns;
    double most = 0.0;
    for (const auto& pose : bodies)
      most = std::max(most, turns.emplace_back(turn_of(rig, pose, b)).norm());
    if (most < kTurned) continue;
    for (int axis = 0; axis < 3; ++axis) {
      inputs.names.push_back(rig.character.skeleton.body_names[b] + "." + "xyz"[axis]);
      for (size_t p = 0; p < turns.size(); ++p) inputs.rows[p].push_back(turns[p][axis]);
    }
  }
  if (!inputs.names.empty()) return inputs;
  throw Error(ErrorCode::kUsage,
              model.source +
                  ": no body is turned in these frames, so that they are the bind pose; "
                  "give others");
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
  const std::vector<int>& frames = bake.info().frames;
  const size_t count = frames.size(), vertices = in_bind.size();
  const size_t columns = widest_of(skinning);
  const auto& triangles = model.skin.surface.triangles;
  NamedArray base = array("base", Type::kFloat64, {vertices, 3}),
             corners = array("triangles", Type::kInt32, {triangles.size(), 3}),
             influences = array("influences", Type::kInt32, {vertices, columns}),
             weights = array("weights", Type::kFloat64, {vertices, columns}),
             transforms = array("transforms", Type::kFloat64, {count, skinning.links.size(), 3, 4}),
             displacement = array("displacement", Type::kFloat32, {count, vertices, 3}),
             rungs = array("rungs", Type::kInt32, {count}),
             swings = array("swings", Type::kFloat64, {count});
  for (const Vec3& v : in_bind) append(v, base);
  for (const Triangle& t : triangles)
    corners.values.insert(corners.values.end(), t.begin(), t.end());
  append_influences(skinning, columns, influences, weights);
  const auto& meshes = bake.info().meshes;
  const int skin = static_cast<int>(
      std::find_if(meshes.begin(), meshes.end(),
                   [](const auto& mesh) { return mesh.kind == sim::BakeMesh::Kind::kSkin; }) -
      meshes.begin());
  sim::State state = sim::initial_state(model);
  std::vector<std::vector<Affine>> bodies;
  for (size_t p = 0; p < count; ++p) {
    drive_bones(model, (frames[p] - model.first_frame) / model.fps, state);
    bodies.push_back(bodies_of(state));
    std::vector<Affine> links;
    link_transforms(skinning, bodies.back(), links);
    for (const Affine& link : links) append(link, transforms);
    const sim::BakeFrame frame = bake.read(static_cast<int>(p));
    append_faults(model, bake, frame, rungs, swings);
    for (size_t i = 0; i < vertices; ++i) {
      const Affine blend = blended_transform(skinning, links, static_cast<int>(i));
      append(bounded_inverse(blend.linear()) * (frame.positions[skin][i] - blend * in_bind[i]),
             displacement);
    }
  }
  const Inputs inputs =
      sim::is_animated(model) ? body_turns(model, bodies) : joint_values(model, poses);
  NamedArray joints = array("joints", Type::kFloat64, {count, inputs.names.size()});
  for (const auto& row : inputs.rows) {
    joints.values.insert(joints.values.end(), row.begin(), row.end());
  }
  std::string names;
  for (const std::string& name : inputs.names) names += (names.empty() ? "" : "\n") + name;
  return {{{"format", "thew-poses 1"},
           {"units", "m, rad"},
           {"up_axis", "Y"},
           {"scene", model.name},
           {"scene_hash", model.hash},
           {"joint_names", names}},
          {std::move(joints), std::move(base), std::move(corners), std::move(influences),
           std::move(weights), std::move(transforms), std::move(displacement), std::move(rungs),
           std::move(swings)}};
}

}  // namespace thew::tools
