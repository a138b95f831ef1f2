// SPDX-License-Identifier: Apache-2.0
#include "tools/export/character_skin.h"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "rig/import/character_import.h"
#include "rig/math.h"
#include "rig/text.h"

namespace thew::tools {
namespace {

constexpr double kMoved = 1e-6;         // m; float32 rounds positions of a bake by a tenth of it
constexpr double kSamePlace = 1e-6;     // m, of a mesh at rest
constexpr double kSameNormal = 0.9998;  // cosine of 1 degree

Affine from_bake(const BodyFrame& body, double scale) {
  Affine world = Affine::Identity();
  world.matrix().topRows<3>() =
      Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(body.data()) / scale;
  return world;
}

std::vector<Affine> from_bake(const std::vector<BodyFrame>& bodies, double scale) {
  std::vector<Affine> world;
  for (const BodyFrame& body : bodies) world.push_back(from_bake(body, scale));
  return world;
}

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& what) {
  throw Error(ErrorCode::kInput, file.string() + ": is not the character of the bake: " + what +
                                     "; give --onto the file that was baked");
}

void check_rest(const Shot& shot, const std::filesystem::path& file, const Character& character) {
  const BakeCharacter& of = shot.info().character;
  const std::vector<Vec3>& rest = shot.info().meshes[skin_mesh(shot.info())].rest.vertices;
  if (rest.size() != character.mesh.vertices.size()) {
    refuse(file, "its meshes have " + std::to_string(character.mesh.vertices.size()) +
                     " vertices, and the bake's skin has " + std::to_string(rest.size()));
  }
  if (of.rest.size() != character.bind.size()) {
    refuse(file, "it has " + std::to_string(character.bind.size()) + " nodes, and the bake's has " +
                     std::to_string(of.rest.size()));
  }
  Points x;
  skin_vertices(character.skin, character.mesh, from_bake(of.rest, of.scale), x);
  double farthest = 0.0;
  std::size_t where = 0;
  for (std::size_t v = 0; v < rest.size(); ++v) {
    const double apart = (of.scale * to_vec(x[v]) - rest[v]).norm();
    if (apart > farthest) farthest = apart, where = v;
  }
  if (farthest <= kSamePlace) return;
  refuse(file, "its vertex " + std::to_string(where) + " lies " + number_text(1e3 * farthest) +
                   " mm from the bake's at rest");
}

// The positions and normals of the file, by vertex.
void read_raw(const std::filesystem::path& file, const GltfSource& source, CharacterSkin& skin) {
  const auto json = nlohmann::json::parse(source.json);
  std::map<int, const std::vector<Vec3>*> vectors;
  for (const auto& of : source.vectors) vectors[of.accessor] = &of.values;
  const std::size_t count = skin.character.mesh.vertices.size();
  skin.raw.positions.resize(count);
  skin.raw.normals.assign(count, Vec3::Zero());
  for (std::size_t p = 0; p < skin.character.parts.size(); ++p) {
    const MeshPart& part = skin.character.parts[p];
    const auto& attributes =
        json.at("meshes").at(part.mesh_index).at("primitives").at(part.primitive).at("attributes");
    const auto first = static_cast<std::size_t>(part.first_vertex),
               vertices = static_cast<std::size_t>(end_of_part(skin.character, p)) - first;
    const auto put = [&](const char* name, std::vector<Vec3>& to) {
      const auto found = vectors.find(attributes.at(name).get<int>());
      if (found == vectors.end() || found->second->size() != vertices) {
        refuse(file, std::string("it has not as many of ") + name + " as vertices");
      }
      std::copy(found->second->begin(), found->second->end(),
                to.begin() + static_cast<std::ptrdiff_t>(first));
    };
    put("POSITION", skin.raw.positions);
    if (attributes.contains("NORMAL")) put("NORMAL", skin.raw.normals);
  }
}

void find_moved(CharacterSkin& skin) {
  const Character& character = skin.character;
  skin.moved.assign(character.mesh.vertices.size(), 0);
  for (std::size_t f = 0; f < skin.baked.size(); ++f) {
    Points x;
    skin_vertices(character.skin, character.mesh, skin.bodies[f], x);
    for (std::size_t v = 0; v < x.size(); ++v) {
      if (skin.scale * (to_vec(x[v]) - skin.baked[f][v]).norm() > kMoved) skin.moved[v] = 1;
    }
  }
}

// By vertex its normal in the bind pose.
std::vector<Vec3> bind_normals(const CharacterSkin& skin) {
  std::vector<Vec3> normals = skin.raw.normals;
  for (std::size_t p = 0; p < skin.character.parts.size(); ++p) {
    const Mat3 turn = skin.character.parts[p].to_bind.linear().inverse().transpose();
    for (int v = skin.character.parts[p].first_vertex; v < end_of_part(skin.character, p); ++v) {
      normals[v] = (turn * normals[v]).normalized();
    }
  }
  return normals;
}

// Vertices are shaded as one where the file has them at one place with one normal.
void find_seams(const std::vector<Vec3>& normals, CharacterSkin& skin) {
  const std::vector<int>& map_back = skin.character.map_back;
  std::vector<std::vector<int>> first(map_back.size());  // by place, of each normal
  for (std::size_t v = 0; v < map_back.size(); ++v) {
    std::vector<int>& of_place = first[map_back[v]];
    const auto same = std::find_if(of_place.begin(), of_place.end(), [&](int other) {
      return normals[v].isZero(0.0) ? normals[other].isZero(0.0)
                                    : normals[v].dot(normals[other]) > kSameNormal;
    });
    skin.seam.push_back(same == of_place.end() ? static_cast<int>(v) : *same);
    if (same == of_place.end()) of_place.push_back(static_cast<int>(v));
  }
}

// The normals of the surface: by vertex that is the first of its seam, by area.
std::vector<Vec3> surface_normals(const CharacterSkin& skin, const std::vector<Vec3>& x) {
  std::vector<Vec3> normals(x.size(), Vec3::Zero());
  for (const Triangle& t : skin.character.mesh.triangles) {
    const Vec3 area = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
    for (const int v : t) normals[skin.seam[v]] += area;
  }
  for (Vec3& normal : normals) normal.normalize();
  return normals;
}

/// What all frames share.
struct Correction {
  std::vector<Vec3> normals, surface;  // in the bind pose, of the file and of its triangles
  std::vector<char> beside;            // by first vertex of a seam, whether its surface changes
};

Correction begin_correction(const CharacterSkin& skin) {
  Correction out{bind_normals(skin), surface_normals(skin, skin.character.mesh.vertices), {}};
  out.beside.assign(skin.moved.size(), 0);
  for (const Triangle& t : skin.character.mesh.triangles) {
    if (!skin.moved[t[0]] && !skin.moved[t[1]] && !skin.moved[t[2]]) continue;
    for (const int v : t) out.beside[skin.seam[v]] = 1;
  }
  return out;
}

Shape corrected_shape(const CharacterSkin& skin, const Correction& correction, std::size_t f) {
  const Character& character = skin.character;
  std::vector<Affine> of_links;
  link_transforms(character.skin, skin.bodies[f], of_links);
  std::vector<Vec3> bind = character.mesh.vertices;
  for (std::size_t v = 0; v < bind.size(); ++v) {
    if (!skin.moved[v]) continue;
    const Affine blend = blended_transform(character.skin, of_links, static_cast<int>(v));
    bind[v] += bounded_inverse(blend.linear()) * (skin.baked[f][v] - blend * bind[v]);
  }
  const std::vector<Vec3> surface = surface_normals(skin, bind);
  Shape shape = skin.raw;
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    const Affine& to_bind = character.parts[p].to_bind;
    const Affine to_raw = to_bind.inverse();
    for (int v = character.parts[p].first_vertex; v < end_of_part(character, p); ++v) {
      if (skin.moved[v]) shape.positions[v] = to_raw * bind[v];
      const int first = skin.seam[v];
      if (!correction.beside[first] || correction.normals[v].isZero(0.0)) continue;
      const Mat3 turn = least_turn(correction.surface[first], surface[first]);
      shape.normals[v] =
          (to_bind.linear().transpose() * (turn * correction.normals[v])).normalized();
    }
  }
  return shape;
}

}  // namespace

