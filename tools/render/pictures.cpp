// SPDX-License-Identifier: Apache-2.0
#include "tools/render/pictures.h"

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>

#include "sim/cache/hash.h"
#include "sim/cache/version.h"
#include "sim/framing.h"
#include "tools/base/output_file.h"
#include "tools/render/camera.h"
#include "tools/render/contact_sheet.h"
#include "tools/render/draw_geometry.h"
#include "tools/render/frame_file.h"
#include "tools/render/gl_context.h"
#include "tools/render/movie.h"

namespace thew::tools {
namespace {

// How a view is drawn, whatever is seen.
std::string look_of(const std::string& program, int width, int height, const SceneView& view) {
  Hash hash;
  const auto number = [&](double value) { hash.add(&value, sizeof value); };
  const char* driver = std::getenv("GALLIUM_DRIVER");
  for (const std::string& text :
       {program, std::string(driver ? driver : ""), view.name, view.show}) {
    number(static_cast<double>(text.size()));
    hash.add(text);
  }
  number(width);
  number(height);
  for (const Vec3* v : {&view.eye, &view.target, &view.up}) {
    hash.add(v->data(), 3 * sizeof(double));
  }
  number(view.field_of_view);
  hash.add(view.light.data(), 3 * sizeof(double));
  for (const auto& plane : view.cut) hash.add(plane.data(), sizeof plane);
  if (!view.follow.empty()) {
    hash.add(view.moved.data(), 3 * sizeof(double));
    for (const Vec3& move : view.moves) hash.add(move.data(), 3 * sizeof(double));
  }
  return hash.hex();
}

// A bake lists its meshes in the order of the scene, its cache by name.
std::vector<std::size_t> by_name(const std::vector<BakeMesh>& meshes) {
  std::vector<std::size_t> order(meshes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return meshes[a].name < meshes[b].name; });
  return order;
}

template <typename T>
void add_all(const std::vector<T>& values, Hash& hash) {
  const std::uint64_t count = values.size();
  hash.add(&count, sizeof count);
  hash.add(values.data(), count * sizeof(T));
}

std::string hash_of_meshes(const std::vector<BakeMesh>& meshes) {
  Hash hash;
  for (const std::size_t m : by_name(meshes)) {
    hash.add(meshes[m].name);
    hash.add(&meshes[m].kind, sizeof meshes[m].kind);
    add_all(meshes[m].rest.vertices, hash);
    add_all(meshes[m].rest.triangles, hash);
    add_all(meshes[m].weights, hash);
    add_all(meshes[m].coordinates, hash);
  }
  return hash.hex();
}

// As float64, of what the cache holds: the renderer draws that.
std::string hash_of_positions(const std::vector<BakeMesh>& meshes, const BakeFrame& frame) {
  Hash hash;
  const auto positions = as_in_cache(frame.positions);
  for (const std::size_t m : by_name(meshes)) add_all(positions[m], hash);
  return hash.hex();
}

std::string set_part(const std::string& of) { return of.substr(0, of.find(' ')); }
std::string frame_part(const std::string& of) {
  return of.substr(std::min(of.find(' '), of.size()));
}

bool holds(const std::filesystem::path& file, const OwnFile& about) {
  try {
    check_replaceable(file, std::filesystem::file_type::regular);
    const std::string bytes = read_whole_file(file, about.bytes);
    return bytes.size() == about.bytes && hash_of(bytes) == about.hash;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace

std::string program_version() { return kVersion; }

std::vector<SceneView> views_of(const BakeReader& bake) {
  SceneRender render;
  const std::vector<BakeMesh>& meshes = bake.info().meshes;
  const bool has_skin = std::any_of(meshes.begin(), meshes.end(), [](const BakeMesh& mesh) {
    return mesh.kind == BakeMesh::Kind::kSkin;
  });
  for (const char* show : {"skin", "muscles", "weights"}) {
    if (show == std::string("skin") && !has_skin) continue;
    SceneView& view = render.views.emplace_back();
    view.name = view.show = show;
    view.from = Vec3(0.6, 0.15, 0.79);
  }
  return frame_views(bake, bake.info().frames, render);
}

Pictures::Pictures(const std::filesystem::path& folder, const std::string& bake, int width,
                   int height, const std::vector<SceneView>& views,
                   const std::vector<BakeMesh>& meshes, const std::string& program)
    : folder_(folder),
      width_(width),
      height_(height),
      views_(views),
      meshes_(meshes),
      program_(program) {
  if (views_.empty()) return;
  set_driver_options();
  meshes_hash_ = hash_of_meshes(meshes);
  for (const SceneView& view : views_) {
    sets_[view.name] = hash_of(bake + " " + look_of(program, width, height, view));
  }
  seen_ = std::filesystem::is_directory(std::filesystem::symlink_status(folder))
              ? own_files(folder)
              : std::map<std::string, OwnFile>{};
}

void Pictures::claim(const std::vector<int>& frames, bool overwrite) const {
  if (views_.empty()) {  // a bake that drew may have been killed here
    if (std::filesystem::is_directory(std::filesystem::symlink_status(folder_))) {
      remove_leftovers(folder_);
    }
    return;
  }
  claim_folder(folder_);
  std::vector<std::filesystem::path> files = {sheet_file()};
  for (const SceneView& view : views_) {
    files.push_back(movie_file(view));
    for (const int frame : frames) files.push_back(file_of(view, frame));
  }
  sim::claim(files, overwrite);
}

std::filesystem::path Pictures::file_of(const SceneView& view, int frame) const {
  return frame_file(folder_, view.name, frame);
}

std::filesystem::path Pictures::movie_file(const SceneView& view) const {
  return folder_ / (view.name + ".mp4");
}

std::filesystem::path Pictures::sheet_file() const { return folder_ / "contact_sheet.png"; }

std::vector<SceneView> Pictures::keep(const BakeFrame& frame) {
  std::vector<SceneView> missing;
  if (views_.empty()) return missing;
  const std::string drawn = meshes_hash_ + hash_of_positions(meshes_, frame);
  for (const SceneView& view : views_) {
    const std::filesystem::path file = file_of(view, frame.frame);
    const std::string name = file.filename().string();
    const std::string look = look_of(program_, width_, height_, view_at(view, frame.frame));
    const std::string of = sets_[view.name] + " " + hash_of(look + drawn);
    of_[name] = of;
    const auto listed = seen_.find(name);
    if (listed == seen_.end() || frame_part(listed->second.of) != frame_part(of) ||
        !holds(file, listed->second)) {
      missing.push_back(view);
    } else if (listed->second.of != of) {  // of another bake that comes to the same here
      listed->second.of = of;
      list_own(file, listed->second);
    }
  }
  complete_ = complete_ && missing.empty();
  return missing;
}

void Pictures::draw(const BakeFrame& frame) {
  if (views_.empty()) return;
  BakeFrame part;  // without the solver's state, which takes most of its memory
  part.frame = frame.frame;
  part.positions = frame.positions;
  drawer_.add([this, part = std::move(part)] { draw_missing(part); });
  drawer_.check();
}

void Pictures::draw_missing(const BakeFrame& frame) {
  for (const SceneView& view : keep(frame)) {
    if (!renderer_) {
      claim_folder(folder_);
      renderer_ = std::make_unique<Renderer>(width_, height_, meshes_);
    }
    const std::filesystem::path file = file_of(view, frame.frame);
    writer_.add([file, image = renderer_->draw(view_at(view, frame.frame), frame.positions),
                 of = of_[file.filename().string()]] { write_png(file, image, kFastPng, of); });
  }
}

std::vector<std::filesystem::path> Pictures::files(const std::vector<int>& frames) const {
  std::vector<std::filesystem::path> files;
  for (const SceneView& view : views_) {
    for (const int frame : frames) files.push_back(file_of(view, frame));
  }
  return files;
}

void Pictures::finish(bool alone) {
  if (!views_.empty()) drawer_.add([this] { renderer_.reset(); });
  drawer_.finish();
  writer_.finish();
  if (!alone) return;
  for (const auto& [name, about] : seen_) {
    const auto frame = read_frame_name(name);
    const auto set = frame ? sets_.find(frame->view) : sets_.end();
    if (set != sets_.end() && !of_.contains(name) && set_part(about.of) != set->second) {
      remove_own(folder_ / name);
    }
  }
}

std::string Pictures::key() const {
  Hash hash;
  for (const auto& [name, of] : of_) hash.add(name + " " + of + "\n");
  return of_.empty() ? "" : hash.hex();
}

std::string Pictures::movies(const std::vector<int>& frames, double fps) const {
  std::string wrong;
  for (const SceneView& view : frames.size() > 1 ? views_ : std::vector<SceneView>{}) {
    std::vector<MoviePicture> pictures;
    std::string text = digits(fps);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const int until = i + 1 < frames.size() ? frames[i + 1] : frames[i] + 1;
      pictures.push_back({file_of(view, frames[i]), until - frames[i]});
      const auto of = of_.find(pictures.back().file.filename().string());
      text += " " + std::to_string(until - frames[i]) + " " + (of == of_.end() ? "" : of->second);
    }
    const std::filesystem::path file = movie_file(view);
    const auto listed = seen_.find(file.filename().string());
    const std::string of = hash_of(text);
    if (listed != seen_.end() && listed->second.of == of && holds(file, listed->second)) continue;
    wrong = write_movie(file, pictures, fps, of);
    if (!wrong.empty()) break;
  }
  return wrong;
}

constexpr int kSheetColumns = 6;

std::vector<int> Pictures::sheet_frames(const std::vector<int>& frames) const {
  std::vector<int> numbers;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    for (int index : spread_indices(static_cast<int>(frames.size()), kSheetColumns)) {
      numbers.push_back(frames[index]);
    }
  }
  return numbers;
}

int Pictures::sheet_columns(const std::vector<int>& frames) const {
  return std::min(kSheetColumns, static_cast<int>(sheet_frames(frames).size()));
}

Image Pictures::sheet(const std::vector<int>& frames) const {
  constexpr int kThumbnail = 320;
  const std::vector<int> numbers = sheet_frames(frames);
  std::vector<Image> images;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const SceneView& view = views_[i / (numbers.size() / views_.size())];
    images.push_back(read_png(file_of(view, numbers[i])));
  }
  return images.empty() ? Image{} : contact_sheet(images, kSheetColumns, kThumbnail, numbers);
}

}  // namespace thew::tools
