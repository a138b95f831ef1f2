// SPDX-License-Identifier: Apache-2.0
#include "tools/pictures.h"

#include <chrono>
#include <cstdio>
#include <fstream>

#include "sim/hash.h"
#include "tools/contact_sheet.h"

namespace thew {
namespace {

std::string drawn_line(const std::string& bake, int width, int height,
                       const std::vector<SceneView>& views) {
  Hash hash;
  hash.add(bake);
  const auto number = [&](double value) { hash.add(&value, sizeof value); };
  number(width);
  number(height);
  for (const SceneView& view : views) {
    hash.add(view.name);
    hash.add(view.show);
    for (const Vec3* v : {&view.eye, &view.target, &view.up}) {
      hash.add(v->data(), 3 * sizeof(double));
    }
    number(view.field_of_view);
  }
  return hash.hex();
}

}  // namespace

Pictures::Pictures(const std::filesystem::path& folder, const std::string& bake, int width,
                   int height, const std::vector<SceneView>& views,
                   const std::vector<BakeMesh>& meshes)
    : folder_(folder), width_(width), height_(height), views_(views), meshes_(meshes) {
  std::error_code code;
  std::filesystem::create_directories(folder, code);
  if (code) {
    throw Error(ExitCode::kOutput,
                folder.string() + ": cannot be made: " + code.message() + "; choose another --out");
  }
  const std::filesystem::path note = folder / ".drawn";
  const std::string drawn = drawn_line(bake, width, height, views);
  std::string before;
  std::ifstream(note) >> before;
  if (before == drawn) return;
  for (const SceneView& view : views) {  // of another bake or camera: not to be mistaken for these
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(view.name + ".") && name.ends_with(".png")) {
        std::filesystem::remove(entry.path(), code);
      }
    }
  }
  std::ofstream(note) << drawn << "\n";
}

std::filesystem::path Pictures::file_of(const SceneView& view, int frame) const {
  char number[16];
  std::snprintf(number, sizeof number, "%04d", frame);
  return folder_ / (view.name + "." + number + ".png");
}

void Pictures::draw(const BakeFrame& frame) {
  const auto begin = std::chrono::steady_clock::now();
  for (const SceneView& view : views_) {
    const std::filesystem::path file = file_of(view, frame.frame);
    if (std::filesystem::exists(file)) continue;
    if (!renderer_) renderer_ = std::make_unique<Renderer>(width_, height_, meshes_);
    writer_.add(file, renderer_->draw(view, frame.positions));
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool Pictures::complete(const std::vector<int>& frames) const {
  for (int frame : frames) {
    for (const SceneView& view : views_) {
      if (!std::filesystem::exists(file_of(view, frame))) return false;
    }
  }
  return true;
}

void Pictures::finish() { writer_.finish(); }

Image Pictures::sheet(const std::vector<int>& frames) const {
  constexpr int kColumns = 6, kThumbnail = 320;
  std::vector<Image> images;
  for (const SceneView& view : views_) {
    for (int index : spread_indices(static_cast<int>(frames.size()), kColumns)) {
      images.push_back(read_png(file_of(view, frames[index])));
    }
  }
  return images.empty() ? Image{} : contact_sheet(images, kColumns, kThumbnail);
}

}  // namespace thew
