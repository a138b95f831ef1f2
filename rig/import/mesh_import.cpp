// SPDX-License-Identifier: Apache-2.0
#include "rig/import/mesh_import.h"

#include <assimp/fast_atof.h>

#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "rig/import/assimp_scene.h"
#include "rig/import/child.h"
#include "rig/import/packed.h"
#include "rig/import/text_numbers.h"
#include "rig/limits.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

constexpr size_t kPlyHeaderLimit = size_t{1} << 16;  // bytes; real headers have some hundred

struct Raw {
  TriMesh mesh;
  std::vector<std::array<float, 4>> colours;  // by vertex; white where a part has none
  int coloured = 0;                           // vertices that have one
};

// Appends the triangles of one mesh under the transform m of its node; one that mirrors reverses
// their winding.
void append(const fs::path& file, const aiMesh& part, const Eigen::Matrix4d& m, Raw& raw) {
  TriMesh& mesh = raw.mesh;
  const int first = static_cast<int>(mesh.vertices.size());
  const int count = static_cast<int>(part.mNumVertices);
  const Mat3 linear = m.topLeftCorner<3, 3>();
  const Vec3 shift = m.topRightCorner<3, 1>();
  const bool plain = m.isIdentity(0.0);
  for (int i = 0; i < count; ++i) {
    const Vec3 p(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
    mesh.vertices.push_back(plain ? p : linear * p + shift);
    std::array<float, 4> colour = {1, 1, 1, 1};
    if (const aiColor4D* c = part.mColors[0]) {
      colour = {c[i].r, c[i].g, c[i].b, c[i].a};
      ++raw.coloured;
    }
    raw.colours.push_back(colour);
    if (mesh.vertices.back().allFinite()) continue;
    refuse_file(file, "mesh \"" + std::string(part.mName.C_Str()) + "\", vertex " +
                          std::to_string(i) + " is not finite: " +
                          point_text(mesh.vertices.back()) + "; export the mesh again");
  }
  const bool mirrored = linear.determinant() < 0.0;
  append_triangles(file, part, mirrored, first, mesh.triangles);
}

// All triangles of all nodes, depth first and in the file's order.
Raw collect(const fs::path& file, const aiScene& scene) {
  Raw mesh;
  std::vector<std::pair<const aiNode*, Eigen::Matrix4d>> open;
  open.emplace_back(scene.mRootNode, to_matrix(scene.mRootNode->mTransformation));
  while (!open.empty()) {
    const auto [node, in_world] = open.back();
    open.pop_back();
    for (unsigned i = 0; i < node->mNumMeshes; ++i) {
      append(file, *scene.mMeshes[node->mMeshes[i]], in_world, mesh);
    }
    for (unsigned i = node->mNumChildren; i-- > 0;) {
      const aiNode* child = node->mChildren[i];
      open.emplace_back(child, in_world * to_matrix(child->mTransformation));
    }
  }
  return mesh;
}

using Position = std::array<float, 3>;

// The exception that assimp's inline reader of numbers throws here; its own type is not exported.
struct NoNumber {
  template <typename... What>
  explicit NoNumber(const What&...) {}
};

struct ObjLines {
  std::vector<Position> positions;  // of the vertices, in the order of the file
  std::vector<int> corners;         // vertex of each corner of the faces, in the order of the file
};

// Reads vertices and faces of an OBJ, its numbers as assimp reads them, so that positions compare
// equal. Empty if a vertex is not understood.
ObjLines read_obj_lines() {
  const std::string bytes = read_in_child(file_of_child(), kAssimpFileLimit);
  ObjLines lines;
  const auto add_face = [&](const std::vector<std::string_view>& words) {
    for (size_t k = 1; k < words.size(); ++k) {
      const int number =
          std::atoi(std::string(words[k]).c_str());  // counts from 1, or from -1 backwards
      const int count = static_cast<int>(lines.positions.size());
      lines.corners.push_back(number < 0 ? count + number : number - 1);
    }
  };
  for (size_t begin = 0; begin < bytes.size();) {
    const size_t end = std::min(bytes.find('\n', begin), bytes.size());
    const auto words = split_words(std::string_view(bytes).substr(begin, end - begin));
    begin = end + 1;
    if (!words.empty() && words[0] == "f") add_face(words);
    if (words.empty() || words[0] != "v") continue;
    if (words.size() < 4) return {};
    Position p;
    for (int k = 0; k < 3; ++k) {
      if (!parse_number(words[k + 1])) return {};
      p[k] = Assimp::fast_atof<NoNumber>(std::string(words[k + 1]).c_str());
    }
    lines.positions.push_back(p);
  }
  return lines;
}

// assimp makes a vertex of each corner of the faces of an OBJ, in their order. This restores the
// vertices of the file in their order, by position, without those that no face uses. A corner gets
// the vertex that its face names if assimp kept the faces of the file, else the first vertex of its
// position.
void restore_order(Raw& raw) {
  const std::vector<Vec3>& corners = raw.mesh.vertices;
  const auto position_of = [&](size_t i) {
    const Eigen::Vector3f p = corners[i].cast<float>();
    return Position{p.x(), p.y(), p.z()};
  };
  std::map<Position, size_t> corner_at;
  for (size_t i = 0; i < corners.size(); ++i) corner_at.emplace(position_of(i), i);
  Raw ordered;
  std::map<Position, int> vertex_at;
  const auto add = [&](const Position& position, size_t corner) {
    const int vertex = static_cast<int>(ordered.mesh.vertices.size());
    vertex_at.emplace(position, vertex);
    ordered.mesh.vertices.push_back(corners[corner]);
    ordered.colours.push_back(raw.colours[corner]);
    return vertex;
  };
  const ObjLines lines = read_obj_lines();
  std::vector<int> of_line;
  for (const Position& position : lines.positions) {
    const auto corner = corner_at.find(position);
    of_line.push_back(corner == corner_at.end() ? -1 : add(position, corner->second));
  }
  std::vector<int> of_corner;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Position position = position_of(i);
    if (vertex_at.count(position) == 0) add(position, i);
    const int line = lines.corners.size() == corners.size() ? lines.corners[i] : -1;
    const bool own =
        line >= 0 && line < static_cast<int>(of_line.size()) && lines.positions[line] == position;
    of_corner.push_back(own ? of_line[line] : vertex_at.at(position));
  }
  for (const Triangle& t : raw.mesh.triangles) {
    ordered.mesh.triangles.push_back({of_corner[t[0]], of_corner[t[1]], of_corner[t[2]]});
  }
  ordered.coloured = raw.coloured;
  raw = std::move(ordered);
}

