// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rig/mesh.h"
#include "rig/skeleton.h"

namespace thew::rig {

using Affine = Eigen::Affine3d;

/// The frame of a body in its parent, as files of characters store it: x = T R S x_local, so points
/// are first scaled, then rotated, then translated.
struct LocalTransform {
  Vec3 translation = Vec3::Zero();  ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 scale = Vec3::Ones();
};
/// Splits a frame into translation, rotation and scale. A shear is lost; a transform that mirrors
/// gets a negative scale along x.
LocalTransform split_transform(const Affine& transform);
Affine join_transform(const LocalTransform& transform);
/// The rotation and translation of a transform, without its scale.
Transform rigid_part(const Affine& transform);

/// How a curve runs between its keys (glTF 2.0, appendix C). kLinear: linearly, rotations along the
/// shorter arc. kStep: the curve keeps the value of the key before. kCubic: a cubic Hermite spline
/// by the slopes at its keys; rotations are interpolated as four numbers and then normalised.
enum class CurveInterpolation { kLinear, kStep, kCubic };
/// Values against time. Before the first key the curve has the first value, after the last key the
/// last one.
template <typename Value>
struct Curve {
  std::vector<double> times;  ///< s, increasing
  std::vector<Value> values;
  CurveInterpolation interpolation = CurveInterpolation::kLinear;
  /// Per second, one for each key; filled for kCubic only.
  std::vector<Value> slopes_in, slopes_out;
};
/// The value at `time` (s). `value` keeps what it had where the curve has no key.
void sample(const Curve<Vec3>& curve, double time, Vec3& value);
void sample(const Curve<Eigen::Quaterniond>& curve, double time, Eigen::Quaterniond& value);
struct BodyTrack {
  int body = -1;
  Curve<Vec3> translation;
  Curve<Eigen::Quaterniond> rotation;
  Curve<Vec3> scale;
};
/// An animation of a character: local transforms of bodies against time.
struct BodyClip {
  std::string name;
  double duration = 0.0;  ///< s
  std::vector<BodyTrack> tracks;
};

/// The weights by which a mesh follows its bodies, from the file of the character. Linear blend
/// skinning: x = sum_k weight_k world(body_k) from_bind_k x_bind, where k runs over the influences
/// of a vertex.
struct SkinWeights {
  struct Link {
    int body;
    Affine from_bind;  ///< from the bind pose into the frame of the body, scale included
  };
  std::vector<Link> links;
  std::vector<int> first;      ///< influences of vertex i: first[i] to first[i + 1]
  std::vector<int> link;       ///< by influence
  std::vector<double> weight;  ///< by influence; those of one vertex sum to 1
};

/// Consecutive vertices of a character, up to the first vertex of the next part. A part is a mesh
/// of the file or, where a mesh has several materials, the piece of one material. For glTF (.gltf,
/// .glb, .vrm), vertex i of the part is item i of `meshes[mesh_index].primitives[primitive]`. Other
/// formats have no such indices, because assimp rebuilds their vertices as it triangulates.
struct MeshPart {
  std::string mesh, node, material;                      ///< names; "" where the file gives none
  int mesh_index = -1, primitive = -1, node_index = -1;  ///< of glTF, whose node is `nodes[..]`
  int first_vertex = 0;
  Affine to_bind = Affine::Identity();  ///< from the file's frame of the mesh into the bind pose
};

/// A character as a file has it; metres, y up.
struct Character {
  Skeleton skeleton;         ///< in the bind pose; all joints are fixed and frames have no scale
  std::vector<Affine> bind;  ///< world transform of each body in the bind pose, scale included
  std::vector<Affine> rest;  ///< transform in the parent body while no animation moves the body
  std::vector<BodyClip> animations;
  std::vector<int> nodes;     ///< of glTF: by body, its node in the file, -1 for one that was added
  TriMesh mesh;               ///< in the bind pose; vertices in the order of the importer
  std::vector<int> map_back;  ///< for each vertex, the first vertex of the same position
  SkinWeights skin;
  std::vector<MeshPart> parts;
  /// A bone by its name in the VRM standard ("rightUpperArm"), for files that map bones to bodies.
  struct HumanBone {
    std::string bone;
    int body = -1;
  };
  std::vector<HumanBone> humanoid;
  /// A body that hangs on the one that it is a copy of (character_twins.h), and what it hangs on in
  /// the file, with its transform there while no animation moves it.
  struct Twin {
    int body, parent_in_file;
    Affine rest_in_file;
  };
  std::vector<Twin> twins;
  std::vector<std::string> files;  ///< of glTF: those it names, relative to its folder; not checked
  std::vector<std::string> warnings;
  std::string size_doubt;  ///< a warning if the mesh is not as large as a person; else empty
};

/// By body, 1 where a vertex hangs on it or on one below it; others only control a rig or end its
/// chains.
std::vector<char> bodies_with_skin(const Character& character);
/// World transforms of all bodies at `time` (s) of the animation, scale included.
void animated_bodies(const Character& character, const BodyClip& clip, double time,
                     std::vector<Affine>& world);
/// World transforms between two poses: the local transforms are interpolated, from those of `a` at
/// `share` 0 to those of `b` at 1.
void blend_bodies(const Skeleton& skeleton, const std::vector<Affine>& a,
                  const std::vector<Affine>& b, double share, std::vector<Affine>& world);
/// Positions x (m) of the vertices by linear blend skinning, see SkinWeights.
void skin_vertices(const SkinWeights& skin, const TriMesh& mesh, const std::vector<Affine>& world,
                   Points& x);
/// The same from transforms that link_transforms() has computed.
void skin_by_links(const SkinWeights& skin, const TriMesh& mesh,
                   const std::vector<Affine>& of_links, Points& x);
/// sum_k weight_k world(body_k) from_bind_k of one vertex.
Affine blended_transform(const SkinWeights& skin, const std::vector<Affine>& of_links, int vertex);
/// The inverse of the linear part of a blend. Where a joint twists by half a turn a blend flattens
/// the skin to a line, which no displacement before it undoes; there each stretch counts as a
/// twentieth of the largest at least.
Mat3 bounded_inverse(const Mat3& blend);
/// world(body) from_bind of each link.
void link_transforms(const SkinWeights& skin, const std::vector<Affine>& world,
                     std::vector<Affine>& of_links);

/// Transfers the motion of one skeleton to another: each body turns against its bind pose as its
/// counterpart turns against its own. Counterparts are found in this order: the pairs of `names`
/// (body of the motion, body of the character); the same bone of a person (character_bones.h), by
/// name or else by the geometry of the skeleton; equal names, a prefix up to ':' aside. Where upper
/// arms, forearms, thighs or shins point in different directions in the two bind poses (A and T
/// pose), the difference is removed. Keys lie where the motion has keys, and 60 a second between
/// keys that are more than 0.05 s apart. A summary is appended to `warnings`. Throws Error(kInput),
/// beginning with `location`, if a body of `names` does not exist or no body has a counterpart.
BodyClip retarget(const Character& from, const BodyClip& clip, const Character& to,
                  const std::vector<std::array<std::string, 2>>& names, const std::string& location,
                  std::vector<std::string>& warnings);

}  // namespace thew::rig
