// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/cache.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "rig/import/child.h"
#include "rig/limits.h"
#include "sim/cache/cache_parts.h"
#include "sim/cache/durable_file.h"
#include "sim/cache/hash.h"
#include "sim/cache/hdf5_file.h"
#include "sim/cache/version.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKinds[] = {"muscle", "bone", "skin", "prop"};

void check_info(const BakeInfo& info) {
  const auto refuse = [](const std::string& what) {
    throw Error(ErrorCode::kUsage, "bake: " + what + "; correct the scene");
  };
  if (info.frames.empty()) refuse("there is no frame to write");
  if (std::adjacent_find(info.frames.begin(), info.frames.end(), std::greater_equal()) !=
      info.frames.end()) {
    refuse("frames are not in ascending order");
  }
  std::set<std::string> names;
  for (const BakeMesh& mesh : info.meshes) {
    const std::size_t nodes = mesh.rest.vertices.size();
    if (mesh.name.empty() || mesh.name == "." || mesh.name.find('/') != std::string::npos) {
      refuse("\"" + mesh.name + "\" cannot be the name of a mesh");
    }
    if (!names.insert(mesh.name).second) refuse("two meshes are called \"" + mesh.name + "\"");
    if (nodes == 0 || mesh.rest.triangles.empty()) refuse("mesh \"" + mesh.name + "\" is empty");
    if ((!mesh.weights.empty() && mesh.weights.size() != nodes) ||
        (!mesh.coordinates.empty() && mesh.coordinates.size() != nodes)) {
      refuse("mesh \"" + mesh.name + "\" has not as many weights or coordinates as nodes");
    }
  }
}

// Checks a frame before it is written, so that no bake holds a number that is not finite.
void check_frame(const BakeInfo& info, const BakeFrame& frame) {
  const auto refuse = [&](const std::string& what) {
    throw Error(ErrorCode::kSolver, "frame " + std::to_string(frame.frame) + ": " + what +
                                        "; it is not written, the frames before it stay");
  };
  if (frame.positions.size() != info.meshes.size() ||
      frame.bodies.size() != info.character.rest.size() ||
      frame.metrics.size() != info.metric_names.size()) {
    refuse("not as many meshes, bodies or metrics as the bake has");
  }
  for (std::size_t m = 0; m < info.meshes.size(); ++m) {
    const std::vector<Vec3>& line = line_of(frame, m);
    if (line.size() != info.meshes[m].line ||
        !std::all_of(line.begin(), line.end(), [](const Vec3& p) { return is_bounded(p); })) {
      refuse("mesh \"" + info.meshes[m].name +
             "\": its line of action has not its number of points, or one that is no place");
    }
    const auto& positions = frame.positions[m];
    if (positions.size() != info.meshes[m].rest.vertices.size()) {
      refuse("mesh \"" + info.meshes[m].name + "\" changed its number of nodes");
    }
    const auto bad = std::find_if(positions.begin(), positions.end(),
                                  [](const Vec3& p) { return !is_bounded(p); });
    if (bad != positions.end()) {
      refuse("mesh \"" + info.meshes[m].name + "\", node " +
             std::to_string(bad - positions.begin()) +
             ": position is no number, or farther than 10 km");
    }
  }
  for (std::size_t k = 0; k < frame.metrics.size(); ++k) {
    if (!std::isfinite(frame.metrics[k])) refuse(info.metric_names[k] + " is not finite");
  }
}

std::vector<int> by_name(const BakeInfo& info) {
  std::vector<int> order(info.meshes.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return info.meshes[a].name < info.meshes[b].name; });
  return order;
}

void add_positions(const BakeFrame& frame, const std::vector<int>& order, Hash& hash) {
  for (const int m : order) {
    hash.add(frame.positions[m].data(), frame.positions[m].size() * sizeof(Vec3));
  }
}