Raw read_through_assimp(const fs::path& file) {
  check_text_numbers(file, read_in_child(file_of_child(), kAssimpFileLimit));
  Assimp::Importer importer;
  Raw raw = collect(file, read_assimp_scene(file, true, importer));
  if (lower_ending(file) == "obj") restore_order(raw);
  return raw;
}

// assimp 5.2 never stops searching for the end of a header, and allocates whatever number of
// elements the header claims. So both are checked first.
void check_ply_header(const fs::path& file) {
  const std::string bytes = read_whole(file, kAssimpFileLimit);
  const std::string_view head = std::string_view(bytes).substr(0, kPlyHeaderLimit);
  for (size_t begin = 0; begin < head.size();) {
    const size_t end = std::min(head.find('\n', begin), head.size());
    const auto words = split_words(head.substr(begin, end - begin));
    begin = end + 1;
    if (words.size() == 1 && words[0] == "end_header") return;
    if (words.size() != 3 || words[0] != "element") continue;
    const auto count = parse_number(words[2]);
    if (!count || !(*count >= 0.0 && *count <= static_cast<double>(bytes.size()))) {
      refuse_file(file, "claims " + std::string(words[2]) + " of \"" + std::string(words[1]) +
                            "\" in " + std::to_string(bytes.size()) + " bytes; export it again");
    }
  }
  refuse_file(file, "its header does not end; the file is cut short, export it again");
}

template <typename Archive>
void walk(Archive& archive, Raw& raw) {
  archive.list(raw.mesh.vertices);
  archive.list(raw.mesh.triangles);
  archive.list(raw.colours);
  archive.number(raw.coloured);
}

// Where meshes are read, because assimp 5.2 hangs or crashes on some damaged files of all formats.
struct MeshReader : Child {
  explicit MeshReader(const fs::path& file)
      : Child(file, "export it again, for instance as OBJ", [](std::string_view name) {
          Raw mesh = read_through_assimp(fs::path(name));
          Packer packer;
          walk(packer, mesh);
          return packer.bytes;
        }) {}
};

Raw read_by(Child& child, const fs::path& file) {
  const std::string bytes = child.ask(file.native());
  Raw raw;
  Unpacker unpacker{bytes};
  walk(unpacker, raw);
  const TriMesh& mesh = raw.mesh;
  const auto nodes = static_cast<int>(mesh.vertices.size());
  const bool sound =
      unpacker.finished() && raw.colours.size() == mesh.vertices.size() &&
      std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](int i) { return i >= 0 && i < nodes; });
      });
  if (!sound) child.refuse("its reader sent nonsense");
  // The unit is not known here, so the bound is that of the smallest unit.
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    if (is_bounded(mesh.vertices[i], kMaxCoordinate / kMinScale)) continue;
    refuse_file(file, "vertex " + std::to_string(i) + " lies at " + point_text(mesh.vertices[i]) +
                          ", which is no place in any unit; export the mesh again");
  }
  return raw;
}

thread_local bool is_shared = false;
thread_local std::unique_ptr<MeshReader> shared_reader;

