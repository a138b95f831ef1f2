// SPDX-License-Identifier: Apache-2.0
//
// A character's glTF file with its skin as baked. All of the file stays as it is, but the meshes
// that muscles move, the animations, and the skins that are no longer needed:
//  - by itself: such a mesh has no skin; a morph target for each frame holds it as baked, in the
//    frame of its node, which moves as the skeleton does;
//  - with correctives: it keeps its skin, and a morph target for each frame, or a basis of them,
//    holds what muscles add to its weights, before these carry it.
#include <algorithm>
#include <map>
#include <stdexcept>

#include "rig/text.h"
#include "tools/base/output_file.h"
#include "tools/export/character_skin.h"
#include "tools/export/formats.h"
#include "tools/export/gltf/gltf.h"
#include "tools/export/gltf/gltf_bodies.h"
#include "tools/export/gltf/gltf_document.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

struct Work {
  const Shot& shot;
  const OntoOptions& options;
  CharacterSkin skin;
  std::vector<Shape> corrected = {}, baked = {};       // by frame; see character_skin.h
  std::map<int, std::vector<std::size_t>> parts = {};  // by node that has a mesh
  std::vector<int> moved = {};                         // nodes with a mesh that muscles move
  Glb glb = {};
  std::vector<bool> skins = {};        // by node of the file, whether it has a skin
  std::size_t times = 0, targets = 0;  // accessor of the times; the most targets of a mesh
  World world = {};                    // of the bodies, as a reader of the file finds them
  Deviation deviation = {};
};

void find_meshes(Work& work) {
  const Character& character = work.skin.character;
  for (std::size_t p = 0; p < character.parts.size(); ++p) {
    work.parts[character.parts[p].node_index].push_back(p);
  }
  for (const auto& [node, parts] : work.parts) {
    const bool moved = std::any_of(parts.begin(), parts.end(), [&](std::size_t p) {
      const auto begin = work.skin.moved.begin();
      return std::count(begin + character.parts[p].first_vertex, begin + end_of_part(character, p),
                        1) > 0;
    });
    if (moved) work.moved.push_back(node);
  }
}

int body_of_node(const Character& character, int node) {
  const auto found = std::find(character.nodes.begin(), character.nodes.end(), node);
  return static_cast<int>(found - character.nodes.begin());
}

void append(const Shape& from, Shape& to) {
  to.positions.insert(to.positions.end(), from.positions.begin(), from.positions.end());
  to.normals.insert(to.normals.end(), from.normals.begin(), from.normals.end());
}

// Some of the vertices of a shape, from `first` on.
Shape stretch_of(const Shape& shape, std::size_t first, std::size_t count) {
  const auto cut = [&](const std::vector<Vec3>& values) {
    const auto begin = values.begin() + static_cast<std::ptrdiff_t>(first);
    return std::vector<Vec3>(begin, begin + static_cast<std::ptrdiff_t>(count));
  };
  return {cut(shape.positions), cut(shape.normals)};
}

std::size_t vertices_of(const Character& character, std::size_t part) {
  return static_cast<std::size_t>(end_of_part(character, part) -
                                  character.parts[part].first_vertex);
}

// The vertices of some parts, one after another.
Shape of_parts(const Character& character, const std::vector<std::size_t>& parts,
               const Shape& shape) {
  Shape out;
  for (const std::size_t p : parts) {
    append(stretch_of(shape, static_cast<std::size_t>(character.parts[p].first_vertex),
                      vertices_of(character, p)),
           out);
  }
  return out;
}

void transform(const Affine& by, Shape& shape) {
  const Mat3 normals = by.linear().inverse().transpose();
  for (Vec3& p : shape.positions) p = by * p;
  for (Vec3& n : shape.normals) n = (normals * n).normalized();
}

Affine rest_world(const Character& character, int body) {
  Affine world = character.rest[body];
  for (int b = character.skeleton.parent[body]; b >= 0; b = character.skeleton.parent[b]) {
    world = character.rest[b] * world;
  }
  return world;
}

/// The shapes of a mesh in the frame in which its vertices stand in the file.
struct MeshShapes {
  Shape base;
  std::vector<Shape> frames;
  bool new_base = false;  // the base is not what the file has
};

// Whether weights, or the node that it hangs on, carry the mesh in the file that is written.
bool is_carried(const Work& work, int node) {
  return work.options.correctives || !work.skins.at(static_cast<std::size_t>(node));
}

MeshShapes shapes_of(const Work& work, int node) {
  const Character& character = work.skin.character;
  const std::vector<std::size_t>& parts = work.parts.at(node);
  MeshShapes out;
  out.base = of_parts(character, parts, work.skin.raw);
  if (is_carried(work, node)) {
    for (const Shape& shape : work.corrected) {
      out.frames.push_back(of_parts(character, parts, shape));
    }
    return out;
  }
  const int body = body_of_node(character, node);
  const Affine to_node = rest_world(character, body).inverse();
  out.base = {};
  for (const std::size_t p : parts) {
    constexpr double kSame = 1e-6;  // of a unit
    const Affine move = to_node * character.parts[p].to_bind;
    Shape part = of_parts(character, {p}, work.skin.raw);
    if ((move.matrix() - Affine::Identity().matrix()).norm() > kSame) {
      out.new_base = true;
      transform(move, part);
    }
    append(part, out.base);
  }
  for (std::size_t f = 0; f < work.baked.size(); ++f) {
    transform(work.world[f][body].inverse(),
              out.frames.emplace_back(of_parts(character, parts, work.baked[f])));
  }
  return out;
}

