// SPDX-License-Identifier: Apache-2.0
#include "tools/pictures.h"

#include <chrono>
#include <cstdio>
#include <fstream>

#include "sim/durable_file.h"
#include "sim/hash.h"
#include "tools/contact_sheet.h"
#include "tools/movie.h"

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
    hash.add(view.light.data(), 3 * sizeof(double));
    for (const auto& plane : view.cut) hash.add(plane.data(), sizeof plane);
  }
  return hash.hex();
}

constexpr const char* kNote = ".drawn";

std::string read_note(const std::filesystem::path& folder) {
  std::string note;
  std::ifstream(folder / kNote) >> note;
  return note;
}

// Pictures and movies half written, and the lists that ffmpeg was to read.
std::vector<std::filesystem::path> left_by_a_kill(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> left;
  if (!std::filesystem::exists(folder)) return left;
  for (const std::filesystem::path& file : paths_in(folder)) {
    const std::string name = file.filename().string();
    for (const char* ending : {".png.tmp", ".mp4.tmp", ".mp4.list"}) {
      if (name.ends_with(ending)) left.push_back(file);
    }
  }
  return left;
}

}  // namespace

std::vector<SceneView> views_of(const BakeReader& bake) {
  Vec3 low = Vec3::Constant(1e30), high = -low;
  for (size_t i = 0; i < bake.info().frames.size(); ++i) {
    const BakeFrame frame = bake.read(static_cast<int>(i));
    for (const auto& mesh : frame.positions) {
      for (const Vec3& p : mesh) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
      }
    }
  }
  SceneView view;
  view.target = 0.5 * (low + high);
  const double half_tangent = 0.268;  // of 30 degrees
  view.eye = view.target + 0.55 * (high - low).norm() / half_tangent * Vec3(0.6, 0.15, 0.79);
  std::vector<SceneView> views;
  for (const BakeMesh& mesh : bake.info().meshes) {
    if (mesh.kind == BakeMesh::Kind::kSkin) view.name = view.show = "skin";
  }
  if (view.name == "skin") views.push_back(view);
  for (const char* show : {"muscles", "weights"}) {
    view.name = view.show = show;
    views.push_back(view);
  }
  return views;
}

Pictures::Pictures(const std::filesystem::path& folder, const std::string& bake, int width,
                   int height, const std::vector<SceneView>& views,
                   const std::vector<BakeMesh>& meshes)
    : folder_(folder),
      drawn_(drawn_line(bake, width, height, views)),
      width_(width),
      height_(height),
      views_(views),
      meshes_(meshes) {}

// The folder, without pictures of another bake or camera that could be mistaken for these.
void Pictures::prepare() {
  create_folders(folder_);
  renderer_ = std::make_unique<Renderer>(width_, height_, meshes_);
  if (read_note(folder_) == drawn_) return;
  for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
    const std::string name = entry.path().filename().string();
    for (const SceneView& view : views_) {
      if (name.starts_with(view.name + ".") && name.ends_with(".png")) {
        remove_durably(entry.path());
        break;
      }
    }
  }
  write_durably(folder_ / kNote, drawn_ + "\n");
}

std::filesystem::path Pictures::file_of(const SceneView& view, int frame) const {
  char number[16];
  std::snprintf(number, sizeof number, "%04d", frame);
  return folder_ / (view.name + "." + number + ".png");
}

void Pictures::draw(const BakeFrame& frame) {
  const auto begin = std::chrono::steady_clock::now();
  if (!views_.empty() && !renderer_) prepare();
  for (const SceneView& view : views_) {
    const std::filesystem::path file = file_of(view, frame.frame);
    if (std::filesystem::exists(file)) continue;
    writer_.add(file, renderer_->draw(view, frame.positions));
  }
  seconds_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

bool Pictures::complete(const std::vector<int>& frames) const {
  if (!views_.empty() && read_note(folder_) != drawn_) return false;
  if (!left_by_a_kill(folder_).empty()) return false;  // its movie may be missing
  for (int frame : frames) {
    for (const SceneView& view : views_) {
      if (!std::filesystem::exists(file_of(view, frame))) return false;
    }
  }
  return true;
}

std::vector<std::filesystem::path> Pictures::files(const std::vector<int>& frames) const {
  std::vector<std::filesystem::path> files;
  for (const SceneView& view : views_) {
    for (const int frame : frames) files.push_back(file_of(view, frame));
  }
  return files;
}

void Pictures::finish() {
  writer_.finish();
  for (const std::filesystem::path& file : left_by_a_kill(folder_)) remove_durably(file);
}

std::string Pictures::movies(const std::vector<int>& frames, double fps) const {
  std::string wrong;
  for (const SceneView& view : frames.size() > 1 ? views_ : std::vector<SceneView>{}) {
    std::vector<MoviePicture> pictures;
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const int until = i + 1 < frames.size() ? frames[i + 1] : frames[i] + 1;
      pictures.push_back({file_of(view, frames[i]), until - frames[i]});
    }
    wrong = write_movie(folder_ / (view.name + ".mp4"), pictures, fps);
    if (!wrong.empty()) break;
  }
  return wrong;
}

Image Pictures::sheet(const std::vector<int>& frames) const {
  constexpr int kColumns = 6, kThumbnail = 320;
  std::vector<Image> images;
  std::vector<int> numbers;
  for (const SceneView& view : views_) {
    for (int index : spread_indices(static_cast<int>(frames.size()), kColumns)) {
      images.push_back(read_png(file_of(view, frames[index])));
      numbers.push_back(frames[index]);
    }
  }
  return images.empty() ? Image{} : contact_sheet(images, kColumns, kThumbnail, numbers);
}

}  // namespace thew