int skin_mesh(const BakeInfo& info) {
  for (std::size_t m = 0; m < info.meshes.size(); ++m) {
    if (info.meshes[m].kind == BakeMesh::Kind::kSkin) return static_cast<int>(m);
  }
  return -1;
}

int end_of_part(const Character& character, std::size_t part) {
  return part + 1 < character.parts.size() ? character.parts[part + 1].first_vertex
                                           : static_cast<int>(character.mesh.vertices.size());
}

CharacterSkin read_own_character(const Shot& shot, const std::filesystem::path& file,
                                 const GltfSource& source) {
  const BakeInfo& info = shot.info();
  if (info.character.rest.empty() || skin_mesh(info) < 0) {
    throw Error(ErrorCode::kUsage,
                "--onto " + file.string() +
                    ": the bake has no character's own skin, or is of an earlier version; bake a "
                    "scene of a character whose skin is \"skinned\", or leave --onto out");
  }
  CharacterSkin skin;
  skin.character = import_character(file);
  skin.scale = info.character.scale;
  check_rest(shot, file, skin.character);
  read_raw(file, source, skin);
  find_seams(bind_normals(skin), skin);
  return skin;
}

CharacterSkin read_character_skin(const Shot& shot, const std::filesystem::path& file,
                                  const GltfSource& source) {
  CharacterSkin skin = read_own_character(shot, file, source);
  for (const ShotFrame& frame : all_frames(shot)) {
    skin.bodies.push_back(from_bake(frame.bodies, skin.scale));
    std::vector<Vec3>& x = skin.baked.emplace_back(frame.positions[0]);
    for (Vec3& p : x) p /= skin.scale;
  }
  find_moved(skin);
  return skin;
}

std::vector<Shape> corrected_shapes(const CharacterSkin& skin) {
  const Correction correction = begin_correction(skin);
  std::vector<Shape> shapes;
  for (std::size_t f = 0; f < skin.baked.size(); ++f) {
    shapes.push_back(corrected_shape(skin, correction, f));
  }
  return shapes;
}

std::vector<Shape> world_shapes(const CharacterSkin& skin) {
  const Character& character = skin.character;
  const Correction correction = begin_correction(skin);
  std::vector<Shape> shapes;
  for (std::size_t f = 0; f < skin.baked.size(); ++f) {
    std::vector<Affine> of_links;
    link_transforms(character.skin, skin.bodies[f], of_links);
    const std::vector<Vec3> surface = surface_normals(skin, skin.baked[f]);
    Shape& shape = shapes.emplace_back(Shape{skin.baked[f], correction.normals});
    for (std::size_t v = 0; v < shape.normals.size(); ++v) {
      const int first = skin.seam[v];
      // A blend turns the normal roughly, as its weights change from place to place; the way from
      // there to the surface is short.
      const Mat3 carry =
          bounded_inverse(blended_transform(character.skin, of_links, first).linear()).transpose();
      const Vec3 carried = (carry * correction.surface[first]).normalized();
      shape.normals[v] =
          least_turn(carried, surface[first]) * (carry * shape.normals[v]).normalized();
    }
  }
  return shapes;
}

}  // namespace thew::tools
