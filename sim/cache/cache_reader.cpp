// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>

#include "rig/import/child.h"
#include "rig/import/packed.h"
#include "rig/limits.h"
#include "sim/cache/cache.h"
#include "sim/cache/hdf5_file.h"
#include "sim/cache/version.h"

namespace thew::sim {
namespace {

constexpr std::size_t kMostOfLine = 4096;  // points

/// A whole dataset of rank 1 or 2 as T, each of which is `width` numbers.
template <typename T>
std::vector<T> read_all(const Hdf5File& file, hid_t parent, const std::string& name, hid_t type,
                        hid_t memory_type, hsize_t width, hsize_t count_or_0 = 0) {
  const Hdf5Dataset dataset = file.open_dataset(parent, name, {type}, width == 1 ? 1 : 2);
  const hsize_t count = dataset.dims[0];
  if (count == 0 || (count_or_0 != 0 && count != count_or_0) ||
      (width != 1 && dataset.dims[1] != width)) {
    file.fail(name + " is not of the size that it has to be");
  }
  // Before memory is allocated for it.
  file.check_chunk(dataset, 0);
  std::vector<T> values(count);
  file.read_chunk(dataset, memory_type, 0, values.data());
  return values;
}

BakeMesh::Kind kind_of(const Hdf5File& file, const std::string& word) {
  if (word == "muscle") return BakeMesh::Kind::kMuscle;
  if (word == "bone") return BakeMesh::Kind::kBone;
  if (word == "skin") return BakeMesh::Kind::kSkin;
  if (word == "prop") return BakeMesh::Kind::kProp;
  file.fail("a mesh is of the unknown kind \"" + word + "\"");
}

// Sizes are checked here, before memory is allocated. The parent checks the values.
BakeMesh read_mesh(const Hdf5File& file, hid_t group, const std::string& name) {
  BakeMesh mesh;
  mesh.name = name;
  mesh.kind = kind_of(file, file.read_text_attribute(group, "kind"));
  mesh.rest.vertices = read_all<Vec3>(file, group, "rest", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 3);
  const std::size_t nodes = mesh.rest.vertices.size();
  mesh.rest.triangles =
      read_all<Triangle>(file, group, "triangles", H5T_STD_U32LE, H5T_NATIVE_INT, 3);
  if (file.has(group, "weights")) {
    mesh.weights =
        read_all<double>(file, group, "weights", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1, nodes);
  }
  if (file.has(group, "coordinates")) {
    mesh.coordinates = read_all<std::array<double, 3>>(file, group, "coordinates", H5T_IEEE_F64LE,
                                                       H5T_NATIVE_DOUBLE, 3, nodes);
  }
  return mesh;
}

/// An open bake in the child process, where HDF5 reads.
struct OpenBake {
  explicit OpenBake(const std::filesystem::path& path) : file(path, Hdf5File::Mode::kRead) {
    read_root();
    read_meshes();
    read_character();
    read_metrics(file.open_group(file.root(), "metrics"), "", 0);
  }

  void read_root() {
    const hid_t root = file.root();
    if (!file.has_attribute(root, "format") ||
        file.read_text_attribute(root, "format") != "thew-bake") {
      file.fail("it is not a bake of Thew");
    }
    int version = 0, done = 0;
    file.read_attribute(root, "version", H5T_STD_I32LE, H5T_NATIVE_INT, &version);
    if (version != kCacheVersion) {
      file.fail("it is of version " + std::to_string(version) + ", this program reads " +
                std::to_string(kCacheVersion));
    }
    if (file.read_text_attribute(root, "units") != "m" ||
        file.read_text_attribute(root, "up_axis") != "Y") {
      file.fail("it is not in metres with Y up");
    }
    file.read_attribute(root, "fps", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &info.fps);
    file.read_attribute(root, "frames_done", H5T_STD_I32LE, H5T_NATIVE_INT, &done);
    info.scene_name = file.read_text_attribute(root, "scene");
    info.scene_hash = file.read_text_attribute(root, "scene_hash");
    info.hash = file.read_text_attribute(root, "hash");
    info.frames = read_all<int>(file, root, "frames", H5T_STD_I32LE, H5T_NATIVE_INT, 1);
    if (done != static_cast<int>(info.frames.size())) {
      file.fail("it has not as many frames as it says");
    }
  }

