// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

namespace thew::rig {

/// The value as a whole number within +-2^53, or nothing. The conversion of the JSON library
/// accepts every number, and its result is undefined for one that does not fit an integer.
inline std::optional<std::int64_t> whole_number(const nlohmann::json& value) {
  constexpr std::int64_t kMost = std::int64_t{1} << 53;
  if (!value.is_number_integer()) return {};
  if (value.is_number_unsigned() && value.get<std::uint64_t>() > kMost) return {};
  const auto number = value.get<std::int64_t>();
  return number < -kMost ? std::nullopt : std::optional(number);
}

}  // namespace thew::rig