Raw read_in_child(const fs::path& file) {
  constexpr std::uintmax_t kMostShared = std::uintmax_t{8} << 20;  // bytes
  std::error_code error;
  if (!is_shared || fs::file_size(file, error) > kMostShared) {
    MeshReader reader(file);
    return read_by(reader, file);
  }
  if (shared_reader) {
    try {
      shared_reader->turn_to(file);
      return read_by(*shared_reader, file);
    } catch (const Error&) {  // of this file's making or of an earlier one's: another is asked
      shared_reader.reset();
    }
  }
  auto reader = std::make_unique<MeshReader>(file);
  const Raw raw = read_by(*reader, file);
  shared_reader = std::move(reader);
  return raw;
}

FileOrder file_order(const Raw& raw, const std::vector<int>& map_back) {
  FileOrder order{map_back, {}};
  for (const Triangle& t : raw.mesh.triangles) {
    const int a = map_back[t[0]], b = map_back[t[1]], c = map_back[t[2]];
    if (a != b && b != c && c != a) order.triangles.push_back(t);
  }
  return order;
}

}  // namespace

SharedReader::SharedReader() : first_(!std::exchange(is_shared, true)) {}

SharedReader::~SharedReader() {
  if (!first_) return;
  is_shared = false;
  shared_reader.reset();
}

ImportedMesh import_mesh(const fs::path& file) {
  const std::string ending = lower_ending(file);
  const char* known[] = {"obj", "stl", "ply", "gltf", "glb", "fbx", "dae"};
  if (std::find(std::begin(known), std::end(known), ending) == std::end(known)) {
    refuse_file(file, "meshes ending in \"." + ending +
                          "\" are not read; save it as OBJ, STL, PLY, glTF, FBX or Collada");
  }
  check_readable(file, kAssimpFileLimit);
  if (ending == "ply") check_ply_header(file);
  const Raw raw = read_in_child(file);
  if (raw.mesh.triangles.empty())
    refuse_file(file, "holds no triangles; export the mesh with its faces");
  WeldResult welded = weld(raw.mesh);
  ImportedMesh out{std::move(welded.mesh),
                   std::move(welded.map_back),
                   static_cast<int>(raw.mesh.vertices.size()),
                   {},
                   {}};
  const bool has_order = ending == "obj" || ending == "ply" || ending == "gltf" || ending == "glb";
  if (has_order && out.mesh.vertices.size() < out.map_back.size()) {
    out.order = file_order(raw, out.map_back);
  }
  if (raw.coloured == 0) return out;
  out.colours.resize(out.mesh.vertices.size());
  for (size_t i = out.map_back.size(); i-- > 0;) {  // of vertices of one position the first decides
    out.colours[out.map_back[i]] = raw.colours[i];
  }
  return out;
}

void check_positions(const fs::path& file, const std::vector<Vec3>& positions) {
  for (size_t i = 0; i < positions.size(); ++i) {
    if (is_bounded(positions[i])) continue;
    check_position(positions[i], file.string() + ": vertex " + std::to_string(i),
                   "export the mesh in metres, or scale it");
  }
}

void check_closed(const std::string& where, const TriMesh& mesh, Pieces pieces) {
  std::vector<Defect> defects = find_defects(mesh);
  if (pieces == Pieces::kAny) {
    std::erase_if(defects, [](const Defect& d) { return d.kind == Defect::kSeveralComponents; });
  }
  if (defects.empty()) return;
  std::string message = where + ": is not a sound closed surface";
  for (const Defect& d : defects) {
    message += std::string("\n  ") + defect_name(d.kind) + ": " + std::to_string(d.count) +
               ", first " + d.where + "; " + d.fix;
  }
  throw Error(ErrorCode::kInput, message);
}

ImportedMesh import_closed_mesh_whole(const fs::path& file, const Eigen::Affine3d& to_world,
                                      Pieces pieces) {
  ImportedMesh imported = import_mesh(file);
  if (!to_world.matrix().isIdentity(0.0)) {
    for (Vec3& p : imported.mesh.vertices) p = to_world * p;
    if (to_world.linear().determinant() < 0.0) {  // it mirrors
      for (Triangle& t : imported.mesh.triangles) std::swap(t[1], t[2]);
      for (Triangle& t : imported.order.triangles) std::swap(t[1], t[2]);
    }
  }
  check_positions(file, imported.mesh.vertices);
  check_closed(file.string(), imported.mesh, pieces);
  return imported;
}

TriMesh import_closed_mesh(const fs::path& file, const Eigen::Affine3d& to_world) {
  return std::move(import_closed_mesh_whole(file, to_world).mesh);
}

TriMesh import_bone(const fs::path& file) {
  return std::move(import_closed_mesh_whole(file, Eigen::Affine3d::Identity(), Pieces::kAny).mesh);
}

}  // namespace thew::rig