  void read_meshes() {
    const Hdf5Id meshes = file.open_group(file.root(), "meshes");
    for (const std::string& name : file.names(meshes)) {
      const Hdf5Id group = file.open_group(meshes, name);
      info.meshes.push_back(read_mesh(file, group, name));
      positions.push_back(
          file.open_dataset(group, "positions", {H5T_IEEE_F32LE, H5T_IEEE_F64LE}, 3, 1));
      const Hdf5Dims expected = {info.frames.size(), info.meshes.back().rest.vertices.size(), 3};
      if (positions.back().dims != expected) {
        file.fail(name + ": positions are not by frame and node");
      }
      info.double_precision = positions.back().type == H5T_IEEE_F64LE;
      lines.emplace_back();
      if (!file.has(group, "line")) continue;
      lines.back() = file.open_dataset(group, "line", {H5T_IEEE_F32LE}, 3, 1);
      const Hdf5Dims& dims = lines.back().dims;
      if (dims[0] != info.frames.size() || dims[1] < 2 || dims[1] > kMostOfLine || dims[2] != 3) {
        file.fail(name + ": its line of action is not by frame and point");
      }
      info.meshes.back().line = dims[1];
    }
  }

  void read_character() {
    if (!file.has(file.root(), "character")) return;
    BakeCharacter& character = info.character;
    const Hdf5Id group = file.open_group(file.root(), "character");
    character.file = file.read_text_attribute(group, "file");
    file.read_attribute(group, "scale", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &character.scale);
    character.rest =
        read_all<BodyFrame>(file, group, "rest", H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 12);
    bodies = file.open_dataset(group, "bodies", {H5T_IEEE_F64LE}, 3, 1);
    if (bodies.dims != Hdf5Dims{info.frames.size(), character.rest.size(), 12}) {
      file.fail("the bodies of its character are not by frame and body");
    }
  }

  // Depth is limited, since hard links may form cycles.
  void read_metrics(const Hdf5Id& group, const std::string& prefix, int depth) {
    if (depth > 3) file.fail("its metrics are nested too deeply");
    for (const std::string& name : file.names(group)) {
      if (file.is_group(group, name)) {
        read_metrics(file.open_group(group, name), prefix + name + "/", depth + 1);
        continue;
      }
      info.metric_names.push_back(prefix + name);
      metrics.push_back(read_all<double>(file, group, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, 1,
                                         info.frames.size()));
    }
  }

  /// No metrics: they are read with the rest of the file. Of one mesh alone or, for -1, of all and
  /// with the bodies.
  BakeFrame read(std::size_t at, int mesh) const {
    BakeFrame frame;
    frame.frame = info.frames.at(at);
    for (std::size_t m = 0; m < positions.size(); ++m) {
      if (mesh >= 0 && m != static_cast<std::size_t>(mesh)) continue;
      file.check_chunk(positions[m], at);
      frame.positions.emplace_back(info.meshes[m].rest.vertices.size());
      file.read_chunk(positions[m], H5T_NATIVE_DOUBLE, at, frame.positions.back().data());
    }
    for (std::size_t m = 0; mesh < 0 && m < lines.size(); ++m) {
      auto& line = frame.lines.emplace_back(info.meshes[m].line);
      if (line.empty()) continue;
      file.check_chunk(lines[m], at);
      file.read_chunk(lines[m], H5T_NATIVE_DOUBLE, at, line.data());
    }
    if (mesh >= 0 || info.character.rest.empty()) return frame;
    file.check_chunk(bodies, at);
    frame.bodies.resize(info.character.rest.size());
    file.read_chunk(bodies, H5T_NATIVE_DOUBLE, at, frame.bodies.data());
    return frame;
  }

