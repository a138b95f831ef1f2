// SPDX-License-Identifier: Apache-2.0
#include "tools/golden_files.h"

#include <nlohmann/json.hpp>

#include "sim/cache.h"
#include "sim/durable_file.h"
#include "tools/compare_geometry.h"
#include "tools/image.h"

namespace thew {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kRecipe = "golden.json";
constexpr std::size_t kLargestRecipe = 1 << 20;  // bytes
constexpr int kSmallest = 9;                     // zlib's level

// What a comparison does not look at, and digits beyond float32, would only be bytes to keep.
void shorten(BakeMesh& mesh) {
  mesh.coordinates.clear();
  for (double& weight : mesh.weights) weight = as_float(weight);
  for (Vec3& p : mesh.rest.vertices) p = p.unaryExpr(&as_float);
}

void keep_bake(const fs::path& file, const fs::path& golden) {
  const BakeReader reader(file);
  BakeInfo info = reader.info();
  info.double_precision = false;
  for (BakeMesh& mesh : info.meshes) shorten(mesh);
  BakeWriter writer(golden, info, false);
  for (std::size_t i = 0; i < info.frames.size(); ++i) {
    writer.write(reader.read(static_cast<int>(i)));
  }
  writer.pack();
}

void keep_pictures(const fs::path& from, const fs::path& to) {
  create_folders(to);
  for (const auto& entry : fs::directory_iterator(to)) {
    if (entry.path().extension() == ".png" && !fs::exists(from / entry.path().filename())) {
      remove_durably(entry.path());
    }
  }
  for (const auto& entry : fs::directory_iterator(from)) {
    if (entry.path().extension() != ".png") continue;
    write_png(to / entry.path().filename(), read_png(entry.path()), kSmallest);
  }
}

}  // namespace

bool has_goldens(const fs::path& golden) { return fs::exists(golden / kRecipe); }

GoldenRecipe read_recipe(const fs::path& golden) {
  const fs::path file = golden / kRecipe;
  if (!fs::exists(file)) {
    throw Error(ExitCode::kInput, file.string() +
                                      ": there are no goldens; make them with thew "
                                      "golden update SCENE --golden " +
                                      golden.string());
  }
  try {
    const ordered_json recipe = ordered_json::parse(read_whole_file(file, kLargestRecipe));
    return {recipe.at("frames"), recipe.at("set")};
  } catch (const ordered_json::exception& error) {
    throw Error(ExitCode::kInput,
                file.string() + ": " + error.what() + "; remove it and make the goldens anew");
  }
}

void keep_goldens(const fs::path& baked, const GoldenRecipe& recipe, const fs::path& golden) {
  create_folders(golden);
  keep_bake(baked / "bake.h5", golden);
  keep_pictures(baked / "frames", golden / "frames");
  const ordered_json out = {{"frames", recipe.frames}, {"set", recipe.set}};
  write_durably(golden / kRecipe, out.dump(2) + "\n");
}

}  // namespace thew
