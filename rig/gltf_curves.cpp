// SPDX-License-Identifier: Apache-2.0
#include "rig/gltf_curves.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>

#include "rig/assimp_scene.h"
#include "rig/child.h"
#include "rig/json_number.h"
#include "rig/text.h"

namespace thew {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// What a curve lacks to be read; the curve stays as assimp has it.
struct Lost {};

void need(bool condition) {
  if (!condition) throw Lost();
}

std::string from_base64(std::string_view text) {
  constexpr std::string_view kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t value = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    const size_t digit = kDigits.find(c);
    need(digit != std::string_view::npos);
    value = value << 6 | static_cast<std::uint32_t>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    out.push_back(static_cast<char>(value >> bits & 255u));
  }
  return out;
}

// A glTF's JSON and its buffers, read when they are asked for.
class Gltf {
 public:
  Gltf() : bytes_(read_in_child(file_of_child(), kAssimpFileLimit)) {
    std::string_view text = bytes_;
    if (text.substr(0, 4) == "glTF" && text.size() > 20) {  // chunks: length, kind, bytes
      std::uint32_t length = 0;
      std::memcpy(&length, text.data() + 12, sizeof length);
      if (text.size() - 20 > size_t{length} + 8) binary_ = text.substr(20 + size_t{length} + 8);
      text = text.substr(20, length);
    }
    json = Json::parse(text, nullptr, false);
  }

  static size_t count_of(const Json& value) {
    const auto number = whole_number(value);
    need(number && *number >= 0);
    return static_cast<size_t>(*number);
  }