  Hdf5File file;
  BakeInfo info;
  std::vector<Hdf5Dataset> positions, lines;  // by mesh
  Hdf5Dataset bodies;                         // of a character
  std::vector<std::vector<double>> metrics;   // by metric, then frame
};

template <typename Archive>
void walk(Archive& archive, BakeInfo& info, std::vector<std::vector<double>>& metrics) {
  const auto list = [](Archive& in, auto& value) { in.list(value); };
  archive.list(info.scene_name);
  archive.list(info.scene_hash);
  archive.number(info.fps);
  archive.number(info.double_precision);
  archive.list(info.frames);
  archive.each(info.meshes, [](Archive& in, BakeMesh& mesh) {
    in.list(mesh.name);
    in.number(mesh.kind);
    in.list(mesh.rest.vertices);
    in.list(mesh.rest.triangles);
    in.list(mesh.weights);
    in.list(mesh.coordinates);
    in.number(mesh.line);
  });
  archive.list(info.character.file);
  archive.number(info.character.scale);
  archive.list(info.character.rest);
  archive.each(info.metric_names, list);
  archive.list(info.hash);
  archive.each(metrics, list);
}

template <typename Archive>
void walk(Archive& archive, BakeFrame& frame) {
  archive.number(frame.frame);
  archive.each(frame.positions, [](Archive& in, std::vector<Vec3>& x) { in.list(x); });
  archive.each(frame.lines, [](Archive& in, std::vector<Vec3>& x) { in.list(x); });
  archive.list(frame.bodies);
}

template <typename... Values>
std::string pack(Values&... values) {
  Packer packer;
  walk(packer, values...);
  return packer.bytes;
}

template <typename... Values>
bool unpack(const std::string& bytes, Values&... values) {
  Unpacker unpacker{bytes};
  walk(unpacker, values...);
  return unpacker.finished();
}

// Limits of what a scene may ask for. A comparison with NaN is false, so NaN is refused too.
constexpr double kMinRate = 1e-2, kMaxRate = 1e5;  // frames a second
constexpr int kLastFrame = 1000000;
constexpr double kMaxWeight = 1e12;
constexpr double kMaxMetric = 1e30;  // metrics are squared, and drawn in charts

template <typename Values>
bool all_within(const Values& values, double least, double most) {
  return std::all_of(values.begin(), values.end(),
                     [&](double v) { return v >= least && v <= most; });
}

bool are_bounded(const std::vector<BodyFrame>& bodies) {
  return std::all_of(bodies.begin(), bodies.end(),
                     [](const BodyFrame& body) { return all_within(body, -kMaxScale, kMaxScale); });
}

void check_mesh(const Child& child, const BakeMesh& mesh) {
  constexpr std::size_t kMaxTriangles = 20;  // a node; a closed surface has two
  const std::vector<Vec3>& rest = mesh.rest.vertices;
  if (mesh.rest.triangles.size() > kMaxTriangles * rest.size()) {
    child.refuse(mesh.name + " has " + std::to_string(mesh.rest.triangles.size()) +
                 " triangles on " + std::to_string(rest.size()) + " nodes, as no surface has");
  }
  for (const Triangle& triangle : mesh.rest.triangles) {
    for (const int node : triangle) {
      if (node < 0 || static_cast<std::size_t>(node) >= rest.size()) {
        child.refuse(mesh.name + ": a triangle names node " + std::to_string(node) + " of " +
                     std::to_string(rest.size()));
      }
    }
  }
  if (!std::all_of(rest.begin(), rest.end(), [](const Vec3& p) { return is_bounded(p); })) {
    child.refuse(mesh.name + " lies at rest where no place is, or farther than 10 km");
  }
  if (std::all_of(rest.begin(), rest.end(), [&](const Vec3& p) { return p == rest[0]; })) {
    child.refuse(mesh.name + ": all nodes lie in one place at rest");
  }
  if (!all_within(mesh.weights, 0.0, kMaxWeight) ||
      !std::all_of(mesh.coordinates.begin(), mesh.coordinates.end(),
                   [](const auto& c) { return all_within(c, -kMaxCoordinate, kMaxCoordinate); })) {
    child.refuse(mesh.name + " has weights or coordinates that are none");
  }
}

void check_info(const Child& child, const BakeInfo& info,
                const std::vector<std::vector<double>>& metrics) {
  const bool ascending = std::adjacent_find(info.frames.begin(), info.frames.end(),
                                            std::greater_equal()) == info.frames.end();
  if (!ascending || info.frames.empty() || info.frames.front() < -kLastFrame ||
      info.frames.back() > kLastFrame || !(info.fps >= kMinRate && info.fps <= kMaxRate)) {
    child.refuse("its frames or its frame rate make no sense");
  }
  for (const BakeMesh& mesh : info.meshes) check_mesh(child, mesh);
  const BakeCharacter& character = info.character;
  if (!(character.scale >= kMinScale && character.scale <= kMaxScale) ||
      !are_bounded(character.rest)) {
    child.refuse("its character lies at rest where no place is, or farther than 10 km");
  }
  bool sound = metrics.size() == info.metric_names.size();
  for (const auto& metric : metrics) sound = sound && metric.size() == info.frames.size();
  if (!sound) child.refuse("its reader sent nonsense");
  for (std::size_t k = 0; k < metrics.size(); ++k) {
    if (all_within(metrics[k], -kMaxMetric, kMaxMetric)) continue;
    child.refuse("the metric " + info.metric_names[k] + " is no number in some frame");
  }
}

// Small requests and large answers: empty for all but the frames, else the place of a frame and of
// a mesh.
std::string answer(const std::filesystem::path& path, std::shared_ptr<OpenBake>& bake,
                   std::string_view request) {
  if (!bake) bake = std::make_shared<OpenBake>(path);
  if (request.empty()) return pack(bake->info, bake->metrics);
  std::size_t end = 0;
  const std::string text(request);
  const std::size_t at = std::stoul(text, &end);
  BakeFrame frame = bake->read(at, std::stoi(text.substr(end)));
  return pack(frame);
}

}  // namespace

// HDF5 1.10 crashes and hangs on some damaged files and leaks on many, so it reads in a child
// process.
namespace {

// The child gets an open file or none and could not say why. Error(kInput) with the cause.
const std::filesystem::path& readable(const std::filesystem::path& file) {
  if (::access(file.c_str(), R_OK) == 0 || errno == ENOENT) return file;
  throw Error(ErrorCode::kInput, file.string() + ": it cannot be read: " + std::strerror(errno) +
                                     "; check its permissions");
}

}  // namespace

struct BakeReader::Data {
  explicit Data(const std::filesystem::path& path)
      : child(readable(path), "give a bake.h5 of this version, or bake again",
              [path, bake = std::shared_ptr<OpenBake>()](std::string_view request) mutable {
                return answer(path, bake, request);
              }) {
    if (!unpack(child.ask(), info, metrics)) child.refuse("its reader sent nonsense");
    check_info(child, info, metrics);
  }

