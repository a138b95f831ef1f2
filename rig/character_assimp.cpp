// SPDX-License-Identifier: Apache-2.0
//
// What assimp makes of a file, as a Character. Runs in the child process.
#include <assimp/anim.h>
#include <assimp/config.h>
#include <assimp/mesh.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "rig/assimp_scene.h"
#include "rig/character.h"
#include "rig/gltf_curves.h"
#include "rig/text.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

constexpr double kTicksPerSecond = 25.0;  // where a file names no rate, assimp's convention
constexpr int kDeepest = 10000;           // bodies

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Error(ExitCode::kInput, file.string() + ": " + what + "; export the character again");
}

Vec3 to_vec(const aiVector3D& v) { return {v.x, v.y, v.z}; }

Affine to_affine(const aiMatrix4x4& m) {
  Affine out;
  out.matrix() = to_matrix(m);
  return out;
}

// Nodes, parents before children, in the file's order.
struct Nodes {
  std::vector<const aiNode*> nodes;
  std::map<std::string, int> by_name;
  std::vector<Affine> world;  // at rest
};

// Where a mesh and a bone share a name, as Blender lets them, the bone is meant.
void name_bodies(Nodes& nodes, std::vector<std::string>& names) {
  names.resize(nodes.nodes.size());
  std::set<std::string> taken;
  for (const bool of_meshes : {false, true}) {
    for (size_t i = 0; i < names.size(); ++i) {
      const aiNode& node = *nodes.nodes[i];
      if ((node.mNumMeshes > 0) != of_meshes) continue;
      nodes.by_name.emplace(node.mName.C_Str(), static_cast<int>(i));
      std::string plain = node.mName.C_Str();
      if (plain.empty()) plain = "node_" + std::to_string(i);
      names[i] = plain;
      for (int k = 2; !taken.insert(names[i]).second; ++k) {
        names[i] = plain + "_" + std::to_string(k);
      }
    }
  }
}

