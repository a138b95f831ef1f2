// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "rig/text.h"
#include "tools/base/text.h"
#include "tools/compare/geometry.h"

namespace thew::tools {
namespace {

constexpr double kSameTime = 1e-5;  // s
constexpr double kSameUv = 1e-6;

std::vector<int> frame_numbers(const PlayedGltf& file) {
  std::vector<int> numbers;
  for (std::size_t i = 0; i < file.times.size(); ++i) {
    numbers.push_back(file.fps > 0.0 ? static_cast<int>(std::lround(file.times[i] * file.fps))
                                     : static_cast<int>(i + 1));
  }
  return numbers;
}

std::string quoted(const std::string& name) { return "\"" + printable(name) + "\""; }

// What differs of one mesh that is no distance.
void compare_parts(const PlayedMesh& old, const PlayedMesh& now, std::vector<std::string>& faults) {
  const std::string name = quoted(old.name);
  if (old.name != now.name) faults.push_back(name + " is called " + quoted(now.name));
  if (old.material != now.material) {
    faults.push_back(name + " has the material " + quoted(now.material) + ", expected " +
                     quoted(old.material));
  }
  if (old.indices != now.indices) faults.push_back(name + " has other triangles");
  bool uvs = old.uvs.size() == now.uvs.size();
  for (std::size_t k = 0; uvs && k < old.uvs.size(); ++k) {
    uvs = std::abs(old.uvs[k] - now.uvs[k]) <= kSameUv;
  }
  if (!uvs) faults.push_back(name + " has other texture coordinates");
}

MeshDistance distance_of(const PlayedMesh& old, const PlayedMesh& now,
                         const std::vector<int>& numbers, const std::vector<std::size_t>& places) {
  MeshDistance out;
  out.name = old.name;
  double count = 0.0;
  for (const std::size_t i : places) {
    const auto &x = old.frames[i], &y = now.frames[i];
    double& most = out.by_frame.emplace_back(0.0);
    for (std::size_t v = 0; v < x.size(); ++v, ++count) {
      const double square = (x[v] - y[v]).squaredNorm(), distance = std::sqrt(square);
      out.rms += square;
      most = std::max(most, distance);
      if (distance <= out.largest) continue;
      out.largest = distance, out.frame = numbers[i], out.node = static_cast<int>(v);
    }
  }
  out.rms = count > 0.0 ? std::sqrt(out.rms / count) : 0.0;
  return out;
}

bool same_times(const PlayedGltf& a, const PlayedGltf& b) {
  bool same = a.times.size() == b.times.size();
  for (std::size_t i = 0; same && i < a.times.size(); ++i) {
    same = std::abs(a.times[i] - b.times[i]) <= kSameTime;
  }
  return same;
}

}  // namespace

GeometryComparison compare_exports(const PlayedGltf& expected, const PlayedGltf& actual,
                                   const std::vector<int>& frames, double tolerance) {
  GeometryComparison result;
  result.of_bakes = false;
  result.tolerance = tolerance;
  const auto number = [](std::size_t n) { return std::to_string(n); };
  if (!same_times(expected, actual)) {
    result.faults.push_back(
        "keys at " + number(actual.times.size()) + " times from " + readable(actual.times.front()) +
        " to " + readable(actual.times.back()) + " s, expected " + number(expected.times.size()) +
        " from " + readable(expected.times.front()) + " to " + readable(expected.times.back()) +
        " s");
    return result;
  }
  const std::vector<int> numbers = frame_numbers(expected);
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!frames.empty() && !std::binary_search(frames.begin(), frames.end(), numbers[i])) continue;
    places.push_back(i);
    result.frames.push_back(numbers[i]);
  }
  if (places.empty()) result.faults.push_back("there is no frame to compare");
  if (expected.meshes.size() != actual.meshes.size()) {
    result.faults.push_back(number(actual.meshes.size()) + " meshes, expected " +
                            number(expected.meshes.size()));
  }
  for (std::size_t m = 0; m < std::min(expected.meshes.size(), actual.meshes.size()); ++m) {
    const PlayedMesh &old = expected.meshes[m], &now = actual.meshes[m];
    compare_parts(old, now, result.faults);
    if (old.frames.front().size() != now.frames.front().size()) {
      result.faults.push_back(quoted(old.name) + " has " + number(now.frames.front().size()) +
                              " vertices, expected " + number(old.frames.front().size()));
      continue;
    }
    result.meshes.push_back(distance_of(old, now, numbers, places));
  }
  std::stable_sort(result.meshes.begin(), result.meshes.end(),
                   [](const auto& a, const auto& b) { return a.largest > b.largest; });
  result.exact =
      result.faults.empty() && (result.meshes.empty() || result.meshes.front().largest == 0.0);
  return result;
}

}  // namespace thew::tools
