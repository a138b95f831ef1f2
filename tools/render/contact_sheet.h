// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/render/image.h"

namespace thew::tools {

/// Indices 0..count-1, at most `wanted` of them, evenly spread with the first and the last.
std::vector<int> spread_indices(int count, int wanted);

/// A number, dark on white, with its upper left corner at x, y; `dot_size` in pixels, of the dots
/// of its characters.
void write_text(const std::string& text, int x, int y, int dot_size, Image& image);

/// The mean of the pixels (areas) that fall on each smaller pixel; never enlarges.
Image shrink(const Image& image, int width, int height);

/// A grid of thumbnails, row by row, on white; all images of the first one's proportions.
/// `numbers`, where given, stand in their corners.
Image contact_sheet(const std::vector<Image>& images, int columns, int thumbnail_width,
                    const std::vector<int>& numbers = {});

}  // namespace thew::tools
