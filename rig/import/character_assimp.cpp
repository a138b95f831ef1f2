// SPDX-License-Identifier: Apache-2.0
//
// Converts the scene that assimp reads to a Character. Runs in the child process.
#include <assimp/anim.h>
#include <assimp/commonMetaData.h>
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/mesh.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "rig/import/assimp_scene.h"
#include "rig/import/character_parts.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

constexpr double kTicksPerSecond = 25.0;  // 1/s, for files that name no rate; assimp uses the same
[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Error(ErrorCode::kInput, file.string() + ": " + what + "; export the character again");
}

Vec3 to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Affine to_affine(const aiMatrix4x4& m) {
  Affine out;
  out.matrix() = to_matrix(m);
  return out;
}

// Parents before children, in the file's order.
struct AssimpNodes {
  std::vector<const aiNode*> nodes;
  std::map<std::string, int> by_name;
  std::vector<Affine> world;  // at rest
};

// Where a mesh and a bone share a name, which Blender allows, the name stands for the bone.
void name_nodes(AssimpNodes& nodes, Skeleton& skeleton) {
  std::vector<std::string> names;
  std::vector<char> has_mesh;
  for (const aiNode* node : nodes.nodes) {
    names.emplace_back(node->mName.C_Str());
    if (names.back().empty()) names.back() = "node_" + std::to_string(names.size() - 1);
    has_mesh.push_back(node->mNumMeshes > 0 ? 1 : 0);
  }
  name_bodies(names, has_mesh, skeleton);
  for (const bool of_meshes : {false, true}) {
    for (size_t i = 0; i < names.size(); ++i) {
      if ((has_mesh[i] != 0) != of_meshes) continue;
      nodes.by_name.emplace(nodes.nodes[i]->mName.C_Str(), static_cast<int>(i));
    }
  }
}

AssimpNodes collect_bodies(const fs::path& file, const aiScene& scene, double scale,
                           Character& character) {
  AssimpNodes out;
  std::vector<std::pair<const aiNode*, int>> open = {{scene.mRootNode, -1}};
  while (!open.empty()) {
    const auto [node, parent] = open.back();
    open.pop_back();
    const int index = static_cast<int>(out.nodes.size());
    if (index > kMaxBodies) refuse(file, "has more than " + std::to_string(kMaxBodies) + " nodes");
    Affine local = to_affine(node->mTransformation);
    if (parent < 0) local = Eigen::Scaling(scale) * local;
    if (!local.matrix().allFinite() || local.linear().determinant() == 0.0) {
      refuse(file, "node \"" + std::string(node->mName.C_Str()) + "\" has no sound transform");
    }
    out.nodes.push_back(node);
    out.world.push_back(parent < 0 ? local : out.world[parent] * local);
    character.rest.push_back(local);
    character.skeleton.parent.push_back(parent);
    for (unsigned i = node->mNumChildren; i-- > 0;) open.emplace_back(node->mChildren[i], index);
  }
  name_nodes(out, character.skeleton);
  return out;
}

// Appends the weights of a mesh. `to_world` takes the mesh to its position in the bind pose.
void append_weights(const fs::path& file, const aiMesh& part, const AssimpNodes& nodes,
                    const Affine& to_world, int first, Influences& influences,
                    Character& character) {
  const Affine to_mesh = to_world.inverse();
  for (unsigned b = 0; b < part.mNumBones; ++b) {
    const aiBone& bone = *part.mBones[b];
    const auto found = nodes.by_name.find(bone.mName.C_Str());
    if (found == nodes.by_name.end()) {
      refuse(file, "bone \"" + std::string(bone.mName.C_Str()) + "\" is no node of the file");
    }
    const int link = static_cast<int>(character.skin.links.size());
    character.skin.links.push_back({found->second, to_affine(bone.mOffsetMatrix) * to_mesh});
    if (!character.skin.links.back().from_bind.matrix().allFinite()) {
      refuse(file, "bone \"" + found->first + "\" has no sound bind matrix");
    }
    for (unsigned w = 0; w < bone.mNumWeights; ++w) {
      const aiVertexWeight& one = bone.mWeights[w];
      if (one.mVertexId >= part.mNumVertices || !(one.mWeight >= 0.0f && one.mWeight < 1e6f)) {
        refuse(file, "bone \"" + found->first + "\" has weight " + number_text(one.mWeight) +
                         " on vertex " + std::to_string(one.mVertexId) + " of " +
                         std::to_string(part.mNumVertices));
      }
      if (one.mWeight > 0.0f) influences[first + one.mVertexId].push_back({link, one.mWeight});
    }
  }
}

