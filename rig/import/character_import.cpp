// SPDX-License-Identifier: Apache-2.0
#include "rig/import/character_import.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "rig/character_twins.h"
#include "rig/import/assimp_scene.h"
#include "rig/import/child.h"
#include "rig/import/gltf_character.h"
#include "rig/import/gltf_source.h"
#include "rig/import/packed.h"
#include "rig/import/text_numbers.h"
#include "rig/limits.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

template <typename Archive, typename Value>
void walk_values(Archive& archive, std::vector<Value>& values) {
  std::vector<double> flat;
  constexpr size_t kWidth = sizeof(Value) / sizeof(double);
  if constexpr (std::is_same_v<Archive, Packer>) {
    flat.resize(values.size() * kWidth);
    if (!flat.empty()) {
      std::memcpy(flat.data(), static_cast<const void*>(values.data()),
                  flat.size() * sizeof(double));
    }
    archive.list(flat);
  } else {
    archive.list(flat);
    values.resize(flat.size() / kWidth);
    if (!values.empty()) {
      std::memcpy(static_cast<void*>(values.data()), flat.data(),
                  values.size() * kWidth * sizeof(double));
    }
  }
}

template <typename Archive, typename Value>
void walk(Archive& archive, Curve<Value>& curve) {
  archive.list(curve.times);
  walk_values(archive, curve.values);
  archive.number(curve.interpolation);
  walk_values(archive, curve.slopes_in);
  walk_values(archive, curve.slopes_out);
}

template <typename Archive>
void walk_affine(Archive& archive, Affine& transform) {
  for (int k = 0; k < 16; ++k) archive.number(transform.matrix().data()[k]);
}

template <typename Archive>
void walk(Archive& archive, Character& c) {
  const auto text = [](Archive& a, std::string& t) { a.list(t); };
  const auto affine = [](Archive& a, Affine& t) { walk_affine(a, t); };
  archive.each(c.skeleton.body_names, text);
  archive.list(c.skeleton.parent);
  archive.each(c.bind, affine);
  archive.each(c.rest, affine);
  archive.each(c.animations, [&](Archive& a, BodyClip& clip) {
    a.list(clip.name);
    a.number(clip.duration);
    a.each(clip.tracks, [](Archive& b, BodyTrack& track) {
      b.number(track.body);
      walk(b, track.translation);
      walk(b, track.rotation);
      walk(b, track.scale);
    });
  });
  archive.list(c.nodes);
  archive.list(c.mesh.vertices);
  archive.list(c.mesh.triangles);
  archive.each(c.skin.links, [](Archive& a, SkinWeights::Link& link) {
    a.number(link.body);
    walk_affine(a, link.from_bind);
  });
  archive.list(c.skin.first);
  archive.list(c.skin.link);
  archive.list(c.skin.weight);
  archive.each(c.parts, [](Archive& a, MeshPart& part) {
    a.list(part.mesh);
    a.list(part.node);
    a.list(part.material);
    a.number(part.mesh_index);
    a.number(part.primitive);
    a.number(part.node_index);
    a.number(part.first_vertex);
    walk_affine(a, part.to_bind);
  });
  archive.each(c.humanoid, [](Archive& a, Character::HumanBone& bone) {
    a.list(bone.bone);
    a.number(bone.body);
  });
  archive.each(c.files, text);
  archive.each(c.warnings, text);
  archive.list(c.size_doubt);
}

