// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <span>
#include <string>
#include <string_view>

#include "rig/limits.h"

namespace thew::sim {

// The keys of a scene are declared once: the reader checks by the declaration, and the reference
// (reference.h) is written from it.

/// What a number may be; `above` leaves out `least` itself.
struct Range {
  double least = -1e12, most = 1e12;
  bool above = false;
};
/// 1e12 is more than any quantity of a body has in SI units, and its square is far from overflow.
inline constexpr Range kPositive{1e-12, 1e12}, kNotNegative{0.0, 1e12}, kShare{0.0, 1.0};
/// m: where a point is; a length; one that has to be longer than what float32 rounds off.
inline constexpr Range kPlace{-kMaxCoordinate, kMaxCoordinate}, kLength{0.0, kMaxCoordinate},
    kSize{1e-6, kMaxCoordinate};
inline constexpr Range kScale{kMinScale, kMaxScale};
/// What a direction is given by; it is made unit.
inline constexpr Range kDirection{-1e6, 1e6};
inline constexpr int kLastFrame = 1000000;
inline constexpr Range kFrames{-kLastFrame, kLastFrame};
/// Degrees: once round, either way.
inline constexpr Range kTurn{-360.0, 360.0};

enum class KeyType {
  kNumber,
  kInteger,
  kLength,  ///< a number in m, or a text with its unit
  kTruth,
  kText,
  kName,  ///< a text that files may be called by
  kWord,  ///< one of `words`
  kFile,
  kVector,
  kDirection,  ///< a vector that is not zero
  kPairs,      ///< of numbers; `form` says what a pair is
  kForm,       ///< what `form` says
  kTable,
  kTables
};

/// Whether a table has to have a key; kConditional: in some cases, which the meaning tells.
enum class Need { kOptional, kRequired, kConditional };

struct Key {
  const char* name;
  KeyType type;
  const char* meaning;  ///< a sentence
  const char* unit = "";
  Need need = Need::kOptional;
  /// The value that holds where the key is left out; null: the first of `words`, or none.
  std::string (*standard)() = nullptr;
  Range range = {0.0, 0.0};   ///< of each number of the value; 0 to 0: it has none
  Range second = {0.0, 0.0};  ///< of the last number of a pair or a plane
  std::array<const char*, 8> words = {};
  /// What the value looks like: "[u, weight]". Messages say it as well.
  const char* form = "";
  const char* old = "";  ///< what the key was called before; still read, with a warning
};

/// The keys of one table of a scene.
struct Section {
  const char* path;   ///< "muscle.material": the keys that lead there, without indices
  const char* title;  ///< as TOML writes it
  const char* about;
  std::span<const Key> keys;

  /// A name that is not declared does not compile.
  consteval const Key& operator[](std::string_view name) const {
    for (const Key& key : keys) {
      if (key.name == name) return key;
    }
    throw "no such key";
  }
};

// A value as TOML writes it.
std::string toml_text(double value);
std::string toml_text(int value);
std::string toml_text(bool value);
std::string toml_text(const std::string& value);
std::string toml_text(const Vec3& value);
/// "0.002 × size": of a length that is multiplied by [scene] size where it is not given.
std::string sized_text(double value);

template <typename Struct, typename Value>
std::string default_text(Value Struct::*member) {
  const Struct fresh{};
  if constexpr (requires { times(fresh, 2.0); }) {
    if (times(fresh, 2.0).*member != fresh.*member) return sized_text(fresh.*member);
  }
  return toml_text(fresh.*member);
}
/// What a member of a struct is unless it is set: .standard = default_of<&World::fps>.
template <auto kMember>
std::string default_of() {
  return default_text(kMember);
}

}  // namespace thew::sim
