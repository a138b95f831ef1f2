// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "sim/scene/toml.h"

namespace thew::sim {

// Values of a scene, checked against the declarations of their keys: what is not as declared is
// refused with its location.

double number_of(const TomlValue& value, const Range& range);
/// m: a number, or a text with its unit, "0.5 mm".
double length_of(const TomlValue& value, const Range& range);
int integer_of(const TomlValue& value, const Range& range);
bool truth_of(const TomlValue& value);
/// A text of one line: not empty, without control characters.
const std::string& text_of(const TomlValue& value);
/// One of the key's words.
const std::string& word_of(const TomlValue& value, const Key& key);
/// A text that may name a file or a dataset: letters, digits, - and _.
const std::string& name_of(const TomlValue& value);
/// Items of an array of `least` to `most`; `what` says what it should be: "a pair, [u, weight]".
std::vector<TomlValue>& items_of(TomlValue& value, const std::string& what, std::size_t least,
                                 std::size_t most);
Vec3 vector_of(TomlValue& value, const Range& range);
/// A vector that is not zero, made unit.
Vec3 direction_of(TomlValue& value, const Range& range);
/// Paths of a scene are relative to `base` and stay below `root`; both canonical.
struct Folders {
  std::filesystem::path base, root;
};
/// The canonical path of the regular file that a text names.
std::filesystem::path file_of(const TomlValue& value, const Folders& folders);

using Pairs = std::vector<std::array<double, 2>>;
/// [[a, b], ...] with a strictly increasing; `form` says what a pair is: "[frame, activation]".
Pairs pairs_of(TomlValue& value, const std::string& form, const Key& key);
inline Pairs pairs_of(TomlValue& value, const Key& key) { return pairs_of(value, key.form, key); }

// Where the key is absent `out` keeps its default.
void read(TomlValue& table, const Key& key, double& out);
void read(TomlValue& table, const Key& key, int& out);
void read(TomlValue& table, const Key& key, bool& out);
void read(TomlValue& table, const Key& key, Vec3& out);
void read(TomlValue& table, const Key& key, std::string& out);  ///< one of its words
/// The word that is given, or the first of its words.
std::string read_word(TomlValue& table, const Key& key);

}  // namespace thew::sim
