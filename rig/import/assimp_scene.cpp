// SPDX-License-Identifier: Apache-2.0
#include "rig/import/assimp_scene.h"

#include <assimp/BaseImporter.h>
#include <assimp/config.h>
#include <assimp/importerdesc.h>
#include <assimp/postprocess.h>
#include <unistd.h>

#include <algorithm>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <cstring>
#include <new>
#include <utility>

#include "rig/import/child.h"
#include "rig/text.h"

namespace thew::rig {
namespace {

namespace fs = std::filesystem;

// The bytes of a file that was read as a whole, so that assimp never has a handle.
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
    const size_t target =
        base +
        offset;  // a negative offset arrives as a large unsigned number, and the sum wraps around
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

// Gives assimp the files that the child may open and no others, because glTF buffers and OBJ
// material libraries may name any path.
class ConfinedFiles : public Assimp::IOSystem {
 public:
  explicit ConfinedFiles(std::string& refused) : refused_(refused) {}
  bool Exists(const char* name) const override {
    const OpenFile file = open_in_child(name);
    if (file.descriptor >= 0) ::close(file.descriptor);
    return file.descriptor >= 0;
  }
  char getOsSeparator() const override { return '/'; }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    if (std::strpbrk(mode, "wa+")) return nullptr;
    try {
      return new Bytes(read_in_child(name, kAssimpFileLimit));
    } catch (const Error&) {
      if (refused_.empty()) refused_ = name;
      return nullptr;
    }
  }
  void Close(Assimp::IOStream* stream) override { delete stream; }

 private:
  std::string& refused_;  // the first name that was not opened
};

bool serves(const Assimp::BaseImporter& importer, const std::string& ending) {
  for (const std::string_view word : split_words(importer.GetInfo()->mFileExtensions)) {
    if (word == ending) return true;
  }
  return false;
}

// Keeps only the importers for the ending of the file, so that assimp does not guess by content.
void keep_importers(Assimp::Importer& importer, const std::string& ending) {
  for (size_t i = importer.GetImporterCount(); i-- > 0;) {
    Assimp::BaseImporter* candidate = importer.GetImporter(i);
    if (serves(*candidate, ending)) continue;
    importer.UnregisterLoader(candidate);
    delete candidate;
  }
}

// The header of an FBX file tells which axes point right, up and to the front. assimp 5.2 ignores
// it, so the scene is turned here until these are X, Y and Z.
void turn_upright(const aiScene& scene) {
  aiMatrix4x4 turn;
  int row = 0;
  unsigned axes_found = 0;
  for (const char* axis : {"CoordAxis", "UpAxis", "FrontAxis"}) {
    int along = -1, sign = 0;
    if (!scene.mMetaData || !scene.mMetaData->Get(axis, along) ||
        !scene.mMetaData->Get(std::string(axis) + "Sign", sign) || along < 0 || along > 2) {
      return;
    }
    for (int k = 0; k < 3; ++k) turn[row][k] = k != along ? 0.0f : sign < 0 ? -1.0f : 1.0f;
    axes_found |= 1u << along;
    ++row;
  }
  if (axes_found != 7) return;  // two directions name one axis
  scene.mRootNode->mTransformation = turn * scene.mRootNode->mTransformation;
}

}  // namespace

Eigen::Matrix4d to_matrix(const aiMatrix4x4& m) {
  Eigen::Matrix4d result;
  for (int i = 0; i < 4; ++i) {
    for (int k = 0; k < 4; ++k) result(i, k) = m[i][k];
  }
  return result;
}

std::string lower_ending(const fs::path& file) {
  std::string ending = file.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  for (char& c : ending) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return ending;
}

const aiScene& read_assimp_scene(const fs::path& file, bool with_meshes,
                                 Assimp::Importer& importer) {
  const std::string ending = lower_ending(file);
  std::string refused;
  importer.SetIOHandler(new ConfinedFiles(refused));  // the importer owns it
  keep_importers(importer, ending);
  importer.SetPropertyInteger(AI_CONFIG_PP_SBP_REMOVE,
                              aiPrimitiveType_POINT | aiPrimitiveType_LINE);
  // The header of an FBX file gives its unit, usually the centimetre, which GlobalScale applies.
  // JoinIdenticalVertices is not used, because it joins vertices that are near, and weld() those
  // that are equal.
  const unsigned steps = (with_meshes ? aiProcess_Triangulate | aiProcess_SortByPType : 0u) |
                         (ending == "fbx" ? unsigned{aiProcess_GlobalScale} : 0u);
  const aiScene* scene = nullptr;
  std::string cause;
  try {
    scene = importer.ReadFile(file_of_child().string(), steps);
    cause = importer.GetErrorString();
  } catch (const std::exception& error) {
    cause = error.what();
  }
  if (cause == "std::bad_alloc") throw std::bad_alloc();  // assimp caught the exception
  if (scene && scene->mRootNode && (!with_meshes || scene->HasMeshes())) {
    if (ending == "fbx") turn_upright(*scene);
    return *scene;
  }
  if (!refused.empty()) {
    cause += (cause.empty() ? "" : "; ") + ("it needs \"" + refused) +
             "\", which is no regular file in its folder";
  }
  throw Error(ErrorCode::kInput, file.string() + ": cannot be read as ." + ending + " (" +
                                     (cause.empty() ? "no mesh" : cause) +
                                     "); export it again, for instance as OBJ");
}

void append_triangles(const std::filesystem::path& file, const aiMesh& part, bool mirrored,
                      int first, std::vector<Triangle>& triangles) {
  for (unsigned f = 0; f < part.mNumFaces; ++f) {
    const aiFace& face = part.mFaces[f];
    if (face.mNumIndices != 3) continue;  // points and lines
    Triangle t;
    for (int k = 0; k < 3; ++k) {
      if (face.mIndices[k] >= part.mNumVertices) {
        throw Error(ErrorCode::kInput,
                    file.string() + ": mesh \"" + part.mName.C_Str() + "\", face " +
                        std::to_string(f) + " names vertex " + std::to_string(face.mIndices[k]) +
                        " of " + std::to_string(part.mNumVertices) + "; export the mesh again");
      }
      t[k] = first + static_cast<int>(face.mIndices[k]);
    }
    if (mirrored) std::swap(t[1], t[2]);
    triangles.push_back(t);
  }
}

}  // namespace thew::rig
