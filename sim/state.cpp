// SPDX-License-Identifier: Apache-2.0
#include "sim/state.h"

#include "sim/drive.h"
#include "sim/muscle_step.h"

namespace thew {
namespace {

// One list of numbers, written and read by the same function so that the two cannot differ.
struct Writer {
  std::vector<double>& out;
  void number(double& value) { out.push_back(value); }
  void count(size_t& n) { out.push_back(static_cast<double>(n)); }
};

struct Reader {
  const std::vector<double>& in;
  size_t at = 0;
  void number(double& value) {
    if (at == in.size())
      throw Error(ExitCode::kInput,
                  "the bake's state is shorter than its own lists; bake again without --resume");
    value = in[at++];
  }
  void count(size_t& n) {
    double value = 0.0;
    number(value);
    if (!(value >= 0.0 && value <= static_cast<double>(in.size()))) {
      throw Error(ExitCode::kInput, "the bake's state is damaged; bake again without --resume");
    }
    n = static_cast<size_t>(value);
  }
};

template <typename Archive>
void walk(Archive& archive, Rows& rows) {
  size_t n = rows.size();
  archive.count(n);
  rows.resize(n);
  for (Row& row : rows) {
    for (int k = 0; k < 3; ++k) {
      double value = row[k];
      archive.number(value);
      row[k] = value;
    }
  }
}

template <typename Archive>
void walk(Archive& archive, std::vector<double>& values) {
  size_t n = values.size();
  archive.count(n);
  values.resize(n);
  for (double& value : values) archive.number(value);
}

template <typename Archive>
void walk(Archive& archive, std::vector<Contact>& contacts) {
  size_t n = contacts.size();
  archive.count(n);
  contacts.resize(n);
  for (Contact& contact : contacts) {  // what a later step reads of them: which they are
    double node = contact.node, other = contact.other;
    archive.number(node);
    archive.number(other);
    double of_face = contact.of_face;
    archive.number(of_face);
    contact.of_face = of_face != 0.0;
    contact.node = static_cast<int>(node);
    contact.other = static_cast<int>(other);
  }
}

template <typename Archive>
void walk(Archive& archive, State& state) {
  archive.number(state.time);
  for (MuscleState& muscle : state.muscles) {
    walk(archive, muscle.x);
    walk(archive, muscle.v);
    walk(archive, muscle.target);
    walk(archive, muscle.rest_length);
    walk(archive, muscle.contacts);
    walk(archive, muscle.push);
    walk(archive, muscle.grip);
    archive.number(muscle.path_length);
    archive.number(muscle.zone_radius);
    walk(archive, muscle.weights);
    double rested = muscle.rested;
    archive.number(rested);
    muscle.rested = static_cast<int>(rested);
  }
  for (Rows* rows : {&state.skin.x, &state.skin.offset, &state.skin.force, &state.skin.slip}) {
    walk(archive, *rows);
  }
  walk(archive, state.skin.moved);
}

}  // namespace

State initial_state(const Model& model) {
  State state;
  state.time = -model.scene.settle;
  state.muscles.resize(model.muscles.size());
  state.bones.resize(model.bones.size());
  for (size_t b = 0; b < model.bones.size(); ++b) {
    state.bones[b].x = to_rows(model.bones[b].in_body.vertices);
    state.bones[b].bvh = build_bvh(model.bones[b].surface, state.bones[b].x);
  }
  drive_bones(model, state.time, state);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    MuscleState& now = state.muscles[m];
    now.x = to_rows(model.muscles[m].rest.vertices);
    now.v.assign(now.x.size(), Row{});
    now.target = now.x;
    now.target_velocity = now.v;
    now.start = now.seen = now.x;
    now.weights = model.muscles[m].weights;
    now.rest_length = now.rest_before = model.muscles[m].springs.rest_length;
    now.bvh = build_bvh(model.muscles[m].surface, now.x);
    now.pose = carry_pose(model.muscles[m].shape, state.pose);
    now.path_length = now.pose.path_length;
  }
  if (model.skinned) {
    state.skin = initial_skinned(*model.skinned);
  } else if (model.has_skin) {
    state.skin = initial_skin(model.skin);
  }
  return state;
}

std::vector<double> pack_state(const State& state) {
  std::vector<double> out;
  Writer writer{out};
  State copy = state;
  walk(writer, copy);
  return out;
}

void unpack_state(const Model& model, const std::vector<double>& packed, State& state) {
  state = initial_state(model);
  Reader reader{packed};
  walk(reader, state);
  drive_bones(model, state.time, state);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    if (state.muscles[m].x.size() != model.muscles[m].rest.vertices.size()) {
      throw Error(ExitCode::kInput,
                  "the bake's state is of other meshes; bake again without --resume");
    }
    state.muscles[m].pose = carry_pose(model.muscles[m].shape, state.pose);
  }
}

}  // namespace thew