// The transform of a skinned mesh by its joints: that of the joint nearest to the root at rest,
// times the bind matrix of that joint. So the bind pose stands where the rest pose stands.
Affine transform_by_joints(const aiMesh& part, const AssimpNodes& nodes) {
  int first = static_cast<int>(nodes.nodes.size());
  Affine to_world = Affine::Identity();
  for (unsigned b = 0; b < part.mNumBones; ++b) {
    const auto joint = nodes.by_name.find(part.mBones[b]->mName.C_Str());
    if (joint == nodes.by_name.end() || joint->second >= first) continue;
    first = joint->second;
    to_world = nodes.world[first] * to_affine(part.mBones[b]->mOffsetMatrix);
  }
  return to_world;
}

bool is_of_blender(const aiScene& scene) {
  aiString tool;
  return scene.mMetaData && scene.mMetaData->Get(AI_METADATA_SOURCE_GENERATOR, tool) &&
         std::string_view(tool.C_Str()).starts_with("Blender");
}

// Appends a mesh of a node, its vertices in the bind pose. In FBX the transform of the node places
// a skinned mesh, in Collada its joints alone (Collada 1.4.1, page 4-7). Blender (checked with 3.4)
// writes the transform of the mesh in its parent as the bind shape matrix, so for its Collada files
// the transform of the node is applied in addition.
void append_mesh(const fs::path& file, const aiScene& scene, const aiMesh& part,
                 const AssimpNodes& nodes, int node, Influences& influences, Character& character) {
  MeshPart about;
  about.node = nodes.nodes[node]->mName.C_Str();
  about.mesh = part.mName.length > 0 ? part.mName.C_Str() : about.node;
  if (part.mMaterialIndex < scene.mNumMaterials) {
    about.material = scene.mMaterials[part.mMaterialIndex]->GetName().C_Str();
  }
  std::vector<Vec3> vertices;
  for (unsigned i = 0; i < part.mNumVertices; ++i) vertices.push_back(to_vec(part.mVertices[i]));
  std::vector<Triangle> triangles;
  append_triangles(file, part, false, 0, triangles);
  const bool by_joints = part.mNumBones > 0 && lower_ending(file) == "dae";
  const Affine bound = by_joints ? transform_by_joints(part, nodes) : nodes.world[node];
  Affine to_world = bound;
  if (by_joints && is_of_blender(scene)) {
    to_world = nodes.world[node] * nodes.world[0].inverse() * bound;
  }
  const int first = append_part(file, about, vertices, triangles, to_world, influences, character);
  append_weights(file, part, nodes, bound, first, influences, character);
  attach_unweighted(file, first, node, nodes.world[node], part.mNumBones > 0, influences,
                    character);
}

void collect_skin(const fs::path& file, const aiScene& scene, const AssimpNodes& nodes,
                  Character& character) {
  Influences influences;
  for (size_t n = 0; n < nodes.nodes.size(); ++n) {
    for (unsigned i = 0; i < nodes.nodes[n]->mNumMeshes; ++i) {
      append_mesh(file, scene, *scene.mMeshes[nodes.nodes[n]->mMeshes[i]], nodes,
                  static_cast<int>(n), influences, character);
    }
  }
  leave_out_coarser(file, influences, character);
  put_weights(file, influences, character);
}