/// Writes bake.h5: positions frame by frame, metrics at the end.
class Packing {
 public:
  Packing(const fs::path& file, const BakeInfo& info, std::size_t frames)
      : info_(info), order_(by_name(info)), out_(file, Hdf5File::Mode::kCreate) {
    const Hdf5Id meshes = out_.create_group(out_.root(), "meshes");
    positions_.resize(info.meshes.size());
    lines_.resize(info.meshes.size());
    for (const int m : order_) {
      const Hdf5Id group = write_mesh(meshes, info.meshes[m]);
      positions_[m] = out_.create_dataset(group, "positions",
                                          info.double_precision ? H5T_IEEE_F64LE : H5T_IEEE_F32LE,
                                          {frames, info.meshes[m].rest.vertices.size(), 3}, 1);
      if (info.meshes[m].line == 0) continue;
      lines_[m] =
          out_.create_dataset(group, "line", H5T_IEEE_F32LE, {frames, info.meshes[m].line, 3}, 1);
    }
    if (!info.character.rest.empty()) write_character(frames);
  }

  void add(const BakeFrame& frame) {
    Hash written;
    for (const int m : order_) {
      std::vector<Vec3> positions = frame.positions[m];
      if (!info_.double_precision) {
        for (Vec3& p : positions) p = p.unaryExpr(&as_float);
      }
      out_.write_chunk(positions_[m], H5T_NATIVE_DOUBLE, frames_.size(), positions.data());
      written.add(positions.data(), positions.size() * sizeof(Vec3));
    }
    for (const int m : order_) {
      if (info_.meshes[m].line == 0) continue;
      std::vector<Vec3> line = line_of(frame, m);
      for (Vec3& p : line) p = p.unaryExpr(&as_float);
      out_.write_chunk(lines_[m], H5T_NATIVE_DOUBLE, frames_.size(), line.data());
      written.add(line.data(), line.size() * sizeof(Vec3));
    }
    if (!info_.character.rest.empty()) {
      out_.write_chunk(bodies_, H5T_NATIVE_DOUBLE, frames_.size(), frame.bodies.data());
      written.add(frame.bodies.data(), frame.bodies.size() * sizeof(BodyFrame));
    }
    frame_hashes_.push_back(written.hex());
    add_positions(frame, order_, hash_);
    frames_.push_back(frame.frame);
    metrics_.push_back(frame.metrics);
  }

  const std::vector<std::string>& frame_hashes() const { return frame_hashes_; }

  /// Returns the hash of all positions.
  std::string finish() {
    for (Hdf5Dataset& positions : positions_) out_.close(positions.id);
    for (Hdf5Dataset& line : lines_) out_.close(line.id);
    out_.close(bodies_.id);
    out_.write_dataset(out_.root(), "frames", H5T_STD_I32LE, H5T_NATIVE_INT, {frames_.size()},
                       frames_.data());
    write_metrics();
    write_root();
    out_.close();
    return hash_.hex();
  }

 private:
  Hdf5Id write_mesh(hid_t meshes, const BakeMesh& mesh) {
    Hdf5Id group = out_.create_group(meshes, mesh.name);
    const hsize_t nodes = mesh.rest.vertices.size();
    out_.write_attribute(group, "kind", kKinds[static_cast<int>(mesh.kind)]);
    out_.write_dataset(group, "triangles", H5T_STD_U32LE, H5T_NATIVE_INT,
                       {mesh.rest.triangles.size(), 3}, mesh.rest.triangles.data());
    out_.write_dataset(group, "rest", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {nodes, 3},
                       mesh.rest.vertices.data());
    if (!mesh.weights.empty()) {
      out_.write_dataset(group, "weights", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {nodes},
                         mesh.weights.data());
    }
    if (!mesh.coordinates.empty()) {
      out_.write_dataset(group, "coordinates", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {nodes, 3},
                         mesh.coordinates.data());
    }
    return group;
  }

  void write_character(std::size_t frames) {
    const BakeCharacter& character = info_.character;
    const Hdf5Id group = out_.create_group(out_.root(), "character");
    out_.write_attribute(group, "file", character.file);
    out_.write_attribute(group, "scale", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &character.scale);
    out_.write_dataset(group, "rest", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE,
                       {character.rest.size(), 12}, character.rest.data());
    bodies_ = out_.create_dataset(group, "bodies", H5T_IEEE_F64LE,
                                  {frames, character.rest.size(), 12}, 1);
  }

