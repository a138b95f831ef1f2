// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::sim {

/// The one place of the version; CMake reads it here.
inline constexpr char kVersion[] = "0.1.0";

}  // namespace thew::sim
