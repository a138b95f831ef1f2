// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

namespace thew::rig {

/// A whole number of a foreign file, of at most 2^53; nothing for all else. The library's own
/// conversion takes every number, and for one that no integer holds it is undefined.
inline std::optional<std::int64_t> whole_number(const nlohmann::json& value) {
  constexpr std::int64_t kMost = std::int64_t{1} << 53;
  if (!value.is_number_integer()) return {};
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > kMost) return {};
  const auto number = value.get<std::int64_t>();
  return number < -kMost ? std::nullopt : std::optional(number);
}

}  // namespace thew::rig
