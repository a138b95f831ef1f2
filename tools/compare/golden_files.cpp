// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/golden_files.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "sim/cache/cache.h"
#include "sim/cache/durable_file.h"
#include "tools/base/temporary_folder.h"
#include "tools/compare/geometry.h"
#include "tools/render/image.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kRecipe = "golden.json";
constexpr const char* kBake = "bake.h5";
constexpr std::size_t kLargestGolden = std::size_t{1} << 34;  // bytes
constexpr std::size_t kLargestRecipe = 1 << 20;               // bytes
constexpr int kSmallest = 9;                                  // zlib's level

// What a comparison does not look at, and digits beyond float32, would only be bytes to keep.
void shorten(BakeMesh& mesh) {
  mesh.coordinates.clear();
  for (double& weight : mesh.weights) weight = as_float(weight);
  for (Vec3& p : mesh.rest.vertices) p = p.unaryExpr(&as_float);
}

// By way of a folder of its own: a bake's list of its files is nothing to keep in a repository.
void keep_bake(const fs::path& file, const fs::path& golden) {
  const BakeReader reader(file);
  BakeInfo info = reader.info();
  info.double_precision = false;
  for (BakeMesh& mesh : info.meshes) shorten(mesh);
  const TemporaryFolder folder("golden");
  BakeWriter writer(folder.path(), info, false);
  for (std::size_t i = 0; i < info.frames.size(); ++i) {
    writer.write(reader.read(static_cast<int>(i)));
  }
  writer.pack();
  replace_durably(golden / kBake, read_whole_file(folder.path() / kBake, kLargestGolden));
}

// Those that Thew drew.
std::vector<std::string> pictures_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& [name, about] : own_files(folder)) {
    if (name.ends_with(".png") && fs::exists(folder / name)) names.push_back(name);
  }
  return names;
}

}  // namespace

bool has_goldens(const fs::path& golden) { return fs::exists(golden / kRecipe); }

GoldenRecipe read_recipe(const fs::path& golden) {
  const fs::path file = golden / kRecipe;
  if (!fs::exists(file)) {
    throw Error(ErrorCode::kInput, file.string() +
                                       ": there are no goldens; make them with thew "
                                       "golden update SCENE --golden " +
                                       golden.string());
  }
  try {
    const ordered_json recipe = ordered_json::parse(read_whole_file(file, kLargestRecipe));
    return {recipe.at("frames"), recipe.at("set"),
            recipe.value("pictures", std::vector<std::string>{})};
  } catch (const ordered_json::exception& error) {
    throw Error(ErrorCode::kInput,
                file.string() + ": " + error.what() + "; remove it and make the goldens anew");
  }
}

void check_goldens(const fs::path& golden, bool overwrite) {
  check_replaceable(golden / kRecipe, fs::file_type::regular);
  check_replaceable(golden / kBake, fs::file_type::regular);
  check_replaceable(golden / "frames", fs::file_type::directory);
  if (!overwrite && !has_goldens(golden) && fs::exists(golden / kBake)) {
    refuse_foreign(golden / kBake);
  }
}

void keep_goldens(const fs::path& baked, const GoldenRecipe& recipe, const fs::path& golden,
                  bool overwrite) {
  const fs::path from = baked / "frames", to = golden / "frames";
  check_goldens(golden, overwrite);
  create_folders(to);
  const std::vector<std::string> now = pictures_in(from);
  const std::vector<std::string> before =
      has_goldens(golden) ? read_recipe(golden).pictures : std::vector<std::string>{};
  const auto has = [](const std::vector<std::string>& names, const std::string& name) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  for (const std::string& name : now) {
    check_replaceable(to / name, fs::file_type::regular);
    if (!overwrite && !has(before, name) && fs::exists(to / name)) refuse_foreign(to / name);
  }
  keep_bake(baked / kBake, golden);
  for (const std::string& name : now) {
    replace_durably(to / name, png_bytes(read_png(from / name), kSmallest));
  }
  const ordered_json out = {{"frames", recipe.frames}, {"set", recipe.set}, {"pictures", now}};
  replace_durably(golden / kRecipe, out.dump(2) + "\n");
  for (const std::string& name : before) {  // last: listed until it is gone
    if (fs::path(name).filename() == name && !has(now, name)) remove_file(to / name);
  }
}

}  // namespace thew::tools
