// SPDX-License-Identifier: Apache-2.0
#include "rig/import/character_parts.h"

#include <algorithm>
#include <set>

#include "rig/text.h"

namespace thew::rig {

namespace fs = std::filesystem;

void name_bodies(const std::vector<std::string>& plain, const std::vector<char>& has_mesh,
                 Skeleton& skeleton) {
  std::vector<std::string>& names = skeleton.body_names;
  names.resize(plain.size());
  std::set<std::string> taken;
  for (const bool of_meshes : {false, true}) {
    for (size_t i = 0; i < names.size(); ++i) {
      if ((has_mesh[i] != 0) != of_meshes) continue;
      names[i] = plain[i];
      for (int k = 2; !taken.insert(names[i]).second; ++k) {
        names[i] = plain[i] + "_" + std::to_string(k);
      }
    }
  }
}

int append_part(const fs::path& file, const MeshPart& about, const std::vector<Vec3>& vertices,
                const std::vector<Triangle>& triangles, const Affine& to_world,
                Influences& influences, Character& character) {
  const auto fail = [&](const std::string& what) {
    throw Error(ErrorCode::kInput, file.string() + ": mesh \"" + about.mesh + "\"" + what +
                                       "; export the character again");
  };
  const double turned = to_world.linear().determinant();
  if (!to_world.matrix().allFinite() || turned == 0.0) fail(" has no sound bind matrices");
  TriMesh& mesh = character.mesh;
  const int first = static_cast<int>(mesh.vertices.size());
  character.parts.push_back(about);
  character.parts.back().first_vertex = first;
  character.parts.back().to_bind = to_world;
  for (size_t i = 0; i < vertices.size(); ++i) {
    mesh.vertices.push_back(to_world * vertices[i]);
    if (!mesh.vertices.back().allFinite()) fail(", vertex " + std::to_string(i) + " is not finite");
  }
  for (Triangle t : triangles) {
    if (turned < 0.0) std::swap(t[1], t[2]);
    for (int& i : t) i += first;
    mesh.triangles.push_back(t);
  }
  influences.resize(mesh.vertices.size());
  return first;
}

void attach_unweighted(const fs::path& file, int first, int body, const Affine& bind, bool skinned,
                       Influences& influences, Character& character) {
  int own = -1;
  for (size_t i = first; i < influences.size(); ++i) {
    if (!influences[i].empty()) continue;
    if (own < 0) {
      own = static_cast<int>(character.skin.links.size());
      character.skin.links.push_back({body, bind.inverse()});
    }
    influences[i].push_back({own, 1.0});
  }
  if (own < 0 || !skinned) return;
  character.warnings.push_back(file.string() + ": mesh \"" + character.parts.back().mesh +
                               "\" has vertices without weights; they go with \"" +
                               character.skeleton.body_names[body] + "\"");
}

void put_weights(const fs::path& file, const Influences& influences, Character& character) {
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

void note_size(const fs::path& file, Character& character) {
  Eigen::AlignedBox3d box;
  for (const Vec3& p : character.mesh.vertices) box.extend(p);
  if (box.isEmpty()) return;
  const double extent = box.sizes().maxCoeff();
  if (extent >= 0.3 && extent <= 3.0) return;
  character.size_doubt = file.string() + ": is " + number_text(extent) +
                         " m large, a person is 1.5 to 2; if its unit is another, give [rig] "
                         "scale (" +
                         number_text(1.7 / extent) + " makes it 1.7 m)";
}

}  // namespace thew::rig
