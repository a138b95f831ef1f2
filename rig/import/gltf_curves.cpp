// SPDX-License-Identifier: Apache-2.0
#include "rig/import/gltf_curves.h"

#include <algorithm>
#include <cmath>

namespace thew::rig {
namespace {

using Json = GltfFile::Json;

constexpr double kMaxTime = 1e9;  // s, before or after 0

Vec3 value_at(const double* from, const Vec3*) { return {from[0], from[1], from[2]}; }
Eigen::Quaterniond value_at(const double* from, const Eigen::Quaterniond*) {
  return {from[3], from[0], from[1], from[2]};
}

// Reads one curve, its values multiplied by `size`. A key that is not after the one before or lies
// beyond kMaxTime is left out.
template <typename Value>
Curve<Value> read_curve(GltfFile& gltf, const Json& sampler, CurveInterpolation interpolation,
                        double size, const std::string& location) {
  const Value* const kind = nullptr;
  constexpr size_t kWidth = std::is_same_v<Value, Vec3> ? 3 : 4;
  const bool cubic = interpolation == CurveInterpolation::kCubic;
  const std::vector<double> times = gltf.numbers(gltf.index_of(sampler, "input", location), 1);
  std::vector<double> flat =
      gltf.numbers(gltf.index_of(sampler, "output", location), kWidth, kWidth == 4);
  const size_t stride = kWidth * (cubic ? 3 : 1);  // in-tangent, value, out-tangent
  if (flat.size() != times.size() * stride) {
    gltf.refuse(location + " has " + std::to_string(times.size()) + " times and " +
                std::to_string(flat.size() / kWidth) + " values");
  }
  for (double& number : flat) number *= size;
  Curve<Value> curve;
  curve.interpolation = interpolation;
  for (size_t k = 0; k < times.size(); ++k) {
    if (!(std::abs(times[k]) < kMaxTime)) continue;
    if (!curve.times.empty() && times[k] <= curve.times.back()) continue;
    const double* from = flat.data() + k * stride;
    if (cubic) {
      curve.slopes_in.push_back(value_at(from, kind));
      curve.slopes_out.push_back(value_at(from + 2 * kWidth, kind));
      from += kWidth;
    }
    curve.times.push_back(times[k]);
    curve.values.push_back(value_at(from, kind));
    if constexpr (kWidth == 4) {
      if (!(curve.values.back().norm() > 1e-6)) {
        gltf.refuse(location + ", key " + std::to_string(k) + ", is a rotation of length 0");
      }
      if (!cubic) curve.values.back().normalize();
    }
  }
  return curve;
}

struct Channel {
  const Json* sampler;
  std::string location, path;
  int body;
  CurveInterpolation interpolation;
};

// Reads one channel. False if it moves no body, such as a morph target or the target of an
// extension. Counts interpolations that glTF does not have in `strange`.
bool read_channel(const GltfFile& gltf, const Json& animation, const std::string& location,
                  const Json& channel, const std::vector<int>& body, Channel& out, int& strange) {
  const auto target = channel.is_object() ? channel.find("target") : channel.end();
  const auto samplers = animation.find("samplers");
  if (!channel.is_object() || target == channel.end() || !target->is_object() ||
      samplers == animation.end() || !samplers->is_array()) {
    gltf.refuse(location + " has a channel without a target or a sampler");
  }
  out.path = GltfFile::text_of(*target, "path");
  if (out.path != "translation" && out.path != "rotation" && out.path != "scale") return false;
  if (!target->contains("node")) return false;
  const size_t node = gltf.index_of(*target, "node", location);
  gltf.item("nodes", node, location);
  out.body = body[node];
  const size_t index = gltf.index_of(channel, "sampler", location);
  if (index >= samplers->size() || !(*samplers)[index].is_object()) {
    gltf.refuse(location + " names samplers[" + std::to_string(index) + "] of " +
                std::to_string(samplers->size()));
  }
  out.sampler = &(*samplers)[index];
  out.location = location + ".samplers[" + std::to_string(index) + "]";
  const std::string named = GltfFile::text_of(*out.sampler, "interpolation");
  out.interpolation = named == "STEP"          ? CurveInterpolation::kStep
                      : named == "CUBICSPLINE" ? CurveInterpolation::kCubic
                                               : CurveInterpolation::kLinear;
  strange +=
      out.interpolation == CurveInterpolation::kLinear && named != "LINEAR" && !named.empty();
  return out.body >= 0;
}

}  // namespace

void read_gltf_animations(GltfFile& gltf, const std::vector<int>& body, double scale,
                          Character& character) {
  int strange = 0;
  const Json& animations = gltf.list("animations");
  for (size_t a = 0; a < animations.size(); ++a) {
    const std::string location = "animations[" + std::to_string(a) + "]";
    const Json& animation = gltf.item("animations", a, "the file");
    BodyClip clip;
    clip.name = GltfFile::text_of(animation, "name");
    if (clip.name.empty()) clip.name = "animation_" + std::to_string(a + 1);
    const auto channels = animation.find("channels");
    if (channels == animation.end() || !channels->is_array())
      gltf.refuse(location + " has no channels");
    std::vector<int> track_of(character.skeleton.parent.size(), -1);
    for (const Json& one : *channels) {
      Channel channel;
      if (!read_channel(gltf, animation, location, one, body, channel, strange)) continue;
      if (track_of[channel.body] < 0) {
        track_of[channel.body] = static_cast<int>(clip.tracks.size());
        clip.tracks.emplace_back().body = channel.body;
      }
      BodyTrack& track = clip.tracks[track_of[channel.body]];
      // The scale of the file is applied at the root.
      const double size = channel.body == 0 ? scale : 1.0;
      const auto put = [&](auto& curve, double by) {
        using Value = std::decay_t<decltype(curve.values[0])>;
        curve =
            read_curve<Value>(gltf, *channel.sampler, channel.interpolation, by, channel.location);
        if (!curve.times.empty()) clip.duration = std::max(clip.duration, curve.times.back());
      };
      if (channel.path == "rotation") put(track.rotation, 1.0);
      if (channel.path == "translation") put(track.translation, size);
      if (channel.path == "scale") put(track.scale, size);
    }
    character.animations.push_back(std::move(clip));
  }
  if (strange == 0) return;
  character.warnings.push_back(gltf.file().string() + ": " + std::to_string(strange) +
                               " animated curves are of no interpolation that glTF has, and are "
                               "taken for straight lines between their keys; export with the "
                               "animation sampled at every frame");
}

}  // namespace thew::rig