// The file may have taken over the child, so nothing in its answer is trusted: all lists must have
// matching sizes, and all indices must lie within their lists.
bool is_sound(const Character& c) {
  const size_t bodies = c.skeleton.body_names.size(), vertices = c.mesh.vertices.size();
  const auto within = [](const std::vector<int>& list, size_t size) {
    return std::all_of(list.begin(), list.end(),
                       [&](int i) { return i >= 0 && static_cast<size_t>(i) < size; });
  };
  const auto curve_sound = [](const auto& curve) {
    const size_t slopes =
        curve.interpolation == CurveInterpolation::kCubic ? curve.times.size() : 0;
    const auto kind = static_cast<int>(curve.interpolation);
    return kind >= 0 && kind <= 2 && curve.values.size() == curve.times.size() &&
           curve.slopes_in.size() == slopes && curve.slopes_out.size() == slopes;
  };
  const auto body_known = [&](const auto& one) {
    return one.body >= 0 && static_cast<size_t>(one.body) < bodies;
  };
  bool sound = bodies > 0 && c.skeleton.parent.size() == bodies && c.bind.size() == bodies &&
               c.rest.size() == bodies && c.skin.first.size() == vertices + 1 &&
               c.skin.first.back() == static_cast<int>(c.skin.link.size()) &&
               std::is_sorted(c.skin.first.begin(), c.skin.first.end()) && c.skin.first[0] == 0 &&
               c.skin.weight.size() == c.skin.link.size() &&
               (c.nodes.empty() || c.nodes.size() == bodies) &&
               within(c.skin.link, c.skin.links.size()) &&
               std::all_of(c.skin.links.begin(), c.skin.links.end(), body_known) &&
               std::all_of(c.humanoid.begin(), c.humanoid.end(), body_known);
  for (size_t i = 0; sound && i < bodies; ++i) {
    sound = c.skeleton.parent[i] >= -1 && c.skeleton.parent[i] < static_cast<int>(i);
  }
  int first = 0;
  for (const MeshPart& part : c.parts) {
    sound = sound && part.first_vertex >= first && part.first_vertex <= static_cast<int>(vertices);
    first = part.first_vertex;
  }
  for (const Triangle& t : c.mesh.triangles) {
    sound = sound && within({t.begin(), t.end()}, vertices);
  }
  for (const BodyClip& clip : c.animations) {
    for (const BodyTrack& track : clip.tracks) {
      sound = sound && body_known(track) && curve_sound(track.translation) &&
              curve_sound(track.rotation) && curve_sound(track.scale);
    }
  }
  return sound;
}

// Whether a frame lies within `farthest` (m) of the origin along each axis and its scale is one
// that a unit may have (limits.h).
bool is_frame(const Affine& transform, double farthest) {
  constexpr double kFlattest = kMinScale * kMinScale * kMinScale;
  return is_bounded(transform.translation(), farthest) &&
         (transform.linear().array().abs() <= kMaxScale).all() &&
         std::abs(transform.linear().determinant()) >= kFlattest;
}

template <typename Value, typename Check>
bool all_values(const Curve<Value>& curve, const Check& check) {
  return std::all_of(curve.values.begin(), curve.values.end(), check) &&
         std::all_of(curve.slopes_in.begin(), curve.slopes_in.end(), check) &&
         std::all_of(curve.slopes_out.begin(), curve.slopes_out.end(), check);
}

// The positions of a track are in the frame of the parent, which may be scaled, for instance from
// centimetres.
void check_animations(const fs::path& file, const Character& c, double farthest) {
  for (const BodyClip& clip : c.animations) {
    for (const BodyTrack& track : clip.tracks) {
      const int parent = c.skeleton.parent[track.body];
      const double stretch = parent < 0 ? 1.0 : c.bind[parent].linear().norm();
      const bool good =
          all_values(track.translation,
                     [&](const Vec3& p) { return is_bounded(stretch * p, farthest); }) &&
          all_values(track.scale, [](const Vec3& p) { return is_bounded(p, kMaxScale); }) &&
          all_values(track.rotation, [](const Eigen::Quaterniond& q) {
            return (q.coeffs().array().abs() <= kMaxAngle).all();
          });
      if (good) continue;
      throw Error(ErrorCode::kInput, file.string() + ": animation \"" + clip.name + "\" moves \"" +
                                         c.skeleton.body_names[track.body] +
                                         "\" farther than 10 km; correct its keys or its unit");
    }
  }
}

