// SPDX-License-Identifier: Apache-2.0
#include "sim/solver/state_archive.h"

#include <algorithm>
#include <cstdint>
#include <type_traits>

#include "sim/solver/drive.h"

namespace thew::sim {
namespace {

// One list of numbers, written and read by the same function so that the two cannot differ.
struct Writer {
  static constexpr bool kReads = false;
  std::vector<double>& out;
  void number(double& value) { out.push_back(value); }
  void count(size_t& n) { out.push_back(static_cast<double>(n)); }
};

struct Reader {
  static constexpr bool kReads = true;
  const std::vector<double>& in;
  size_t at = 0;
  void number(double& value) {
    if (at == in.size())
      throw Error(ErrorCode::kInput,
                  "the bake's state is shorter than its own lists; bake again from the start");
    value = in[at++];
  }
  void count(size_t& n) {
    double value = 0.0;
    number(value);
    if (!(value >= 0.0 && value <= static_cast<double>(in.size()))) {
      throw Error(ErrorCode::kInput, "the bake's state is damaged; bake again from the start");
    }
    n = static_cast<size_t>(value);
  }
};

template <typename Archive>
void walk(Archive& archive, double& value) {
  archive.number(value);
}

// Whole numbers that a double holds exactly: counts, indices, enumerators.
template <typename Archive, typename Whole>
requires(std::is_integral_v<Whole> || std::is_enum_v<Whole>) void walk(Archive& archive,
                                                                       Whole& value) {
  double real = static_cast<double>(value);
  archive.number(real);
  if constexpr (Archive::kReads) value = static_cast<Whole>(static_cast<std::int64_t>(real));
}

template <typename Archive>
void walk(Archive& archive, Vec3& v) {
  for (double& value : v) archive.number(value);
}

template <typename Archive>
void walk(Archive& archive, Point& row) {
  for (int k = 0; k < 3; ++k) {
    double value = row[k];
    archive.number(value);
    if constexpr (Archive::kReads) row[k] = value;
  }
}

template <typename Archive, typename T, typename Allocator>
void walk(Archive& archive, std::vector<T, Allocator>& values) {
  size_t n = values.size();
  archive.count(n);
  values.resize(n);
  if constexpr (!Archive::kReads && std::is_same_v<T, double>) {
    archive.out.insert(archive.out.end(), values.begin(), values.end());
  } else {
    for (T& value : values) walk(archive, value);
  }
}

template <typename Archive>
void walk(Archive& archive, Contact& contact) {
  walk(archive, contact.node);
  walk(archive, contact.other);
  walk(archive, contact.of_face);
}

template <typename Archive, typename... Fields>
void walk_all(Archive& archive, Fields&... fields) {
  (walk(archive, fields), ...);
}

// The fields by structured binding: one that is added and not saved does not compile.
template <typename Archive>
void walk(Archive& archive, NodeMotion& motion) {
  auto& [x, v, zone_radius, weights, still_steps, level, posed] = motion;
  walk_all(archive, x, v, zone_radius, weights, still_steps, level, posed);
}

template <typename Archive>
void walk(Archive& archive, CarriedMotion& motion) {
  auto& [target, rest_length, path_length] = motion;
  walk_all(archive, target, rest_length, path_length);
}

template <typename Archive>
void walk(Archive& archive, ContactMotion& motion) {
  auto& [contacts, normal_multiplier, friction_multiplier] = motion;
  walk_all(archive, contacts, normal_multiplier, friction_multiplier);
}

template <typename Archive>
void walk(Archive& archive, SolverMeasures& measures) {
  auto& [volume_error, substep_volume_error, unreached, weight_fallbacks, zone_fallbacks,
         contact_impulse] = measures;
  auto& [impulse, angular_impulse] = contact_impulse;
  walk_all(archive, volume_error, substep_volume_error, unreached, weight_fallbacks, zone_fallbacks,
           impulse, angular_impulse);
}

template <typename Archive>
void walk(Archive& archive, MuscleMotion& motion) {
  static_assert(sizeof(MuscleMotion) == sizeof(NodeMotion) + sizeof(CarriedMotion) +
                                            sizeof(ContactMotion) + sizeof(SolverMeasures));
  walk_all(archive, static_cast<NodeMotion&>(motion), static_cast<CarriedMotion&>(motion),
           static_cast<ContactMotion&>(motion), static_cast<SolverMeasures&>(motion));
}

template <typename Archive>
void walk(Archive& archive, SkinMotion& motion) {
  auto& [x, offset, force, slip, moved] = motion;
  walk_all(archive, x, offset, force, slip, moved);
}

// What each search computes again from the positions is left out.
template <typename Archive>
void walk(Archive& archive, MotionHistory& followed) {
  walk_all(archive, followed.x, followed.travelled);
}

template <typename Archive>
void walk(Archive& archive, ContactMemory& memory) {
  size_t others = memory.others.size();
  archive.count(others);
  memory.others.resize(others);
  for (ContactMemory::Other& other : memory.others) {
    walk_all(archive, other.triangle, other.distance_bound, other.pending.approach,
             other.pending.separation, other.least, other.travelled);
  }
}

template <typename Archive>
void walk(Archive& archive, MuscleSearches& searches) {
  auto& [memory, face_memory, followed] = searches;
  walk_all(archive, memory, face_memory, followed);
}

template <typename Archive>
void walk(Archive& archive, LadderState& ladder) {
  auto& [rung, since, passes, frame_rung, cause] = ladder;
  walk_all(archive, rung, since, passes, frame_rung, cause);
}

template <typename Archive>
void walk(Archive& archive, State& state) {
  walk(archive, state.time);
  for (MuscleState& muscle : state.muscles) {
    walk(archive, static_cast<MuscleMotion&>(muscle));
    walk(archive, static_cast<MuscleSearches&>(muscle));
    walk(archive, muscle.ladder);
  }
  for (BoneState& bone : state.bones) walk(archive, bone.followed);
  walk(archive, static_cast<SkinMotion&>(state.skin));
  walk(archive, static_cast<SkinMotion&>(state.layer));
}

}  // namespace

State initial_state(const Model& model) {
  State state;
  state.time = -model.settle;
  state.muscles.resize(model.muscles.size());
  state.bones.resize(model.bones.size());
  for (size_t b = 0; b < model.bones.size(); ++b) {
    state.bones[b].x = to_points(model.bones[b].in_body.vertices);
    state.bones[b].bvh =
        build_bvh(model.surfaces[model.muscles.size() + b].surface, state.bones[b].x);
  }
  drive_bones(model, state.time, state);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    MuscleState& now = state.muscles[m];
    now.x = to_points(model.muscles[m].rest.vertices);
    now.v.assign(now.x.size(), Point{});
    now.target = now.x;
    now.target_velocity = now.v;
    now.start = now.previous_iterate = now.x;
    now.weights = model.muscles[m].weights;
    now.rest_length = now.rest_length_before = model.muscles[m].springs.rest_length;
    now.bvh = build_bvh(model.surfaces[m].surface, now.x);
    now.pose = carry_pose(model.muscles[m].shape, state.pose);
    now.path_length = now.pose.path_length;
  }
  if (model.skinned) {
    state.skin = initial_skinned(*model.skinned);
    state.layer = initial_layer(*model.skinned);
  } else if (model.has_skin) {
    state.skin = initial_skin(model.skin);
  }
  return state;
}