  void write_metrics() {
    const Hdf5Id metrics = out_.create_group(out_.root(), "metrics");
    for (std::size_t k = 0; k < info_.metric_names.size(); ++k) {
      std::vector<double> values;
      for (const auto& frame : metrics_) values.push_back(frame[k]);
      write_metric(metrics, info_.metric_names[k], values);
    }
  }

  // A '/' in the name is a group. It is made here, since groups that the library makes by itself
  // store the time.
  void write_metric(hid_t parent, const std::string& name, const std::vector<double>& values) {
    const auto slash = name.find('/');
    if (slash == std::string::npos) {
      out_.write_dataset(parent, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, {values.size()},
                         values.data());
      return;
    }
    const std::string group = name.substr(0, slash);
    write_metric(
        out_.has(parent, group) ? out_.open_group(parent, group) : out_.create_group(parent, group),
        name.substr(slash + 1), values);
  }

  void write_root() {
    const hid_t root = out_.root();
    const int version = kCacheVersion, done = static_cast<int>(frames_.size());
    out_.write_attribute(root, "format", "thew-bake");
    out_.write_attribute(root, "version", H5T_STD_I32LE, H5T_NATIVE_INT, &version);
    out_.write_attribute(root, "fps", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &info_.fps);
    out_.write_attribute(root, "units", "m");
    out_.write_attribute(root, "up_axis", "Y");
    out_.write_attribute(root, "frames_done", H5T_STD_I32LE, H5T_NATIVE_INT, &done);
    out_.write_attribute(root, "scene", info_.scene_name);
    out_.write_attribute(root, "scene_hash", info_.scene_hash);
    out_.write_attribute(root, "hash", hash_.hex());
  }

  const BakeInfo& info_;
  std::vector<int> order_;
  Hdf5File out_;
  std::vector<Hdf5Dataset> positions_, lines_;  // by mesh
  Hdf5Dataset bodies_;                          // of a character
  std::vector<int> frames_;
  std::vector<std::vector<double>> metrics_;  // by frame
  std::vector<std::string> frame_hashes_;     // of the positions as they are written
  Hash hash_;
};

// Reads `packed` back against the hashes of its frames.
void verify(const fs::path& packed, const std::vector<std::string>& hashes) {
  const BakeReader reader(packed);
  bool same = reader.info().frames.size() == hashes.size();
  for (std::size_t f = 0; same && f < hashes.size(); ++f) {
    Hash hash;
    const BakeFrame frame = reader.read(static_cast<int>(f));
    for (const std::vector<Vec3>& positions : frame.positions) {
      hash.add(positions.data(), positions.size() * sizeof(Vec3));
    }
    for (const std::vector<Vec3>& line : frame.lines) {
      hash.add(line.data(), line.size() * sizeof(Vec3));
    }
    hash.add(frame.bodies.data(), frame.bodies.size() * sizeof(BodyFrame));
    same = hash.hex() == hashes[f];
  }
  if (!same) {
    throw Error(ErrorCode::kOutput, packed.string() +
                                        ": its contents are not what was written to it; "
                                        "check the disk and run again");
  }
}

}  // namespace

// Volatile, since GCC 12 at -O2 removes the conversion of a vector to float and back.
double as_float(double value) {
  volatile float rounded = static_cast<float>(value);
  return rounded;
}

struct BakeWriter::Data {
  Data(const fs::path& to, const BakeInfo& about)
      : info(about), folder(to), parts_folder(to / "bake.parts") {
    check_info(info);
    create_folders(folder);
    lock.emplace(folder);
    claim_bake(folder);
  }

  BakeInfo info;
  fs::path folder, parts_folder;
  std::optional<FolderLock> lock;
  std::vector<Part> parts;
  std::vector<int> completed;  // as found on resuming
  std::string bytes;           // of a part that is written, kept so that its memory is used again
};

