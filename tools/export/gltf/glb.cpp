// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/glb.h"

#include <algorithm>
#include <cstring>
#include <numeric>

#include "tools/base/output_file.h"
#include "tools/base/printing.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::uint64_t kMostOfGlb = 0xffffffffu;  // lengths in the file are 32 bits wide
constexpr std::size_t kNone = static_cast<std::size_t>(-1);
enum ComponentType { kInt8 = 5120, kInt16 = 5122, kUint32 = 5125, kFloat = 5126 };
enum BufferTarget { kNoTarget = 0, kVertices = 34962, kIndices = 34963 };

std::size_t add_item(ordered_json& list, ordered_json item) {
  list.push_back(std::move(item));
  return list.size() - 1;
}

// The bytes from `begin` on as a view.
std::size_t add_view(Glb& glb, std::size_t begin, BufferTarget target) {
  ordered_json view = {
      {"buffer", 0}, {"byteOffset", begin}, {"byteLength", glb.bytes.size() - begin}};
  if (target != kNoTarget) view["target"] = static_cast<int>(target);
  return add_item(glb.json["bufferViews"], std::move(view));
}

std::size_t add_accessor(Glb& glb, ordered_json data, std::size_t count, const char* type,
                         ComponentType component) {
  data["componentType"] = static_cast<int>(component);
  data["count"] = count;
  data["type"] = type;
  return add_item(glb.json["accessors"], std::move(data));
}

std::size_t begin_of_floats(Glb& glb) {
  glb.bytes.resize((glb.bytes.size() + 3) / 4 * 4, '\0');
  return glb.bytes.size();
}

void add_bounds(const std::vector<Vec3>& values, ordered_json& accessor) {
  Vec3 low = values.front(), high = low;
  for (const Vec3& value : values) {
    low = low.cwiseMin(value);
    high = high.cwiseMax(value);
  }
  for (const auto& [name, bound] : {std::pair("min", low), std::pair("max", high)}) {
    accessor[name] = ordered_json::array();
    for (int axis = 0; axis < 3; ++axis) accessor[name].push_back(as_float32(bound[axis]));
  }
}

ordered_json sparse_data(std::size_t count, std::size_t indices, std::size_t values) {
  return {{"sparse",
           {{"count", count},
            {"indices", {{"bufferView", indices}, {"componentType", static_cast<int>(kUint32)}}},
            {"values", {{"bufferView", values}}}}}};
}

std::size_t add_indices(Glb& glb, const std::vector<std::uint32_t>& indices) {
  const std::size_t begin = begin_of_floats(glb);
  for (const std::uint32_t index : indices) put(glb.bytes, index);
  return add_view(glb, begin, kNoTarget);
}

}  // namespace

std::size_t add_vectors(Glb& glb, const std::vector<Vec3>& values, bool with_bounds) {
  const std::size_t begin = begin_of_floats(glb);
  for (const Vec3& value : values) put_floats(glb.bytes, value);
  const ordered_json data = {{"bufferView", add_view(glb, begin, kVertices)}};
  const std::size_t accessor = add_accessor(glb, data, values.size(), "VEC3", kFloat);
  if (with_bounds) add_bounds(values, glb.json["accessors"][accessor]);
  return accessor;
}

template <typename T>
std::size_t add_rows(Glb& glb, const std::vector<std::array<T, 3>>& rows, bool with_bounds) {
  constexpr std::size_t kRow = (3 * sizeof(T) + 3) / 4 * 4;
  const std::size_t begin = begin_of_floats(glb);
  std::array<T, 3> low = rows.front(), high = low;
  for (const auto& row : rows) {
    for (std::size_t k = 0; k < 3; ++k) {
      put(glb.bytes, row[k]);
      low[k] = std::min(low[k], row[k]);
      high[k] = std::max(high[k], row[k]);
    }
    glb.bytes.append(kRow - 3 * sizeof(T), '\0');
  }
  const std::size_t view = add_view(glb, begin, kVertices);
  glb.json["bufferViews"][view]["byteStride"] = kRow;
  const std::size_t accessor = add_accessor(glb, {{"bufferView", view}}, rows.size(), "VEC3",
                                            sizeof(T) == 1 ? kInt8 : kInt16);
  ordered_json& written = glb.json["accessors"][accessor];
  written["normalized"] = true;
  if (with_bounds) {
    written["min"] = low;
    written["max"] = high;
  }
  return accessor;
}
template std::size_t add_rows(Glb&, const std::vector<std::array<std::int8_t, 3>>&, bool);
template std::size_t add_rows(Glb&, const std::vector<std::array<std::int16_t, 3>>&, bool);