// The vertices that any target of this stretch of them moves or turns.
SparseIndices touched(const Morphs& morphs, std::size_t first, std::size_t count) {
  SparseIndices indices;
  for (std::size_t v = first; v < first + count; ++v) {
    const bool any =
        std::any_of(morphs.targets.begin(), morphs.targets.end(), [&](const Shape& target) {
          return !target.positions[v].isZero(0.0) || !target.normals[v].isZero(0.0);
        });
    if (any) indices.among.push_back(static_cast<std::uint32_t>(v - first));
  }
  if (indices.among.empty()) indices.among.push_back(0);
  return indices;
}

void add_targets(Glb& glb, const Morphs& morphs, bool new_base, std::size_t first,
                 std::size_t count, ordered_json& primitive) {
  ordered_json& attributes = primitive.at("attributes");
  const bool shaded = attributes.contains("NORMAL");
  if (new_base) {
    const Shape base = stretch_of(morphs.base, first, count);
    attributes["POSITION"] = add_vectors(glb, base.positions, true);
    if (shaded) attributes["NORMAL"] = add_vectors(glb, base.normals, false);
  }
  SparseIndices indices = touched(morphs, first, count);
  ordered_json& targets = list_at(primitive, "targets");
  for (const Shape& target : morphs.targets) {
    const Shape part = stretch_of(target, first, count);
    ordered_json written = {{"POSITION", add_sparse_vectors(glb, part.positions, indices, true)}};
    if (shaded) written["NORMAL"] = add_sparse_vectors(glb, part.normals, indices, false);
    targets.push_back(written);
  }
}

// The weights that the mesh of a node has by itself, of the morph targets of the file.
std::vector<float> own_weights(const ordered_json& node, const ordered_json& mesh) {
  std::vector<float> weights;
  const ordered_json& from = node.contains("weights") ? node : mesh;
  if (from.contains("weights")) weights = from["weights"].get<std::vector<float>>();
  weights.resize(count_targets(mesh), 0.0f);
  return weights;
}

void put_weights(Work& work, int number, const std::vector<float>& own, const Morphs& morphs,
                 ordered_json& animation) {
  ordered_json& node = work.glb.json["nodes"].at(number);
  ordered_json& mesh = work.glb.json["meshes"].at(node.at("mesh").get<std::size_t>());
  std::vector<float> all;
  for (const std::vector<float>& weights : morphs.weights) {
    all.insert(all.end(), own.begin(), own.end());
    all.insert(all.end(), weights.begin(), weights.end());
  }
  add_channel(animation, static_cast<std::size_t>(number), "weights", work.times,
              add_keys(work.glb, all));
  // Without an animation: as the file is, or at the first frame where that is all there is.
  std::vector<float> still = own;
  still.resize(own.size() + morphs.targets.size(), 0.0f);
  if (!work.options.correctives) still.assign(all.begin(), all.begin() + still.size());
  mesh["weights"] = still;
  node.erase("weights");
  ordered_json& names = list_at(object_at(mesh, "extras"), "targetNames");
  while (names.size() < own.size()) names.push_back("target " + std::to_string(names.size() + 1));
  for (const std::string& name : morphs.names) names.push_back(name);
}

// Adds to the deviation what a reader makes of a mesh that these morph targets move.
void measure(Work& work, int node, const Morphs& morphs, const std::vector<Shape>& frames) {
  const CharacterSkin& skin = work.skin;
  const std::vector<std::size_t>& parts = work.parts.at(node);
  const bool carried = is_carried(work, node) || frames.empty();
  const int body = body_of_node(skin.character, node);
  for (std::size_t f = 0; f < work.world.size(); ++f) {
    const Shape read = morphed(morphs, f);
    std::vector<Affine> of_links;
    link_transforms(skin.character.skin, work.world[f], of_links);
    std::size_t at = 0;
    for (const std::size_t p : parts) {
      const MeshPart& part = skin.character.parts[p];
      for (int v = part.first_vertex; v < end_of_part(skin.character, p); ++v, ++at) {
        const Affine carry =
            carried ? blended_transform(skin.character.skin, of_links, v) * part.to_bind
                    : work.world[f][body];
        work.deviation.add(skin.scale * (carry * read.positions[at]), skin.scale * skin.baked[f][v],
                           part.mesh, work.shot.frame(f), static_cast<std::size_t>(v));
      }
    }
    for (std::size_t v = 0; !frames.empty() && v < read.normals.size(); ++v) {
      work.deviation.add_normal(read.normals[v], frames[f].normals[v]);
    }
  }
}