BakeWriter::BakeWriter(const fs::path& folder, const BakeInfo& info, bool resume)
    : data_(std::make_unique<Data>(folder, info)) {
  Data& data = *data_;
  if (resume && is_scene_of(data.parts_folder, info)) {
    data.parts = good_parts(data.parts_folder, info);
  } else {
    remove_parts(data.parts_folder);
    claim_folder(data.parts_folder);
    replace_durably(data.parts_folder / "bake.json", describe_scene(info));
  }

  // Other parts than the undamaged first ones are dropped, from the manifest first.
  std::string manifest;
  std::set<std::string> kept = {kManifest, "bake.json"};
  for (const Part& part : data.parts) {
    manifest += manifest_line(part) + "\n";
    kept.insert(part.file);
    data.completed.push_back(part.frame);
  }
  replace_durably(data.parts_folder / kManifest, manifest);
  remove_parts(data.parts_folder, kept);
}

BakeWriter::~BakeWriter() = default;

const std::vector<int>& BakeWriter::completed() const { return data_->completed; }

BakeFrame BakeWriter::read_completed(int frame) const {
  for (const Part& part : data_->parts) {
    if (part.frame == frame) return read_part(data_->parts_folder, part, data_->info);
  }
  throw Error(ErrorCode::kUsage, data_->parts_folder.string() + ": frame " + std::to_string(frame) +
                                     " is not there; it has to be baked first");
}

void BakeWriter::write(const BakeFrame& frame) {
  Data& data = *data_;
  check_frame(data.info, frame);
  const std::size_t index = data.parts.size();
  if (index >= data.info.frames.size() || frame.frame != data.info.frames[index]) {
    throw Error(ErrorCode::kUsage, "frame " + std::to_string(frame.frame) +
                                       ": it is not the next one to be written; write the frames "
                                       "of the bake in their order");
  }
  encode_part(frame, data.bytes);
  const Part part{frame.frame, part_file(frame.frame), data.bytes.size(), hash_of(data.bytes)};
  replace_durably(data.parts_folder / part.file, data.bytes);
  append_durably(data.parts_folder / kManifest, manifest_line(part));
  data.parts.push_back(part);
}

std::string BakeWriter::pack(const std::function<void()>& on_frame) {
  Data& data = *data_;
  if (data.parts.empty()) {
    throw Error(ErrorCode::kOutput,
                data.parts_folder.string() + ": there is no frame to pack; bake one first");
  }
  // Among the parts, which the lock on the folder makes ours alone.
  const fs::path file = data.folder / "bake.h5", temporary = data.parts_folder / kPacked;
  remove_file(temporary);  // left by a bake that was killed
  std::string hash;
  try {
    auto packs = rig::keep_from_forking();
    Packing packing(temporary, data.info, data.parts.size());
    for (const Part& part : data.parts) {
      packing.add(read_part(data.parts_folder, part, data.info, false));
      if (on_frame) on_frame();
    }
    hash = packing.finish();
    packs.unlock();
    try {
      verify(temporary, packing.frame_hashes());
    } catch (const Error& unread) {
      if (unread.code() != ErrorCode::kInput) throw;  // it is our own file that cannot be read
      throw Error(ErrorCode::kOutput,
                  temporary.string() + ": could not be read back; check the disk and run again");
    }
    place_durably(temporary, file, {fs::file_size(temporary), "", hash});
  } catch (...) {
    ::unlink(temporary.c_str());  // a full disk gets its space back
    throw;
  }
  remove_parts(data.parts_folder);
  return hash;
}

void claim_bake(const fs::path& folder) {
  const fs::path file = folder / "bake.h5", parts = folder / "bake.parts";
  check_replaceable(file, fs::file_type::regular);
  check_replaceable(parts, fs::file_type::directory);
  std::error_code error;
  if (fs::exists(file, error) && !own_file(file)) {
    try {
      const BakeReader reader(file);
    } catch (const Error&) {
      refuse_foreign(file);
    }
    list_own(file);
  }
  if (own_file(parts)) return;
  if (fs::exists(parts, error) && !fs::is_regular_file(parts / "bake.json", error) &&
      !paths_in(parts).empty()) {
    refuse_foreign(parts);
  }
  list_own(parts);
}

}  // namespace thew::sim