std::size_t add_sparse_vectors(Glb& glb, const std::vector<Vec3>& values, SparseIndices& indices,
                               bool with_bounds) {
  // A place takes 4 bytes once and 12 for each set of values.
  if (indices.among.empty() || indices.among.size() > values.size() / 10 * 9) {
    return add_vectors(glb, values, with_bounds);
  }
  if (indices.view == kNone) indices.view = add_indices(glb, indices.among);
  const std::size_t begin = begin_of_floats(glb);
  for (const std::uint32_t index : indices.among) put_floats(glb.bytes, values[index]);
  const std::size_t view = add_view(glb, begin, kNoTarget);
  const std::size_t accessor = add_accessor(
      glb, sparse_data(indices.among.size(), indices.view, view), values.size(), "VEC3", kFloat);
  if (with_bounds) add_bounds(values, glb.json["accessors"][accessor]);
  return accessor;
}

std::size_t add_keys(Glb& glb, const std::vector<float>& values, std::size_t width) {
  constexpr const char* kTypes[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  std::vector<std::uint32_t> among;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != 0.0f) among.push_back(static_cast<std::uint32_t>(i));
  }
  std::size_t accessor = 0;
  if (width == 1 && !among.empty() && 2 * among.size() < values.size()) {
    // The weights of one target a frame: all but one in each frame are zero.
    const std::size_t indices = add_indices(glb, among), begin = begin_of_floats(glb);
    for (const std::uint32_t index : among) put(glb.bytes, values[index]);
    const std::size_t view = add_view(glb, begin, kNoTarget);
    accessor = add_accessor(glb, sparse_data(among.size(), indices, view), values.size(), "SCALAR",
                            kFloat);
  } else {
    const std::size_t begin = begin_of_floats(glb);
    for (const float value : values) put(glb.bytes, value);
    const ordered_json data = {{"bufferView", add_view(glb, begin, kNoTarget)}};
    accessor = add_accessor(glb, data, values.size() / width, kTypes[width], kFloat);
  }
  if (width != 1) return accessor;
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  glb.json["accessors"][accessor]["min"] = ordered_json::array({*low});
  glb.json["accessors"][accessor]["max"] = ordered_json::array({*high});
  return accessor;
}

std::size_t add_triangles(Glb& glb, const std::vector<Triangle>& triangles) {
  const std::size_t begin = begin_of_floats(glb);
  for (const Triangle& triangle : triangles) {
    for (const int vertex : triangle) put(glb.bytes, static_cast<std::uint32_t>(vertex));
  }
  const ordered_json data = {{"bufferView", add_view(glb, begin, kIndices)}};
  return add_accessor(glb, data, 3 * triangles.size(), "SCALAR", kUint32);
}

void add_channel(ordered_json& animation, std::size_t node, const char* path, std::size_t input,
                 std::size_t output) {
  animation["channels"].push_back(
      {{"sampler", animation["samplers"].size()}, {"target", {{"node", node}, {"path", path}}}});
  animation["samplers"].push_back({{"input", input}, {"output", output}});
}

void write_glb(const std::filesystem::path& file, Glb& glb) {
  begin_of_floats(glb);  // chunks are of whole words
  glb.json["buffers"] = ordered_json::array({{{"byteLength", glb.bytes.size()}}});
  std::string json = json_text(glb.json, -1);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::uint64_t length = 12 + 8 + json.size() + 8 + glb.bytes.size();
  if (length > kMostOfGlb) {
    throw Error(ErrorCode::kOutput,
                file.string() + ": glTF binary holds 4 GiB and this would be " +
                    std::to_string(length >> 30) +
                    "; choose fewer --frames or --mesh, or a --basis of some targets");
  }
  std::string bytes = "glTF";
  put<std::uint32_t>(bytes, 2);
  put(bytes, static_cast<std::uint32_t>(length));
  put(bytes, static_cast<std::uint32_t>(json.size()));
  bytes += "JSON" + json;
  put(bytes, static_cast<std::uint32_t>(glb.bytes.size()));
  bytes += std::string("BIN\0", 4);
  ExportFile out(file);
  out.append(bytes);
  out.append(glb.bytes);
  out.finish();
}

// By way of the bytes, since GCC 12 vectorises a cast to float and back into nothing.
float as_float32(double value) {
  volatile float rounded = static_cast<float>(value);
  return rounded;
}

std::vector<Vec3> as_float32(const std::vector<Vec3>& values) {
  std::string bytes;
  for (const Vec3& value : values) put_floats(bytes, value);
  std::vector<Eigen::Vector3f> floats(values.size());
  std::memcpy(static_cast<void*>(floats.data()), bytes.data(), bytes.size());
  std::vector<Vec3> result;
  for (const Eigen::Vector3f& value : floats) result.push_back(value.cast<double>());
  return result;
}

}  // namespace thew::tools