// Bodies that are bones of the skin get the pose of their bind matrices; the others keep their rest
// transform relative to the parent.
void set_bind_pose(const AssimpNodes& nodes, Character& character) {
  Skeleton& skeleton = character.skeleton;
  character.bind.resize(skeleton.size());
  std::vector<char> known(skeleton.size(), 0);
  for (const SkinWeights::Link& link : character.skin.links) {
    if (known[link.body]) continue;
    known[link.body] = 1;
    character.bind[link.body] = link.from_bind.inverse();
  }
  for (int i = 0; i < character.skeleton.size(); ++i) {
    const int parent = skeleton.parent[i];
    if (known[i]) continue;
    character.bind[i] = parent < 0 ? nodes.world[i] : character.bind[parent] * character.rest[i];
  }
}

template <typename Value, typename Key, typename Convert>
Curve<Value> to_curve(const Key* keys, unsigned count, double seconds, Convert convert) {
  Curve<Value> curve;
  for (unsigned k = 0; k < count; ++k) {
    const double time = keys[k].mTime * seconds;
    if (!(std::abs(time) < 1e9)) continue;
    if (!curve.times.empty() && time <= curve.times.back())
      continue;  // a second key at the same time
    curve.times.push_back(time);
    curve.values.push_back(convert(keys[k].mValue));
  }
  return curve;
}

bool all_finite(const BodyTrack& track) {
  const auto sound = [](const auto& values) {
    return std::all_of(values.begin(), values.end(), [](const Vec3& v) { return v.allFinite(); });
  };
  return sound(track.translation.values) && sound(track.scale.values) &&
         std::all_of(track.rotation.values.begin(), track.rotation.values.end(),
                     [](const auto& q) { return q.coeffs().allFinite(); });
}

void collect_animations(const fs::path& file, const aiScene& scene, const AssimpNodes& nodes,
                        double scale, Character& character) {
  for (unsigned a = 0; a < scene.mNumAnimations; ++a) {
    const aiAnimation& animation = *scene.mAnimations[a];
    const double rate = animation.mTicksPerSecond;
    const double seconds = 1.0 / (rate > 0.0 ? rate : kTicksPerSecond);
    BodyClip clip;
    clip.name = animation.mName.C_Str();
    if (clip.name.empty()) clip.name = "animation_" + std::to_string(a + 1);
    for (unsigned c = 0; c < animation.mNumChannels; ++c) {
      const aiNodeAnim& channel = *animation.mChannels[c];
      const auto found = nodes.by_name.find(channel.mNodeName.C_Str());
      if (found == nodes.by_name.end()) continue;  // that of a camera or a light
      BodyTrack track;
      track.body = found->second;
      // The scale of the file is applied at the root.
      const double size = found->second == 0 ? scale : 1.0;
      track.translation =
          to_curve<Vec3>(channel.mPositionKeys, channel.mNumPositionKeys, seconds,
                         [&](const aiVector3D& v) { return Vec3(size * to_vec(v)); });
      track.scale = to_curve<Vec3>(channel.mScalingKeys, channel.mNumScalingKeys, seconds,
                                   [&](const aiVector3D& v) { return Vec3(size * to_vec(v)); });
      track.rotation = to_curve<Eigen::Quaterniond>(
          channel.mRotationKeys, channel.mNumRotationKeys, seconds, [](const aiQuaternion& q) {
            return Eigen::Quaterniond(q.w, q.x, q.y, q.z).normalized();
          });
      if (!all_finite(track)) {
        refuse(file, "animation \"" + clip.name + "\" moves \"" + found->first +
                         "\" to where no number is");
      }
      for (const auto* times :
           {&track.translation.times, &track.rotation.times, &track.scale.times}) {
        if (!times->empty()) clip.duration = std::max(clip.duration, times->back());
      }
      clip.tracks.push_back(std::move(track));
    }
    character.animations.push_back(std::move(clip));
  }
}

}  // namespace

Character read_assimp_character(const fs::path& file, double scale, bool with_mesh) {
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene& scene = read_assimp_scene(file, with_mesh, importer);
  Character character;
  const AssimpNodes nodes = collect_bodies(file, scene, scale, character);
  collect_skin(file, scene, nodes, character);
  set_bind_pose(nodes, character);
  collect_animations(file, scene, nodes, scale, character);
  if (with_mesh) note_size(file, character);
  return character;
}

}  // namespace thew::rig