Nodes collect_bodies(const fs::path& file, const aiScene& scene, double scale,
                     Character& character) {
  Nodes out;
  std::vector<std::pair<const aiNode*, int>> open = {{scene.mRootNode, -1}};
  while (!open.empty()) {
    const auto [node, parent] = open.back();
    open.pop_back();
    const int index = static_cast<int>(out.nodes.size());
    if (index > kDeepest) refuse(file, "has more than " + std::to_string(kDeepest) + " nodes");
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
  name_bodies(out, character.skeleton.body_names);
  return out;
}

// By vertex: (link, weight).
using Influences = std::vector<std::vector<std::pair<int, double>>>;

// `place`: of the mesh, in the bind pose.
void append_weights(const fs::path& file, const aiMesh& part, const Nodes& nodes,
                    const Affine& place, int first, Influences& influences, Character& character) {
  const Affine to_mesh = place.inverse();
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

// Where the joints at rest put what is bound to the first of them, root before limbs: the bind pose
// stands as the rest pose does.
Affine place_by_joints(const aiMesh& part, const Nodes& nodes) {
  int first = static_cast<int>(nodes.nodes.size());
  Affine place = Affine::Identity();
  for (unsigned b = 0; b < part.mNumBones; ++b) {
    const auto joint = nodes.by_name.find(part.mBones[b]->mName.C_Str());
    if (joint == nodes.by_name.end() || joint->second >= first) continue;
    first = joint->second;
    place = nodes.world[first] * to_affine(part.mBones[b]->mOffsetMatrix);
  }
  return place;
}

// A mesh at a node: its vertices go to where the bind pose has them. A skinned mesh of glTF is
// placed by its joints alone: the transform of its own node is to be ignored (glTF 2.0, 3.7.3.3).
// Blender hangs it under its armature, of any scale and turn.
void append_mesh(const fs::path& file, const aiMesh& part, const Nodes& nodes, int node, bool gltf,
                 Influences& influences, Character& character) {
  const Affine place =
      gltf && part.mNumBones > 0 ? place_by_joints(part, nodes) : nodes.world[node];
  if (!place.matrix().allFinite() || place.linear().determinant() == 0.0) {
    refuse(file, "mesh \"" + std::string(part.mName.C_Str()) + "\" has no sound bind matrices");
  }
  const int first = static_cast<int>(character.mesh.vertices.size());
  character.parts.push_back(part.mName.length > 0 ? part.mName.C_Str()
                                                  : nodes.nodes[node]->mName.C_Str());
  character.first_vertex.push_back(first);
  for (unsigned i = 0; i < part.mNumVertices; ++i) {
    character.mesh.vertices.push_back(place * to_vec(part.mVertices[i]));
    if (character.mesh.vertices.back().allFinite()) continue;
    refuse(file, "mesh \"" + character.parts.back() + "\", vertex " + std::to_string(i) +
                     " is not finite");
  }
  influences.resize(character.mesh.vertices.size());
  append_triangles(file, part, place.linear().determinant() < 0.0, first, character.mesh.triangles);
  append_weights(file, part, nodes, place, first, influences, character);
  // What nobody weighted goes with its node.
  int own = -1;
  for (size_t i = first; i < influences.size(); ++i) {
    if (!influences[i].empty()) continue;
    if (own < 0) {
      own = static_cast<int>(character.skin.links.size());
      character.skin.links.push_back({node, nodes.world[node].inverse()});
    }
    influences[i].push_back({own, 1.0});
  }
  if (own >= 0 && part.mNumBones > 0) {
    character.warnings.push_back(file.string() + ": mesh \"" + character.parts.back() +
                                 "\" has vertices without weights; they go with its node");
  }
}

void collect_skin(const fs::path& file, const aiScene& scene, const Nodes& nodes, bool gltf,
                  Character& character) {
  Influences influences;
  for (size_t n = 0; n < nodes.nodes.size(); ++n) {
    for (unsigned i = 0; i < nodes.nodes[n]->mNumMeshes; ++i) {
      append_mesh(file, *scene.mMeshes[nodes.nodes[n]->mMeshes[i]], nodes, static_cast<int>(n),
                  gltf, influences, character);
    }
  }
  int uneven = 0;
  character.skin.first.push_back(0);
  for (const auto& of_vertex : influences) {
    double sum = 0.0;
    for (const auto& [link, weight] : of_vertex) sum += weight;
    uneven += sum < 0.99 || sum > 1.01;
    for (const auto& [link, weight] : of_vertex) {
      character.skin.link.push_back(link);
      character.skin.weight.push_back(weight / sum);
    }
    character.skin.first.push_back(static_cast<int>(character.skin.link.size()));
  }
  if (uneven > 0) {
    character.warnings.push_back(file.string() + ": the weights of " + std::to_string(uneven) +
                                 " vertices did not sum to 1; they were scaled");
  }
}

// Bodies that bones of the skin name are where their bind matrices say, the others as at rest from
// there.
void set_bind_pose(const Nodes& nodes, Character& character) {
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
    if (!curve.times.empty() && time <= curve.times.back()) continue;  // a second key at one time
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

void collect_animations(const fs::path& file, const aiScene& scene, const Nodes& nodes,
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
      if (found == nodes.by_name.end()) continue;  // a camera's or a light's
      BodyTrack track;
      track.body = found->second;
      const double size = found->second == 0 ? scale : 1.0;  // the root bears the file's scale
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

void warn_of_size(const fs::path& file, Character& character) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : character.mesh.vertices) box.extend(p);
  if (box.isEmpty()) return;
  const double extent = box.sizes().maxCoeff();
  if (extent >= 0.3 && extent <= 3.0) return;
  character.warnings.push_back(
      file.string() + ": is " + number_text(extent) +
      " m large, a person is 1.5 to 2; if its unit is another, give [rig] scale (" +
      number_text(1.7 / extent) + " makes it 1.7 m)");
}

}  // namespace

Character read_character(const fs::path& file, double scale) {
  const bool motion = lower_ending(file) == "bvh";
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_NO_SKELETON_MESHES, true);
  const aiScene& scene = read_assimp_scene(file, !motion, importer);
  Character character;
  const Nodes nodes = collect_bodies(file, scene, scale, character);
  const std::string ending = lower_ending(file);
  const bool gltf = ending == "gltf" || ending == "glb";
  collect_skin(file, scene, nodes, gltf, character);
  set_bind_pose(nodes, character);
  collect_animations(file, scene, nodes, scale, character);
  if (gltf) {
    const auto body_of = [&](const std::string& name) {
      const auto found = nodes.by_name.find(name);
      return found == nodes.by_name.end() ? -1 : found->second;
    };
    mend_gltf_curves(file, scale, body_of, character);
  }
  if (!motion) warn_of_size(file, character);
  return character;
}

}  // namespace thew
