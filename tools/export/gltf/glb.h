// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// A document of glTF 2.0 and the numbers that it points to, all in one buffer.
struct Glb {
  nlohmann::ordered_json json;
  std::string bytes;
};

/// The most morph targets of a mesh: three.js draws no more.
inline constexpr std::size_t kMostTargets = 2048;
/// From so many morph targets on, readers of glTF get slow, and a user is told of --basis.
inline constexpr std::size_t kManyTargets = 250;

// Each returns the number of the new accessor. Numbers are rounded to float32.

/// With bounds, which positions need.
std::size_t add_vectors(Glb& glb, const std::vector<Vec3>& values, bool with_bounds);
/// Whole steps, which a reader divides by the largest of their type; each row begins at a multiple
/// of 4 bytes.
template <typename T>
std::size_t add_rows(Glb& glb, const std::vector<std::array<T, 3>>& rows, bool with_bounds);
/// Values of which only those at the places `among`, rising, are not zero. All of them are stored
/// where most are.
struct SparseIndices {
  std::vector<std::uint32_t> among;
  std::size_t view = static_cast<std::size_t>(-1);  ///< set by the first that is added
};
std::size_t add_sparse_vectors(Glb& glb, const std::vector<Vec3>& values, SparseIndices& indices,
                               bool with_bounds);
/// Values of an animation, `width` numbers each: 1, 3 or 4.
std::size_t add_keys(Glb& glb, const std::vector<float>& values, std::size_t width = 1);
std::size_t add_triangles(Glb& glb, const std::vector<Triangle>& triangles);

/// Adds a sampler and a channel to an animation.
void add_channel(nlohmann::ordered_json& animation, std::size_t node, const char* path,
                 std::size_t input, std::size_t output);

/// Writes the file; Error(kOutput) where it would be larger than the format can say.
void write_glb(const std::filesystem::path& file, Glb& glb);

/// As float32, the way the file holds them.
float as_float32(double value);
std::vector<Vec3> as_float32(const std::vector<Vec3>& values);

}  // namespace thew::tools