// A motion without a mesh has no unit, and only its rotations are used. So its positions may be a
// thousand times farther away, as if in millimetres.
void check_numbers(const fs::path& file, const Character& c, bool with_mesh) {
  const double farthest = with_mesh ? kMaxCoordinate : 1e3 * kMaxCoordinate;
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kInput,
                file.string() + ": " + what +
                    "; export the character again, or give its unit by [rig] scale");
  };
  std::vector<Affine> rest = c.rest;
  for (size_t i = 0; i < rest.size(); ++i) {
    if (c.skeleton.parent[i] >= 0) rest[i] = rest[c.skeleton.parent[i]] * rest[i];
    for (const Affine& world : {c.bind[i], rest[i]}) {
      if (is_frame(world, farthest)) continue;
      fail("body \"" + c.skeleton.body_names[i] + "\" lies at " + point_text(world.translation()) +
           ", farther than 10 km, or is flat or stretched");
    }
  }
  for (const SkinWeights::Link& link : c.skin.links) {
    const Affine& from = link.from_bind;
    if (from.matrix().allFinite() && is_frame(from.inverse(), farthest)) continue;
    fail("the bind matrix of body \"" + c.skeleton.body_names[link.body] +
         "\" leads farther than 10 km, or is flat or stretched");
  }
  for (size_t i = 0; i < c.mesh.vertices.size(); ++i) {
    if (is_bounded(c.mesh.vertices[i])) continue;
    check_position(c.mesh.vertices[i], file.string() + ": vertex " + std::to_string(i),
                   "export the character again, or give its unit by [rig] scale");
  }
  check_animations(file, c, farthest);
}

// Fills the skeleton from the bind pose, with all joints fixed.
void complete_skeleton(Character& character) {
  Skeleton& skeleton = character.skeleton;
  std::vector<Transform> rigid;
  for (int i = 0; i < skeleton.size(); ++i) {
    const int parent = skeleton.parent[i];
    rigid.push_back(rigid_part(character.bind[i]));
    skeleton.joint_in_parent.push_back(parent < 0 ? rigid[i] : rigid[parent].inverse() * rigid[i]);
    skeleton.joint_names.emplace_back(parent < 0 ? "" : skeleton.body_names[i]);
    skeleton.joint_types.push_back(Skeleton::JointType::kFixed);
    skeleton.joint_axes.push_back(Vec3::UnitX());
    skeleton.lower.push_back(0.0);
    skeleton.upper.push_back(0.0);
    skeleton.visuals.emplace_back();
  }
}

Character import_any(const fs::path& file, double scale, bool with_mesh) {
  check_readable(file, kAssimpFileLimit);
  Child child(file, "export it again, for instance as glTF", [&](std::string_view) {
    if (lower_ending(file) == "bvh") {
      check_text_numbers(file, read_in_child(file_of_child(), kAssimpFileLimit));
    }
    Character character = names_gltf(file) ? read_gltf_character(file, scale, with_mesh)
                                           : read_assimp_character(file, scale, with_mesh);
    Packer packer;
    walk(packer, character);
    return packer.bytes;
  });
  const std::string bytes = child.ask();
  Character character;
  Unpacker unpacker{bytes};
  walk(unpacker, character);
  if (!unpacker.finished() || !is_sound(character)) child.refuse("its reader sent nonsense");
  check_numbers(file, character, with_mesh);
  join_twins(character);
  complete_skeleton(character);
  character.map_back = first_at_position(character.mesh);
  return character;
}

[[noreturn]] void refuse_ending(const fs::path& file, const char* instead) {
  const bool opensim = lower_ending(file) == "osim";
  throw Error(ErrorCode::kInput,
              file.string() + ": " +
                  (opensim ? "is an OpenSim model, whose muscles Thew does not read; its motion "
                             "it does, from .mot and .sto"
                           : instead));
}

}  // namespace

bool names_character(const fs::path& file) {
  const std::string ending = lower_ending(file);
  return names_gltf(file) || ending == "fbx" || ending == "dae";
}

bool names_motion(const fs::path& file) {
  return names_character(file) || lower_ending(file) == "bvh";
}

Character import_character(const fs::path& file, double scale) {
  if (lower_ending(file) == "bvh") return import_any(file, scale, false);
  if (names_character(file)) return import_any(file, scale, true);
  refuse_ending(file,
                "characters are read from glTF (.gltf, .glb, .vrm), FBX and Collada; export "
                "it as one of these");
}

Character import_motion(const fs::path& file) {
  if (names_motion(file)) return import_any(file, 1.0, false);
  refuse_ending(file,
                "motion of bodies is read from BVH, glTF (.gltf, .glb, .vrm), FBX and "
                "Collada; export it as one of these");
}

}  // namespace thew::rig