  /// Numbers of an accessor, `width` to an item.
  std::vector<double> numbers(size_t accessor, size_t width) {
    const Json& a = json.at("accessors").at(accessor);
    need(!a.contains("sparse") && a.contains("bufferView"));
    static const std::map<std::string, size_t> kWidths = {
        {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
    const auto found = kWidths.find(a.at("type").get<std::string>());
    need(found != kWidths.end() && found->second == width);
    const size_t type = count_of(a.at("componentType"));
    const size_t size = type == 5126 ? 4 : type == 5122 || type == 5123 ? 2 : 1;
    need(size > 1 || type == 5120 || type == 5121);
    const Json& view = json.at("bufferViews").at(count_of(a.at("bufferView")));
    const std::string_view whole = buffer(count_of(view.at("buffer")));
    const size_t begin = count_of(view.value("byteOffset", Json(0))),
                 bytes = count_of(view.at("byteLength"));
    need(begin <= whole.size() && bytes <= whole.size() - begin);
    const std::string_view from = whole.substr(begin, bytes);
    const size_t stride = count_of(view.value("byteStride", Json(width * size))),
                 count = count_of(a.at("count"));
    const size_t first = count_of(a.value("byteOffset", Json(0)));
    need(count > 0 && stride >= width * size && stride <= 252 && first <= from.size() &&
         width * size <= from.size() - first &&
         (count - 1) <= (from.size() - first - width * size) / stride);
    std::vector<double> out;
    for (size_t i = 0; i < count; ++i) {
      for (size_t k = 0; k < width; ++k) {
        out.push_back(number(from.data() + first + i * stride + k * size, type));
        need(std::isfinite(out.back()));
      }
    }
    return out;
  }

  Json json;

 private:
  // Integers are shares of their largest, as glTF has it.
  static double number(const char* at, size_t type) {
    const auto as = [at](auto value) {
      std::memcpy(&value, at, sizeof value);
      return static_cast<double>(value);
    };
    switch (type) {
      case 5120:
        return std::max(as(std::int8_t{}) / 127.0, -1.0);
      case 5121:
        return as(std::uint8_t{}) / 255.0;
      case 5122:
        return std::max(as(std::int16_t{}) / 32767.0, -1.0);
      case 5123:
        return as(std::uint16_t{}) / 65535.0;
      default:
        return as(float{});
    }
  }

  std::string_view buffer(size_t index) {
    if (const auto found = buffers_.find(index); found != buffers_.end()) return found->second;
    const Json& entry = json.at("buffers").at(index);
    if (!entry.contains("uri")) {
      need(index == 0);
      return binary_;
    }
    const std::string uri = entry.at("uri");
    std::string& bytes = buffers_[index];
    if (uri.starts_with("data:")) {
      const size_t comma = uri.find(";base64,");
      need(comma != std::string::npos);
      bytes = from_base64(std::string_view(uri).substr(comma + 8));
      return bytes;
    }
    try {
      bytes = read_in_child(uri, kAssimpFileLimit);
    } catch (const Error&) {
      throw Lost();
    }
    return bytes;
  }

  std::string bytes_;
  std::string_view binary_;
  std::map<size_t, std::string> buffers_;
};

// The place of a vector, or of a quaternion, in flat numbers.
Vec3 value_at(const double* from, const Vec3*) { return {from[0], from[1], from[2]}; }
Eigen::Quaterniond value_at(const double* from, const Eigen::Quaterniond*) {
  return {from[3], from[0], from[1], from[2]};
}

template <typename Value>
Curve<Value> read_curve(Gltf& gltf, const Json& sampler, bool cubic, double size) {
  const Value* const kind = nullptr;
  const size_t width = std::is_same_v<Value, Vec3> ? 3 : 4;
  Curve<Value> curve;
  curve.way = cubic ? CurveWay::kCubic : CurveWay::kStep;
  curve.times = gltf.numbers(Gltf::count_of(sampler.at("input")), 1);
  for (size_t k = 1; k < curve.times.size(); ++k) need(curve.times[k] > curve.times[k - 1]);
  std::vector<double> flat = gltf.numbers(Gltf::count_of(sampler.at("output")), width);
  need(flat.size() == curve.times.size() * width * (cubic ? 3 : 1));
  for (double& number : flat) number *= size;
  for (size_t k = 0; k < curve.times.size(); ++k) {
    const double* from = flat.data() + k * width * (cubic ? 3 : 1);
    if (cubic) {
      curve.slopes_in.push_back(value_at(from, kind));
      curve.slopes_out.push_back(value_at(from + 2 * width, kind));
      from += width;
    }
    curve.values.push_back(value_at(from, kind));
    if constexpr (!std::is_same_v<Value, Vec3>) {
      need(curve.values.back().norm() > 1e-6);
      if (!cubic) curve.values.back().normalize();
    }
  }
  return curve;
}

void mend_channel(Gltf& gltf, const Json& channel, const Json& sampler, double scale,
                  const std::function<int(const std::string&)>& body_of, BodyClip& clip) {
  const bool cubic = sampler.at("interpolation") == "CUBICSPLINE";
  const Json& target = channel.at("target");
  const size_t index = Gltf::count_of(target.at("node"));
  std::string name = gltf.json.at("nodes").at(index).value("name", std::string());
  if (name.empty()) name = "nodes[" + std::to_string(index) + "]";  // as assimp calls it
  const int body = body_of(name);
  const std::string path = target.at("path");
  const double size = body == 0 ? scale : 1.0;
  for (BodyTrack& track : clip.tracks) {
    if (track.body != body) continue;
    if (path == "rotation") {
      track.rotation = read_curve<Eigen::Quaterniond>(gltf, sampler, cubic, 1.0);
    } else {
      (path == "scale" ? track.scale : track.translation) =
          read_curve<Vec3>(gltf, sampler, cubic, size);
    }
    return;
  }
  throw Lost();
}

}  // namespace

void mend_gltf_curves(const fs::path& file, double scale,
                      const std::function<int(const std::string&)>& body_of, Character& character) {
  Gltf gltf;
  if (!gltf.json.is_object() || !gltf.json.contains("animations")) return;
  int lost = 0;
  size_t index = 0;
  for (const Json& animation : gltf.json["animations"]) {
    const size_t clip = index++;
    if (!animation.is_object() || !animation.contains("channels")) continue;
    for (const Json& channel : animation["channels"]) {
      try {
        const Json& sampler = animation.at("samplers").at(Gltf::count_of(channel.at("sampler")));
        const std::string way = sampler.value("interpolation", std::string("LINEAR"));
        if (way == "LINEAR" || channel.at("target").value("path", "") == "weights") continue;
        need((way == "STEP" || way == "CUBICSPLINE") && clip < character.animations.size());
        mend_channel(gltf, channel, sampler, scale, body_of, character.animations[clip]);
      } catch (const Lost&) {
        ++lost;
      } catch (const Json::exception&) {
        ++lost;
      }
    }
  }
  if (lost == 0) return;
  character.warnings.push_back(file.string() + ": " + std::to_string(lost) +
                               " animated curves that are no straight lines cannot be read, and "
                               "are taken for such between their keys; export with the animation "
                               "sampled at every frame");
}

}  // namespace thew
