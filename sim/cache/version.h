// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace thew::sim {

/// The version of Thew. CMake reads it from here.
inline constexpr char kVersion[] = "0.1.0";

/// Of the layout of bake.h5.
inline constexpr int kCacheVersion = 1;

}  // namespace thew::sim
