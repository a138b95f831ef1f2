// SPDX-License-Identifier: Apache-2.0
#include "rig/import/character_parts.h"

#include <algorithm>
#include <cctype>
#include <map>
#include <optional>
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

namespace {

struct Level {
  std::string of;  // the name without it
  int number;
};

std::string lower_of(std::string name) {
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

// "Body_LOD1", "lod01_body"; none in "Melody2".
std::optional<Level> level_in(const std::string& name) {
  const std::string lower = lower_of(name);
  const auto is = [&](size_t i, int (*kind)(int)) {
    return i < lower.size() && kind(static_cast<unsigned char>(lower[i])) != 0;
  };
  for (size_t at = lower.find("lod"); at != std::string::npos; at = lower.find("lod", at + 1)) {
    const bool begins = at == 0 || !is(at - 1, std::isalpha);
    size_t end = at + 3;
    if (end < lower.size() && (lower[end] == '_' || lower[end] == ' ')) ++end;
    const size_t first = end;
    while (is(end, std::isdigit)) ++end;
    if (!begins || end == first || end > first + 2) continue;
    if (at > 0 && !is(at - 1, std::isalnum)) --at;
    return Level{lower.substr(0, at) + lower.substr(end), std::stoi(lower.substr(first))};
  }
  return {};
}

// Of each part, its level; one that has none is the finest of its name.
std::vector<Level> levels_of(const std::vector<MeshPart>& parts) {
  std::vector<Level> levels;
  for (const MeshPart& part : parts) {
    std::optional<Level> level = level_in(part.node);
    if (!level) level = level_in(part.mesh);
    if (!level) level = Level{lower_of(part.node.empty() ? part.mesh : part.node), -1};
    levels.push_back(*level);
  }
  return levels;
}

}  // namespace

void leave_out_coarser(const fs::path& file, Influences& influences, Character& character) {
  const std::vector<Level> levels = levels_of(character.parts);
  std::map<std::string, int> finest;
  for (const Level& level : levels) {
    const auto [known, is_new] = finest.emplace(level.of, level.number);
    if (!is_new) known->second = std::min(known->second, level.number);
  }
  std::set<std::string> coarser;
  const auto is_coarser = [&](size_t p) { return levels[p].number > finest.at(levels[p].of); };
  for (size_t p = 0; p < levels.size(); ++p) {
    const MeshPart& part = character.parts[p];
    if (is_coarser(p)) coarser.insert(part.node.empty() ? part.mesh : part.node);
  }
  if (coarser.empty()) return;
  TriMesh& mesh = character.mesh;
  std::vector<MeshPart> parts;
  std::vector<Vec3> vertices;
  Influences kept;
  std::vector<int> now(mesh.vertices.size(), -1);  // by vertex, its new index
  for (size_t p = 0; p < levels.size(); ++p) {
    if (is_coarser(p)) continue;
    MeshPart part = character.parts[p];
    const size_t end = p + 1 < levels.size() ? character.parts[p + 1].first_vertex : now.size();
    size_t i = part.first_vertex;
    part.first_vertex = static_cast<int>(vertices.size());
    for (; i < end; ++i) {
      now[i] = static_cast<int>(vertices.size());
      vertices.push_back(mesh.vertices[i]);
      kept.push_back(std::move(influences[i]));
    }
    parts.push_back(std::move(part));
  }
  character.warnings.push_back(file.string() + ": left out, coarser levels of detail: " +
                               names_text({coarser.begin(), coarser.end()}));
  std::erase_if(mesh.triangles, [&](const Triangle& t) { return now[t[0]] < 0; });
  for (Triangle& t : mesh.triangles) {
    for (int& i : t) i = now[i];
  }
  mesh.vertices = std::move(vertices);
  character.parts = std::move(parts);
  influences = std::move(kept);
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
