// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "rig/mesh.h"
#include "rig/skeleton.h"

namespace thew::rig {

using Affine = Eigen::Affine3d;

/// A frame of a body in its parent as files of characters have it: translate, turn, then stretch.
struct LocalTransform {
  Vec3 translation = Vec3::Zero();  ///< m
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Vec3 scale = Vec3::Ones();
};
/// A shear is lost, a mirroring one stretches x by less than 0.
LocalTransform split_transform(const Affine& transform);
Affine join_transform(const LocalTransform& transform);
/// The turning and shifting part.
Transform rigid_part(const Affine& transform);

/// Between its keys a curve is linear (rotations along the shorter arc), holds the key before, or
/// is a cubic of Hermite's by the slopes at its keys (rotations by their four numbers, then made
/// unit again), as glTF 2.0, appendix C has it.
enum class CurveWay { kLinear, kStep, kCubic };
/// One curve, held outside its range.
template <typename Value>
struct Curve {
  std::vector<double> times;  ///< s, increasing
  std::vector<Value> values;
  CurveWay way = CurveWay::kLinear;
  std::vector<Value> slopes_in, slopes_out;  ///< a second, by key; of a cubic alone
};
/// Left as it is where the curve has no key.
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

/// Weights of a mesh that somebody has skinned already, "linear blend skinning":
/// x = sum_k weight_k world(body_k) from_bind_k rest.
struct SkinWeights {
  struct Link {
    int body;
    Affine from_bind;  ///< from the bind pose into the body, stretch included
  };
  std::vector<Link> links;
  std::vector<int> first;      ///< influences of vertex i: first[i] to first[i + 1]
  std::vector<int> link;       ///< by influence
  std::vector<double> weight;  ///< by influence, of a vertex they sum to 1
};

/// A run of a character's vertices, up to the next one's first: a mesh of the file or, where
/// materials part it, a piece of one. Of a glTF (.glb, .vrm) alone the run's vertex i is item i of
/// `meshes[mesh_index].primitives[primitive]`; other formats are triangulated by their reader.
struct MeshPart {
  std::string mesh, node, material;  ///< names; "" where the file gives none
  int mesh_index = -1, primitive = -1;
  int first_vertex = 0;
};

/// A character as a file has it; metres, y up.
struct Character {
  Skeleton skeleton;         ///< in the bind pose; all joints fixed, frames without stretch
  std::vector<Affine> bind;  ///< world transform of each body in the bind pose, stretch included
  std::vector<Affine> rest;  ///< in the parent, where no animation moves the body
  std::vector<BodyClip> animations;
  TriMesh mesh;               ///< in the bind pose; vertices in the order of the importer
  std::vector<int> map_back;  ///< of each vertex the first one at the same place
  SkinWeights skin;
  std::vector<MeshPart> parts;
  /// A bone by VRM's word for it ("rightUpperArm"), where the file says which body that is.
  struct HumanBone {
    std::string bone;
    int body = -1;
  };
  std::vector<HumanBone> humanoid;
  std::vector<std::string> warnings;
  std::string size_doubt;  ///< a warning, unless it is as large as a person
};

/// World transforms of all bodies at `time` (s) of the animation, stretch included.
void animated_bodies(const Character& character, const BodyClip& clip, double time,
                     std::vector<Affine>& world);
/// From one to the other, local transforms of `a` at share 0 and of `b` at 1.
void blend_bodies(const Skeleton& skeleton, const std::vector<Affine>& a,
                  const std::vector<Affine>& b, double share, std::vector<Affine>& world);
/// The skin as the weights alone carry it.
void skin_vertices(const SkinWeights& skin, const TriMesh& mesh, const std::vector<Affine>& world,
                   Points& x);
/// The same by the links' transforms.
void skin_by_links(const SkinWeights& skin, const TriMesh& mesh,
                   const std::vector<Affine>& of_links, Points& x);
/// The blend of a vertex' transforms.
Affine blended_transform(const SkinWeights& skin, const std::vector<Affine>& of_links, int vertex);
/// world(body) from_bind of each link.
void link_transforms(const SkinWeights& skin, const std::vector<Affine>& world,
                     std::vector<Affine>& of_links);

/// Motion of another skeleton carried over: each body turns as its counterpart turns from its own
/// bind pose, in the character's own axes. Counterparts are, in this order, those of `names` (that
/// body -> this body), those that are the same bone of a person (character_bones.h), by
/// names or, where these tell nothing, by shape; those of equal names, a namespace apart. Where
/// upper arms, forearms, thighs or shins point elsewhere in one bind pose than in the other (A and
/// T), the difference is taken out. Keys are where the motion has some and at 60 a second between
/// those that are farther apart. Adds what was done to `warnings`.
BodyClip retarget(const Character& from, const BodyClip& clip, const Character& to,
                  const std::vector<std::array<std::string, 2>>& names, const std::string& place,
                  std::vector<std::string>& warnings);

}  // namespace thew::rig
