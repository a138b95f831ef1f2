// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "rig/api/arrays.h"
#include "rig/text.h"
#include "sim/cache/cache.h"
#include "thew/cache.h"

namespace thew {

struct Bake::Data {
  explicit Data(const std::filesystem::path& path) : file(path.string()), reader(path) {
    const sim::BakeInfo& info = reader.info();
    contents = {info.scene_name, info.hash, info.fps, info.frames, {}, info.metric_names};
    for (const sim::BakeMesh& mesh : info.meshes) {
      const auto kind = static_cast<BakedMesh::Kind>(mesh.kind);  // both have them in one order
      contents.meshes.push_back({mesh.name, kind, rig::to_mesh(mesh.rest), mesh.weights});
    }
  }

  // Where a name is in a list of them.
  int place_of(const std::string& name, const std::vector<std::string>& names,
               const char* kind) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found != names.end()) return static_cast<int>(found - names.begin());
    throw Error(ErrorCode::kUsage, file + ": there is no " + kind + " \"" + name + "\"" +
                                       rig::did_you_mean(name, names));
  }

  std::string file;
  sim::BakeReader reader;
  BakeContents contents;
};

Bake::Bake(const std::filesystem::path& file) : data_(std::make_unique<Data>(file)) {}
Bake::~Bake() = default;
Bake::Bake(Bake&&) noexcept = default;
Bake& Bake::operator=(Bake&&) noexcept = default;

const BakeContents& Bake::contents() const { return data_->contents; }

std::vector<double> Bake::positions(const std::string& mesh, int frame) const {
  std::vector<std::string> names;
  for (const BakedMesh& one : data_->contents.meshes) names.push_back(one.name);
  const int place = data_->place_of(mesh, names, "mesh");
  const std::vector<int>& frames = data_->contents.frames;
  const auto found = std::find(frames.begin(), frames.end(), frame);
  if (found == frames.end()) {
    throw Error(ErrorCode::kUsage,
                data_->file + ": frame " + std::to_string(frame) + " was not baked; there are " +
                    std::to_string(frames.size()) + " from " + std::to_string(frames.front()) +
                    " to " + std::to_string(frames.back()));
  }
  return rig::to_array(data_->reader.read_mesh(static_cast<int>(found - frames.begin()), place));
}

std::vector<double> Bake::measure(const std::string& name) const {
  return data_->reader.metric(data_->place_of(name, data_->contents.measures, "measure"));
}

}  // namespace thew
