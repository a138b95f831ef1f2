// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace thew::tools {

/// 8-bit RGB, rows from the top.
struct Image {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  std::string renderer = {};  ///< name and version of what drew it; "" where that is not known
};

inline constexpr int kFastPng = 1;

/// `level`: zlib's. The renderer is kept as a tEXt chunk, "Renderer".
std::string png_bytes(const Image& image, int level);
/// That by write_durably, listed as `of`; Error(kOutput) on failure.
void write_png(const std::filesystem::path& file, const Image& image, int level = kFastPng,
               const std::string& of = {});
/// Smaller and slower, for pages, without the renderer.
std::string encode_png(const Image& image);
/// Any PNG up to 16384 x 16384, alpha over black; Error(kInput) on failure.
Image read_png(const std::filesystem::path& file);

}  // namespace thew::tools
