// SPDX-License-Identifier: Apache-2.0
#include "tools/compare/played_gltf.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "rig/import/child.h"
#include "rig/import/gltf_file.h"
#include "rig/import/packed.h"

namespace thew::tools {
namespace {

using rig::Child;
using rig::GltfFile;
using Json = GltfFile::Json;

constexpr std::size_t kMostBytes = std::size_t{512} << 20;  // of positions
constexpr const char* kFewer = "compare exports of fewer --frames";

/// A curve of an animation: its keys, and `width` numbers at each.
struct Curve {
  std::vector<double> keys, values;
  std::size_t width = 1;
  bool step = false, cubic = false, turns = false;

  // At a key; of a cubic curve the tangents before and after it are its neighbours.
  Eigen::VectorXd at(std::size_t key, std::size_t part = 1) const {
    const std::size_t begin = (cubic ? 3 * key + part : key) * width;
    return Eigen::Map<const Eigen::VectorXd>(&values.at(begin), static_cast<Eigen::Index>(width));
  }
  Eigen::VectorXd value(double time) const {
    const auto next = std::upper_bound(keys.begin(), keys.end(), time);
    if (next == keys.begin()) return at(0);
    const auto k = static_cast<std::size_t>(next - keys.begin()) - 1;
    if (next == keys.end() || step) return at(k);
    const double span = keys[k + 1] - keys[k], t = (time - keys[k]) / span;
    if (cubic) {
      const double t2 = t * t, t3 = t2 * t;
      return (2 * t3 - 3 * t2 + 1) * at(k) + span * (t3 - 2 * t2 + t) * at(k, 2) +
             (3 * t2 - 2 * t3) * at(k + 1) + span * (t3 - t2) * at(k + 1, 0);
    }
    if (!turns) return (1 - t) * at(k) + t * at(k + 1);
    const Eigen::VectorXd a = at(k), b = at(k + 1);
    return Eigen::Quaterniond(Eigen::Vector4d(a))
        .slerp(t, Eigen::Quaterniond(Eigen::Vector4d(b)))
        .coeffs();
  }
};

struct Channel {
  std::size_t node;
  std::string path;
  Curve curve;
};

std::size_t targets_of(GltfFile& gltf, const Json& node) {
  if (!node.contains("mesh")) return 0;
  const Json& mesh = gltf.item("meshes", gltf.index_of(node, "mesh", "node"), "node");
  return mesh.at("primitives").at(0).value("targets", Json::array()).size();
}

std::vector<Channel> channels_of(GltfFile& gltf) {
  std::vector<Channel> channels;
  if (gltf.list("animations").empty()) return channels;
  const Json& animation = gltf.item("animations", 0, "file");
  for (const Json& from : animation.at("channels")) {
    const Json& target = from.at("target");
    if (!target.contains("node")) continue;
    Channel channel{
        gltf.index_of(target, "node", "channel"), GltfFile::text_of(target, "path"), {}};
    const Json& node = gltf.item("nodes", channel.node, "channel");
    const Json& sampler = animation.at("samplers").at(gltf.index_of(from, "sampler", "channel"));
    Curve& curve = channel.curve;
    const std::string kind = sampler.value("interpolation", "LINEAR");
    curve.step = kind == "STEP";
    curve.cubic = kind == "CUBICSPLINE";
    curve.turns = channel.path == "rotation";
    const bool weights = channel.path == "weights";
    curve.width = weights ? targets_of(gltf, node) : curve.turns ? 4 : 3;
    curve.keys = gltf.numbers(gltf.index_of(sampler, "input", "sampler"), 1);
    curve.values =
        gltf.numbers(gltf.index_of(sampler, "output", "sampler"), weights ? 1 : curve.width);
    if (curve.keys.empty() || curve.width == 0 ||
        curve.values.size() != (curve.cubic ? 3 : 1) * curve.width * curve.keys.size()) {
      gltf.refuse("has an animation with not as many values as keys");
    }
    channels.push_back(std::move(channel));
  }
  return channels;
}

std::vector<double> times_of(const std::vector<Channel>& channels) {
  constexpr double kSame = 1e-5;  // s, float32 at a minute
  std::vector<double> all, times;
  for (const Channel& channel : channels) {
    all.insert(all.end(), channel.curve.keys.begin(), channel.curve.keys.end());
  }
  std::sort(all.begin(), all.end());
  for (const double time : all) {
    if (times.empty() || time - times.back() > kSame) times.push_back(time);
  }
  return times.empty() ? std::vector<double>{0.0} : times;
}

/// What does not change in time of a primitive.
struct Part {
  std::size_t node, mesh;
  std::vector<double> base, joints, weights;  ///< of joints: four a vertex
  std::vector<std::vector<double>> targets;
  std::vector<double> target_weights;  ///< of the file, where nothing animates them
  std::vector<std::size_t> skeleton;   ///< nodes of its joints
  std::vector<double> inverse;         ///< 16 for each of them
};

/// A file that is being played.
struct Player {
  GltfFile& gltf;
  std::vector<Channel> channels;
  std::vector<Part> parts;
  std::vector<Eigen::Affine3d> world;  // by node

