// SPDX-License-Identifier: Apache-2.0
#include "tools/inspect/draw_maps.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rig/text.h"
#include "sim/cache/own_files.h"
#include "sim/scene/define_model.h"
#include "sim/scene/model.h"
#include "tools/base/text.h"
#include "tools/render/contact_sheet.h"
#include "tools/render/renderer.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 640, kHeight = 480;
// The scale of colours: its right edge, width, top and height in pixels, and the size of a dot of
// its numbers.
constexpr int kRight = 16, kBar = 24, kTop = 40, kTall = 400, kDot = 2;

struct Map {
  std::string mesh, quantity;
  const TriMesh* on;
  std::vector<double> values;
};

// The shader's colours of weights, light as it is stored.
std::array<std::uint8_t, 3> colour_at(double share) {
  constexpr double k[4][3] = {
      {0.93, 0.92, 0.87}, {0.95, 0.72, 0.36}, {0.80, 0.27, 0.22}, {0.33, 0.07, 0.24}};
  const double t = 3.0 * std::clamp(share, 0.0, 1.0);
  const int from = std::min(static_cast<int>(t), 2);
  std::array<std::uint8_t, 3> rgb;
  for (int c = 0; c < 3; ++c) {
    const double value = k[from][c] + (t - from) * (k[from + 1][c] - k[from][c]);
    rgb[c] = static_cast<std::uint8_t>(std::lround(255.0 * value));
  }
  return rgb;
}

void draw_scale(double least, double most, Image& image) {
  const int left = image.width - kRight - kBar;
  for (int y = 0; y < kTall; ++y) {
    const auto rgb = colour_at(1.0 - y / (kTall - 1.0));
    for (int x = left; x < left + kBar; ++x) {
      std::copy(rgb.begin(), rgb.end(),
                image.rgb.begin() + 3l * ((std::int64_t{1} * kTop + y) * image.width + x));
    }
  }
  for (int k = 0; k <= 4; ++k) {
    const std::string number = readable(most + (least - most) * k / 4.0, 4);
    const int wide = kDot * (4 * static_cast<int>(number.size()) + 1);
    write_text(number, left - 6 - wide, kTop + kTall * k / 4 - 3 * kDot, kDot, image);
  }
}

void add(const std::string& mesh, const std::string& quantity, const TriMesh& on,
         const std::vector<double>& values, std::vector<Map>& maps) {
  if (values.size() == on.vertices.size()) maps.push_back({mesh, quantity, &on, values});
}

std::vector<Map> maps_of(const ModelDef& def) {
  std::vector<Map> maps;
  for (const MuscleDef& muscle : def.muscles) {
    add(muscle.name, "weights", muscle.mesh, muscle.weights, maps);
    add(muscle.name, "stiffness", muscle.mesh, muscle.stiffness, maps);
  }
  for (const auto& [name, values] : def.contact.thicknesses) {
    for (const MuscleDef& muscle : def.muscles) {
      if (muscle.name == name) add(name, "thickness", muscle.mesh, values, maps);
    }
    for (const Bone& bone : def.bones) {
      if (bone.name == name) add(name, "thickness", bone.in_body, values, maps);
    }
  }
  const TriMesh& skin = def.skin.skinned ? def.character->character.mesh : def.skin.mesh;
  add("skin", "fat", skin, def.skin.maps.fat, maps);
  add("skin", "slide", skin, def.skin.maps.slide, maps);
  std::erase_if(maps, [](const Map& map) {
    return map.quantity != "weights" &&
           std::all_of(map.values.begin(), map.values.end(),
                       [&](double value) { return value == map.values[0]; });
  });
  return maps;
}

// From the side on which the mesh is widest, a little from above.
SceneView view_of(const TriMesh& mesh) {
  constexpr double kAngle = 30.0;  // degrees
  Vec3 low = mesh.vertices[0], high = low;
  for (const Vec3& p : mesh.vertices) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vec3 size = high - low, middle = 0.5 * (low + high);
  const Vec3 from = size.x() >= size.z() ? Vec3(0.35, 0.25, 1.0) : Vec3(1.0, 0.25, 0.35);
  SceneView view;
  view.name = view.show = "weights";
  view.target = middle;
  view.eye = middle + 2.2 * size.norm() * from.normalized();
  view.field_of_view = kAngle;
  return view;
}

}  // namespace

std::vector<DrawnMap> draw_maps(const Scene& scene, const fs::path& folder, bool overwrite) {
  const ModelDef def = define_model(scene);
  const std::vector<Map> maps = maps_of(def);
  if (maps.empty()) {
    throw Error(ErrorCode::kUsage, scene.file.string() +
                                       ": has no map and no muscle; give one, as "
                                       "`thew inspect --keys` explains");
  }
  std::vector<DrawnMap> drawn;
  std::vector<fs::path> files;
  for (const Map& map : maps) {
    files.push_back(folder / (map.mesh + "." + map.quantity + ".png"));
    DrawnMap one{map.mesh, map.quantity, 1e300, -1e300, files.back()};
    for (const double value : map.values) {
      if (value < 0.0) continue;
      one.least = std::min(one.least, value), one.most = std::max(one.most, value);
    }
    drawn.push_back(one);
  }
  claim_folder(folder);
  claim(files, overwrite);
  for (size_t m = 0; m < maps.size(); ++m) {
    const auto& [mesh, quantity, least, most, picture] = drawn[m];
    BakeMesh one{mesh, BakeMesh::Kind::kMuscle, *maps[m].on, maps[m].values, {}};
    std::erase_if(one.rest.triangles, [&](const Triangle& t) {  // as modelled: nothing is drawn
      return std::any_of(t.begin(), t.end(), [&](int i) { return one.weights[i] < 0.0; });
    });
    // The renderer's scale ends at 2.
    for (double& w : one.weights) w = most > least ? 2.0 * (w - least) / (most - least) : 1.0;
    const std::vector<BakeMesh> meshes = {one};
    Image image = Renderer(kWidth, kHeight, meshes).draw(view_of(one.rest), {one.rest.vertices});
    draw_scale(least, most, image);
    write_png(picture, image);
  }
  return drawn;
}

}  // namespace thew::tools