std::vector<double> pack_state(const State& state) {
  std::vector<double> out;
  pack_state(state, out);
  return out;
}

void pack_state(const State& state, std::vector<double>& out) {
  out.clear();
  Writer writer{out};
  walk(writer, const_cast<State&>(state));  // a writer changes nothing
}

namespace {

bool fits(const MuscleMotion& motion, const Model& model, const Muscle& muscle) {
  const size_t nodes = muscle.rest.vertices.size(), contacts = motion.contacts.size();
  const bool known =
      std::all_of(motion.contacts.begin(), motion.contacts.end(), [&](const Contact& contact) {
        return contact.node >= 0 && contact.node < static_cast<int>(nodes) && contact.other >= 0 &&
               contact.other < model.colliders();
      });
  return known && motion.x.size() == nodes && motion.v.size() == nodes &&
         motion.target.size() == nodes && motion.weights.size() == nodes &&
         motion.rest_length.size() == muscle.springs.nodes.size() &&
         motion.normal_multiplier.size() == contacts &&
         (motion.friction_multiplier.empty() || motion.friction_multiplier.size() == contacts);
}

bool fits(const ContactMemory& memory, const Model& model) {
  const size_t others = memory.others.size();
  return (others == 0 || others == static_cast<size_t>(model.colliders())) &&
         std::all_of(memory.others.begin(), memory.others.end(), [](const auto& other) {
           return other.triangle.size() == other.distance_bound.size();
         });
}

// Whether sizes and indices fit the model: a state of other meshes must not be stepped.
bool fits(const State& state, const Model& model) {
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    const MuscleState& now = state.muscles[m];
    if (!fits(now, model, model.muscles[m]) || !fits(now.memory, model) ||
        !fits(now.face_memory, model) || now.ladder.passes >= model.colliders()) {
      return false;
    }
  }
  const size_t vertices = model.has_skin ? model.skin.rest.size() : 0;
  const size_t nodes = model.skinned ? model.skinned->nodes.size() : vertices;
  const SkinMotion& layer = layer_of(model, state);
  return state.skin.x.size() == vertices && layer.x.size() == nodes &&
         layer.offset.size() == nodes && layer.force.size() == nodes &&
         layer.slip.size() == nodes && layer.correction.size() == nodes;
}

}  // namespace

void unpack_state(const Model& model, const std::vector<double>& packed, State& state) {
  state = initial_state(model);
  Reader reader{packed};
  walk(reader, state);
  if (reader.at != packed.size() || !fits(state, model)) {
    throw Error(ErrorCode::kInput,
                "the bake's state is of other meshes; bake again from the start");
  }
  drive_bones(model, state.time, state);
  for (size_t m = 0; m < model.muscles.size(); ++m) {
    MuscleState& now = state.muscles[m];
    now.pose = carry_pose(model.muscles[m].shape, state.pose);
    now.start = now.previous_iterate = now.x;  // read of a muscle that sleeps
    refit_bvh(model.surfaces[m].surface, now.x, now.bvh);
  }
}

void forget_searches(State& state) {
  for (MuscleState& muscle : state.muscles) static_cast<MuscleSearches&>(muscle) = {};
  for (BoneState& bone : state.bones) bone.followed = {};
}

}  // namespace thew::sim
