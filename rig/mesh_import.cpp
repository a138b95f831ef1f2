// SPDX-License-Identifier: Apache-2.0
#include "rig/mesh_import.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <cstring>
#include <utility>

#include "rig/child.h"
#include "rig/packed.h"
#include "rig/text.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

constexpr size_t kFileLimit = size_t{256} << 20;     // bytes
constexpr size_t kPlyHeaderLimit = size_t{1} << 16;  // bytes

[[noreturn]] void refuse(const fs::path& file, const std::string& what) {
  throw Error(ExitCode::kInput, file.string() + ": " + what);
}

// A file read as a whole: assimp never holds a handle.
class Bytes : public Assimp::IOStream {
 public:
  explicit Bytes(std::string bytes) : bytes_(std::move(bytes)) {}
  size_t Read(void* to, size_t size, size_t count) override {
    if (size == 0) return 0;
    const size_t whole = std::min(count, (bytes_.size() - at_) / size);
    std::memcpy(to, bytes_.data() + at_, whole * size);
    at_ += whole * size;
    return whole;
  }
  size_t Write(const void*, size_t, size_t) override { return 0; }
  aiReturn Seek(size_t offset, aiOrigin origin) override {
    const size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? at_ : bytes_.size();
    const size_t target = base + offset;  // a negative offset arrives wrapped, and wraps back
    if (target > bytes_.size()) return aiReturn_FAILURE;
    at_ = target;
    return aiReturn_SUCCESS;
  }
  size_t Tell() const override { return at_; }
  size_t FileSize() const override { return bytes_.size(); }
  void Flush() override {}

 private:
  std::string bytes_;
  size_t at_ = 0;
};

// Opens regular files of one folder (and below) for reading, and nothing else: glTF buffers and
// OBJ material libraries may name any path.
class ConfinedFiles : public Assimp::IOSystem {
 public:
  ConfinedFiles(fs::path folder, std::string& refused)
      : folder_(std::move(folder)), refused_(refused) {}
  bool Exists(const char* name) const override {
    std::error_code error;
    const fs::path file = fs::canonical(folder_ / name, error);  // an absolute name replaces it
    return !error && is_below(file, folder_) && fs::is_regular_file(file, error);
  }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (std::strpbrk(mode, "wa+")) return nullptr;
    if (!Exists(name)) {
      if (refused_.empty()) refused_ = name;
      return nullptr;
    }
    return new Bytes(read_whole(fs::canonical(folder_ / name), kFileLimit));
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  fs::path folder_;
  std::string& refused_;  // the first name that was not opened
};

bool serves(const Assimp::BaseImporter& importer, const std::string& ending) {
  for (const std::string_view word : split_words(importer.GetInfo()->mFileExtensions)) {
    if (word == ending) return true;
  }
  return false;
}

// Only the importers of the file's own ending remain: no guessing by content.
void keep_importers(Assimp::Importer& importer, const std::string& ending) {
  for (size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* candidate = importer.GetImporter(i);
    if (serves(*candidate, ending)) continue;
    importer.UnregisterLoader(candidate);
    delete candidate;
  }
}

Eigen::Matrix4d to_matrix(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) result(i, k) = m[i][k];
  }
  return result;
}

// Appends the triangles of one mesh under its node's transform; a mirroring one turns them round.
void append(const fs::path& file, const aiMesh& part, const Eigen::Matrix4d& m, TriMesh& mesh) {
  const int first = static_cast<int>(mesh.vertices.size());
  const int count = static_cast<int>(part.mNumVertices);
  const Mat3 linear = m.topLeftCorner<3, 3>();
  const Vec3 shift = m.topRightCorner<3, 1>();
  const bool plain = m.isIdentity(0.0);
  for (int i = 0; i < count; ++i) {
    const Vec3 p(part.mVertices[i].x, part.mVertices[i].y, part.mVertices[i].z);
    mesh.vertices.push_back(plain ? p : linear * p + shift);
    if (mesh.vertices.back().allFinite()) continue;
    refuse(file, "mesh \"" + std::string(part.mName.C_Str()) + "\", vertex " + std::to_string(i) +
                     " is not finite: " + point_text(mesh.vertices.back()) +
                     "; export the mesh again");
  }
  const bool mirrored = linear.determinant() < 0.0;
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    Triangle t;
    for (int k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= part.mNumVertices) {
        refuse(file, "mesh \"" + std::string(part.mName.C_Str()) + "\", face " + std::to_string(f) +
                         " names vertex " + std::to_string(face.mIndices[k]) + " of " +
                         std::to_string(count) + "; export the mesh again");
      }
      t[k] = first + static_cast<int>(face.mIndices[k]);
    }
    if (mirrored) std::swap(t[1], t[2]);
    mesh.triangles.push_back(t);
  }
}