  const Curve* curve(std::size_t node, const char* path) const {
    for (const Channel& channel : channels) {
      if (channel.node == node && channel.path == path) return &channel.curve;
    }
    return nullptr;
  }
};

Eigen::Affine3d local(const Player& player, std::size_t number, double time) {
  GltfFile& gltf = player.gltf;
  const Json& node = gltf.item("nodes", number, "file");
  double matrix[16], t[3] = {0, 0, 0}, r[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
  if (gltf.numbers_of(node, "matrix", 16, "node", matrix)) {
    return Eigen::Affine3d(Eigen::Map<const Eigen::Matrix4d>(matrix));
  }
  const auto read = [&](const char* path, double* to, Eigen::Index count) {
    gltf.numbers_of(node, path, static_cast<std::size_t>(count), "node", to);
    if (const Curve* curve = player.curve(number, path)) {
      Eigen::Map<Eigen::VectorXd>(to, count) = curve->value(time);
    }
  };
  read("translation", t, 3);
  read("rotation", r, 4);
  read("scale", s, 3);
  return Eigen::Translation3d(t[0], t[1], t[2]) *
         Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized() * Eigen::Scaling(s[0], s[1], s[2]);
}

void place_nodes(Player& player, double time) {
  const std::size_t count = player.gltf.list("nodes").size();
  player.world.assign(count, Eigen::Affine3d::Identity());
  std::vector<char> placed(count, 0);
  std::vector<std::pair<std::size_t, Eigen::Affine3d>> open;
  std::vector<char> child(count, 0);
  const auto children = [&](std::size_t number) {
    return player.gltf.item("nodes", number, "file").value("children", Json::array());
  };
  for (std::size_t n = 0; n < count; ++n) {
    for (const Json& below : children(n)) child.at(below.get<std::size_t>()) = 1;
  }
  for (std::size_t n = 0; n < count; ++n) {
    if (!child[n]) open.emplace_back(n, Eigen::Affine3d::Identity());
  }
  while (!open.empty()) {
    const auto [number, above] = open.back();
    open.pop_back();
    if (placed.at(number)++) player.gltf.refuse("has a node below two others");
    player.world[number] = above * local(player, number, time);
    for (const Json& below : children(number)) {
      open.emplace_back(below.get<std::size_t>(), player.world[number]);
    }
  }
}

std::vector<Vec3> morphed(const Player& player, const Part& part, double time) {
  std::vector<double> flat = part.base;
  const Curve* curve = player.curve(part.node, "weights");
  const Eigen::VectorXd now =
      curve
          ? curve->value(time)
          : Eigen::VectorXd(Eigen::Map<const Eigen::VectorXd>(
                part.target_weights.data(), static_cast<Eigen::Index>(part.target_weights.size())));
  for (std::size_t k = 0; k < part.targets.size() && k < static_cast<std::size_t>(now.size());
       ++k) {
    const double weight = now[static_cast<Eigen::Index>(k)];
    for (std::size_t i = 0; weight != 0.0 && i < flat.size(); ++i) {
      flat[i] += weight * part.targets[k][i];
    }
  }
  std::vector<Vec3> shape;
  for (std::size_t i = 0; i + 2 < flat.size(); i += 3) shape.emplace_back(&flat[i]);
  return shape;
}

std::vector<Vec3> played(const Player& player, const Part& part, double time) {
  std::vector<Vec3> shape = morphed(player, part, time);
  if (part.skeleton.empty()) {
    for (Vec3& p : shape) p = player.world[part.node] * p;
    return shape;
  }
  std::vector<Eigen::Matrix4d> joints;
  for (std::size_t j = 0; j < part.skeleton.size(); ++j) {
    joints.push_back(player.world.at(part.skeleton[j]).matrix() *
                     Eigen::Map<const Eigen::Matrix4d>(&part.inverse[16 * j]));
  }
  for (std::size_t v = 0; v < shape.size(); ++v) {
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (std::size_t k = 4 * v; k < 4 * v + 4; ++k) {
      sum += part.weights[k] *
             (joints.at(static_cast<std::size_t>(part.joints[k])) * shape[v].homogeneous());
    }
    shape[v] = sum[3] != 0.0 ? Vec3(sum.head<3>() / sum[3]) : Vec3(sum.head<3>());
  }
  return shape;
}

void read_skin(GltfFile& gltf, const Json& node, const Json& attributes, Part& part) {
  if (!node.contains("skin") || !attributes.contains("JOINTS_0")) return;
  const Json& skin = gltf.item("skins", gltf.index_of(node, "skin", "node"), "node");
  for (const Json& joint : skin.at("joints")) part.skeleton.push_back(joint.get<std::size_t>());
  if (skin.contains("inverseBindMatrices")) {
    part.inverse = gltf.numbers(gltf.index_of(skin, "inverseBindMatrices", "skin"), 16);
  } else {
    for (std::size_t k = 0; k < 16 * part.skeleton.size(); ++k) {
      part.inverse.push_back(k % 16 % 5 == 0 ? 1.0 : 0.0);
    }
  }
  for (const std::uint32_t joint :
       gltf.indices(gltf.index_of(attributes, "JOINTS_0", "attributes"), 4)) {
    part.joints.push_back(joint);
  }
  part.weights = gltf.numbers(gltf.index_of(attributes, "WEIGHTS_0", "attributes"), 4, true);
  const std::size_t four = part.base.size() / 3 * 4;
  if (part.joints.size() != four || part.weights.size() != four ||
      part.inverse.size() < 16 * part.skeleton.size()) {
    gltf.refuse("has a skin with not as many weights as vertices");
  }
}

void read_part(GltfFile& gltf, std::size_t number, const Json& mesh, const Json& primitive,
               Player& player, PlayedGltf& out) {
  const Json& node = gltf.item("nodes", number, "file");
  const Json& attributes = primitive.at("attributes");
  Part part{number, out.meshes.size(), {}, {}, {}, {}, {}, {}, {}};
  part.base = gltf.numbers(gltf.index_of(attributes, "POSITION", "attributes"), 3);
  for (const Json& target : primitive.value("targets", Json::array())) {
    auto& values = part.targets.emplace_back(part.base.size(), 0.0);
    if (!target.contains("POSITION")) continue;
    values = gltf.numbers(gltf.index_of(target, "POSITION", "target"), 3);
    if (values.size() != part.base.size()) gltf.refuse("has a morph target of another size");
  }
  part.target_weights = node.value("weights", mesh.value("weights", std::vector<double>()));
  part.target_weights.resize(part.targets.size(), 0.0);
  read_skin(gltf, node, attributes, part);
  PlayedMesh& played = out.meshes.emplace_back();
  played.name = GltfFile::text_of(node, "name");
  if (played.name.empty()) played.name = GltfFile::text_of(mesh, "name");
  if (primitive.contains("indices")) {
    played.indices = gltf.indices(gltf.index_of(primitive, "indices", "primitive"), 1);
  }
  if (attributes.contains("TEXCOORD_0")) {
    played.uvs = gltf.numbers(gltf.index_of(attributes, "TEXCOORD_0", "attributes"), 2);
  }
  if (primitive.contains("material")) {
    const std::size_t material = gltf.index_of(primitive, "material", "primitive");
    played.material = GltfFile::text_of(gltf.item("materials", material, "primitive"), "name");
  }
  player.parts.push_back(std::move(part));
}

// Exports of ours say it as a text.
double fps_of(const Json& json) {
  const Json extras = json.value("asset", Json::object()).value("extras", Json::object());
  if (!extras.is_object() || !extras.contains("fps")) return 0.0;
  const Json& fps = extras["fps"];
  const double value = fps.is_string()   ? std::atof(fps.get<std::string>().c_str())
                       : fps.is_number() ? fps.get<double>()
                                         : 0.0;
  return value > 0.0 && value < 1e5 ? value : 0.0;
}

PlayedGltf play(GltfFile& gltf) {
  Player player{gltf, channels_of(gltf), {}, {}};
  PlayedGltf out{times_of(player.channels), fps_of(gltf.json()), {}};
  for (std::size_t n = 0; n < gltf.list("nodes").size(); ++n) {
    const Json& node = gltf.item("nodes", n, "file");
    if (!node.contains("mesh")) continue;
    const Json& mesh = gltf.item("meshes", gltf.index_of(node, "mesh", "node"), "node");
    for (const Json& primitive : mesh.at("primitives")) {
      read_part(gltf, n, mesh, primitive, player, out);
    }
  }
  std::size_t bytes = 0;
  for (const Part& part : player.parts) bytes += 8 * part.base.size() * out.times.size();
  if (bytes > kMostBytes) {
    gltf.refuse("has positions of " + std::to_string(bytes >> 20) + " MiB in all its frames",
                kFewer);
  }
  for (const double time : out.times) {
    place_nodes(player, time);
    for (const Part& part : player.parts) {
      out.meshes[part.mesh].frames.push_back(played(player, part, time));
    }
  }
  return out;
}

template <typename Archive>
void walk(Archive& archive, PlayedGltf& played) {
  archive.list(played.times);
  archive.number(played.fps);
  archive.each(played.meshes, [](Archive& a, PlayedMesh& mesh) {
    a.list(mesh.name);
    a.list(mesh.material);
    a.list(mesh.indices);
    a.list(mesh.uvs);
    a.each(mesh.frames, [](Archive& in, std::vector<Vec3>& x) { in.list(x); });
  });
}

std::string answer(const std::filesystem::path& file) {
  GltfFile gltf(file);
  try {
    PlayedGltf played = play(gltf);
    rig::Packer packer;
    walk(packer, played);
    return packer.bytes;
  } catch (const Json::exception&) {
    gltf.refuse("its JSON is not built as glTF has it");
  } catch (const std::out_of_range&) {
    gltf.refuse("names a node, a joint or a key that is not there");
  }
}

}  // namespace

PlayedGltf play_gltf(const std::filesystem::path& file) {
  Child child(file, "export the character again", [&](std::string_view) { return answer(file); });
  const std::string bytes = child.ask();
  PlayedGltf played;
  rig::Unpacker unpacker{bytes};
  walk(unpacker, played);
  bool sound = unpacker.finished() && !played.times.empty();
  for (const PlayedMesh& mesh : played.meshes) {
    sound = sound && mesh.frames.size() == played.times.size();
    for (const auto& x : mesh.frames) sound = sound && x.size() == mesh.frames.front().size();
  }
  if (!sound) child.refuse("its reader sent nonsense");
  return played;
}

}  // namespace thew::tools
