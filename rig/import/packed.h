// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace thew::rig {

// Packs numbers, lists and texts into one string of bytes and unpacks them again. One function
// `walk(archive, value)` visits the fields for both, so that they cannot differ. Private to the
// libraries.

struct Packer {
  std::string bytes;

  template <typename T>
  void number(const T& value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  /// A text or a list of numbers.
  template <typename List>
  void list(const List& values) {
    number(std::uint64_t{values.size()});
    bytes.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof values[0]);
  }
  template <typename T, typename Walk>
  void each(std::vector<T>& values, Walk walk) {
    number(std::uint64_t{values.size()});
    for (T& value : values) walk(*this, value);
  }
};

/// `good` becomes false at the first value for which too few bytes are left. Every length is
/// compared with the remaining bytes before memory is allocated for it.
struct Unpacker {
  std::string_view remaining;
  bool good = true;

  template <typename T>
  void number(T& value) {
    take(&value, sizeof value);
  }
  template <typename List>
  void list(List& values) {
    const std::uint64_t count = take_count(sizeof values[0]);
    values.resize(count);
    take(values.data(), count * sizeof values[0]);
  }
  template <typename T, typename Walk>
  void each(std::vector<T>& values, Walk walk) {
    values.resize(take_count(sizeof(std::uint64_t)));  // each item has a length of its own at least
    for (T& value : values) walk(*this, value);
  }
  bool finished() const { return good && remaining.empty(); }

 private:
  void take(void* to, std::size_t bytes) {
    good = good && bytes <= remaining.size();
    if (!good || bytes == 0) return;
    std::memcpy(to, remaining.data(), bytes);
    remaining.remove_prefix(bytes);
  }
  std::uint64_t take_count(std::size_t smallest) {
    std::uint64_t count = 0;
    number(count);
    good = good && count <= remaining.size() / smallest;
    return good ? count : 0;
  }
};

}  // namespace thew::rig