// All triangles of all nodes, depth first and in the file's order.
TriMesh collect(const fs::path& file, const aiScene& scene) {
  TriMesh mesh;
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

std::string lower_ending(const fs::path& file) {
  std::string ending = file.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  for (char& c : ending) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return ending;
}

TriMesh read_through_assimp(const fs::path& file, const std::string& ending) {
  const fs::path real = fs::canonical(file);
  std::string refused;
  Assimp::Importer importer;
  importer.SetIOHandler(new ConfinedFiles(real.parent_path(), refused));  // the importer owns it
  keep_importers(importer, ending);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // FBX says its unit, usually the centimetre, in its header. Never JoinIdenticalVertices: it joins
  // by nearness, the weld by equality.
  const unsigned steps = aiProcess_Triangulate | aiProcess_SortByPType |
                         (ending == "fbx" ? unsigned{aiProcess_GlobalScale} : 0u);
  const aiScene* scene = nullptr;
  std::string cause;
  try {
    scene = importer.ReadFile(real.string(), steps);
    cause = importer.GetErrorString();
  } catch (const std::exception& error) {
    cause = error.what();
  }
  if (!scene || !scene->mRootNode || !scene->HasMeshes()) {
    if (!refused.empty()) {
      cause += (cause.empty() ? "" : "; ") + ("it needs \"" + refused) +
               "\", which is no regular file in its folder";
    }
    refuse(file, "cannot be read as ." + ending + " (" + (cause.empty() ? "no mesh" : cause) +
                     "); export it again, for instance as OBJ");
  }
  return collect(file, *scene);
}

// assimp searches a header without an end for ever, and sets aside what a header claims.
void check_ply_header(const fs::path& file) {
  const std::string bytes = read_whole(file, kFileLimit);
  const std::string_view head = std::string_view(bytes).substr(0, kPlyHeaderLimit);
  for (size_t begin = 0; begin < head.size();) {
    const size_t end = std::min(head.find('\n', begin), head.size());
    const auto words = split_words(head.substr(begin, end - begin));
    begin = end + 1;
    if (words.size() == 1 && words[0] == "end_header") return;
    if (words.size() != 3 || words[0] != "element") continue;
    const auto count = parse_number(words[2]);
    if (!count || !(*count >= 0.0 && *count <= static_cast<double>(bytes.size()))) {
      refuse(file, "claims " + std::string(words[2]) + " of \"" + std::string(words[1]) + "\" in " +
                       std::to_string(bytes.size()) + " bytes; export it again");
    }
  }
  refuse(file, "its header does not end; the file is cut short, export it again");
}

template <typename Archive>
void walk(Archive& archive, TriMesh& mesh) {
  archive.list(mesh.vertices);
  archive.list(mesh.triangles);
}

// assimp 5.2 hangs and crashes on some damaged files of all formats.
TriMesh read_in_child(const fs::path& file, const std::string& ending) {
  Child child(file, "export it again, for instance as OBJ", [&](std::string_view) {
    TriMesh mesh = read_through_assimp(file, ending);
    Packer packer;
    walk(packer, mesh);
    return packer.bytes;
  });
  const std::string bytes = child.ask();
  TriMesh mesh;
  Unpacker unpacker{bytes};
  walk(unpacker, mesh);
  const auto nodes = static_cast<int>(mesh.vertices.size());
  const bool sound =
      unpacker.finished() &&
      std::all_of(mesh.vertices.begin(), mesh.vertices.end(),
                  [](const Vec3& p) { return p.allFinite(); }) &&
      std::all_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const Triangle& t) {
        return std::all_of(t.begin(), t.end(), [&](int i) { return i >= 0 && i < nodes; });
      });
  if (!sound) child.refuse("its reader sent nonsense");
  return mesh;
}

}  // namespace

ImportedMesh import_mesh(const fs::path& file) {
  const std::string ending = lower_ending(file);
  const char* known[] = {"obj", "stl", "ply", "gltf", "glb", "fbx", "dae"};
  if (std::find(std::begin(known), std::end(known), ending) == std::end(known)) {
    refuse(file, "meshes ending in \"." + ending +
                     "\" are not read; save it as OBJ, STL, PLY, glTF, FBX or Collada");
  }
  check_readable(file, kFileLimit);
  if (ending == "ply") check_ply_header(file);
  const TriMesh raw = read_in_child(file, ending);
  if (raw.triangles.empty()) refuse(file, "holds no triangles; export the mesh with its faces");
  WeldResult welded = weld(raw);
  return {std::move(welded.mesh), std::move(welded.map_back),
          static_cast<int>(raw.vertices.size())};
}

TriMesh import_closed_mesh(const fs::path& file) {
  ImportedMesh imported = import_mesh(file);
  const std::vector<Defect> defects = find_defects(imported.mesh);
  if (defects.empty()) return std::move(imported.mesh);
  std::string message = "is not a sound closed surface";
  for (const Defect& d : defects) {
    message += std::string("\n  ") + defect_name(d.kind) + ": " + std::to_string(d.count) +
               ", first " + d.where + "; " + d.fix;
  }
  refuse(file, message);
}

}  // namespace thew