void put_morphs(Work& work, int node, ordered_json& animation) {
  const MeshShapes shapes = shapes_of(work, node);
  std::vector<std::string> names;
  for (std::size_t f = 0; f < shapes.frames.size(); ++f) {
    names.push_back("frame " + std::to_string(work.shot.frame(f)));
  }
  const int basis = work.options.basis;
  const Morphs morphs = basis > 0 ? basis_morphs(shapes.base, shapes.frames, names, basis)
                                  : exact_morphs(shapes.base, shapes.frames, names);
  measure(work, node, morphs, shapes.frames);
  ordered_json& json = work.glb.json;
  const auto mesh = json["nodes"].at(node).at("mesh").get<std::size_t>();
  const std::vector<float> own = own_weights(json["nodes"][node], json["meshes"].at(mesh));
  work.targets = std::max(work.targets, own.size() + morphs.targets.size());
  check_targets(work.options.file, work.targets);
  std::size_t first = 0;
  for (const std::size_t p : work.parts.at(node)) {
    const std::size_t count = vertices_of(work.skin.character, p);
    ordered_json& primitive =
        json["meshes"][mesh].at("primitives").at(work.skin.character.parts[p].primitive);
    add_targets(work.glb, morphs, shapes.new_base, first, count, primitive);
    first += count;
  }
  if (!morphs.targets.empty()) put_weights(work, node, own, morphs, animation);
}

// Takes from the document what the bake replaces.
void clear_document(Work& work) {
  ordered_json& json = work.glb.json;
  separate_meshes(work.glb, work.moved);
  for (const ordered_json& node : json.at("nodes")) work.skins.push_back(node.contains("skin"));
  if (work.options.correctives) {
    remove_weight_channels(work.glb, work.moved);
  } else {
    json["animations"] = ordered_json::array();
    for (const int node : work.moved) {
      if (work.skins.at(static_cast<std::size_t>(node))) make_static(work.glb, node);
    }
    remove_unused_skins(work.glb);
  }
  drop_unused(work.glb);
}

void write_document(Work& work) {
  clear_document(work);
  ordered_json& json = work.glb.json;
  ordered_json animation = {{"name", one_line(work.shot.info().scene_name)},
                            {"channels", ordered_json::array()},
                            {"samplers", ordered_json::array()}};
  const auto carried = [&](int node) { return is_carried(work, node); };
  const auto count = std::count_if(work.moved.begin(), work.moved.end(), carried);
  if (count > 0) work.corrected = corrected_shapes(work.skin);
  if (count < static_cast<std::ptrdiff_t>(work.moved.size())) {
    work.baked = world_shapes(work.skin);
  }
  work.times = add_keys(work.glb, seconds_of(work.shot));
  work.world = animate_bodies(work.skin, work.times, work.glb, animation);
  for (const auto& [node, parts] : work.parts) {
    if (std::find(work.moved.begin(), work.moved.end(), node) != work.moved.end()) {
      put_morphs(work, node, animation);
    } else {
      measure(work, node, {of_parts(work.skin.character, parts, work.skin.raw), {}, {}, {}}, {});
    }
  }
  json["animations"].insert(json["animations"].begin(), animation);
  if (animation["channels"].empty()) json["animations"].erase(0);
  if (json["animations"].empty()) json.erase("animations");
  for (const auto& [name, value] : facts_of(work.shot)) {
    object_at(json["asset"], "extras")[name] = value;
  }
  if (work.skin.scale != 1.0) {
    json["asset"]["extras"]["units"] =
        "as in the character's file, " + digits(work.skin.scale) + " m of the bake each";
  }
  put_errors(work.deviation, json["asset"]);
}

Exported put_onto(const Shot& shot, const OntoOptions& options) {
  const GltfSource source = read_gltf_source(options.character);
  Work work{.shot = shot,
            .options = options,
            .skin = read_character_skin(shot, options.character, source),
            .glb = open_document(source)};
  find_meshes(work);
  write_document(work);
  write_glb(options.file, work.glb);
  std::string note = "onto " + options.character.string() + "; " + time_note(shot) +
                     std::to_string(work.moved.size()) + " of " +
                     std::to_string(work.parts.size()) + " meshes moved by muscles, " +
                     targets_note(work.targets, shot.places.size(), options.basis) +
                     error_note(work.deviation);
  for (const std::string& warning : source.warnings) note += "\n  " + warning;
  return {{options.file}, note};
}

}  // namespace

Exported export_glb_onto(const Shot& shot, const OntoOptions& options) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kInput,
                options.character.string() + what + "; export the character again");
  };
  check_targets(options.file, options.basis > 0 ? 0 : shot.places.size());
  try {
    return put_onto(shot, options);
  } catch (const nlohmann::json::exception& error) {
    refuse(": its JSON is not built as glTF has it (" + printable(error.what()) + ")");
  } catch (const std::out_of_range&) {
    refuse(": it names an accessor, a view or a mesh that it does not have");
  }
  return {};
}

}  // namespace thew::tools
