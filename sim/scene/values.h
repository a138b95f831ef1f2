// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "rig/limits.h"
#include "sim/scene/toml.h"

namespace thew::sim {

// Values of a scene, checked: what is not as asked for is refused with its place.

/// What a number may be; `above` leaves out `least` itself.
struct Range {
  double least = -1e12, most = 1e12;
  bool above = false;
};
inline constexpr Range kPositive{1e-12, 1e12}, kNotNegative{0.0, 1e12}, kShare{0.0, 1.0};
/// m: where a point is; a length; one that has to be longer than what float32 rounds off.
inline constexpr Range kPlace{-kMaxCoordinate, kMaxCoordinate}, kLength{0.0, kMaxCoordinate},
    kSize{1e-6, kMaxCoordinate};
inline constexpr Range kScale{kMinScale, kMaxScale};
/// What a direction is given by; it is made unit.
inline constexpr Range kDirection{-1e6, 1e6};
inline constexpr int kLastFrame = 1000000;
inline constexpr Range kFrames{-kLastFrame, kLastFrame};

double number_of(const TomlValue& value, const Range& range);
/// m: a number, or a text with its unit, "0.5 mm".
double length_of(const TomlValue& value, const Range& range);
int integer_of(const TomlValue& value, int least, int most);
bool truth_of(const TomlValue& value);
/// Not empty, no control characters.
const std::string& text_of(const TomlValue& value);
const std::string& word_of(const TomlValue& value, const std::vector<std::string>& words);
/// A text that may name a file or a dataset: letters, digits, - and _.
const std::string& name_of(const TomlValue& value);
/// Items of an array of `least` to `most`; `what` says what it should be: "[x, y, z]".
std::vector<TomlValue>& items_of(TomlValue& value, const std::string& what, std::size_t least,
                                 std::size_t most);
Vec3 vector_of(TomlValue& value, const Range& range);
/// Not zero; unit.
Vec3 direction_of(TomlValue& value);
/// Paths of a scene are relative to `base` and stay below `root`; both canonical.
struct Folders {
  std::filesystem::path base, root;
};
/// The regular file that a text names, canonical.
std::filesystem::path file_of(const TomlValue& value, const Folders& folders);

using Pairs = std::vector<std::array<double, 2>>;
/// [[a, b], ...] with a strictly increasing; `what` says what they are: "[frame, activation]".
Pairs pairs_of(TomlValue& value, const std::string& what, const Range& first, const Range& second);

// Where the key is absent `out` keeps its default.
void read(TomlValue& table, const std::string& key, double& out, const Range& range);
void read(TomlValue& table, const std::string& key, int& out, int least, int most);
void read(TomlValue& table, const std::string& key, bool& out);
void read(TomlValue& table, const std::string& key, Vec3& out, const Range& range);
void read(TomlValue& table, const std::string& key, std::string& out,
          const std::vector<std::string>& words);

}  // namespace thew::sim