  /// The frame at place `index`, without metrics: of the mesh, or of all meshes for -1.
  BakeFrame read(int index, int mesh) const;

  mutable Child child;
  BakeInfo info;
  std::vector<std::vector<double>> metrics;  // by metric, then frame
};

BakeReader::BakeReader(const std::filesystem::path& file) : data_(std::make_unique<Data>(file)) {}

BakeReader::~BakeReader() = default;

const BakeInfo& BakeReader::info() const { return data_->info; }

BakeFrame BakeReader::Data::read(int index, int mesh) const {
  const std::size_t at = static_cast<std::size_t>(index), count = mesh < 0 ? info.meshes.size() : 1;
  if (index < 0 || at >= info.frames.size()) {
    child.refuse("it has no frame at place " + std::to_string(index));
  }
  const auto mesh_at = [&](std::size_t m) -> const BakeMesh& {
    return info.meshes[mesh < 0 ? m : static_cast<std::size_t>(mesh)];
  };
  BakeFrame frame;
  const std::string request = std::to_string(index) + " " + std::to_string(mesh);
  bool good = unpack(child.ask(request), frame) && frame.frame == info.frames[at] &&
              frame.positions.size() == count &&
              frame.lines.size() == (mesh < 0 ? info.meshes.size() : 0);
  for (std::size_t m = 0; good && m < count; ++m) {
    good = frame.positions[m].size() == mesh_at(m).rest.vertices.size() &&
           (mesh >= 0 || frame.lines[m].size() == mesh_at(m).line);
  }
  good = good && frame.bodies.size() == (mesh < 0 ? info.character.rest.size() : 0);
  if (!good) child.refuse("its reader sent nonsense");
  for (std::size_t m = 0; m < count; ++m) {
    const auto& x = frame.positions[m];
    const auto bad = std::find_if(x.begin(), x.end(), [](const Vec3& p) { return !is_bounded(p); });
    if (bad == x.end()) continue;
    child.refuse(mesh_at(m).name + ", frame " + std::to_string(frame.frame) + ", vertex " +
                 std::to_string(bad - x.begin()) +
                 " lies where no place is, or farther than 10 km");
  }
  for (std::size_t m = 0; m < frame.lines.size(); ++m) {
    const auto& line = frame.lines[m];
    if (std::all_of(line.begin(), line.end(), [](const Vec3& p) { return is_bounded(p); }))
      continue;
    child.refuse(mesh_at(m).name + ", frame " + std::to_string(frame.frame) +
                 ": its line of action lies where no place is, or farther than 10 km");
  }
  if (!are_bounded(frame.bodies)) {
    child.refuse("a body of its character lies where no place is in frame " +
                 std::to_string(frame.frame));
  }
  return frame;
}

BakeFrame BakeReader::read(int index) const {
  BakeFrame frame = data_->read(index, -1);
  for (const auto& metric : data_->metrics) {
    frame.metrics.push_back(metric[static_cast<std::size_t>(index)]);
  }
  return frame;
}

std::vector<Vec3> BakeReader::read_mesh(int index, int mesh) const {
  return std::move(data_->read(index, mesh).positions.front());
}

const std::vector<double>& BakeReader::metric(int metric) const {
  return data_->metrics[static_cast<std::size_t>(metric)];
}

}  // namespace thew::sim
