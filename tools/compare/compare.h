// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "tools/base/progress.h"
#include "tools/compare/geometry.h"
#include "tools/compare/image_metrics.h"

namespace thew::tools {

struct CompareOptions {
  double distance = kDistanceTolerance;  ///< m, that a node may move
  PixelLimits limits;
  std::filesystem::path mask;  ///< a PNG for all pictures; empty: none
  std::vector<int> frames;     ///< empty: all
  int threads = 1;
  ProgressStyle progress = ProgressStyle::kNone;  ///< of pictures, where there are several
};

/// One picture of both sides.
struct ImageComparison {
  std::string name;                        ///< of the file in both folders
  std::string view;                        ///< what comes before the frame's number
  std::optional<int> frame;                ///< from the name, VIEW.####.png
  std::filesystem::path expected, actual;  ///< empty: missing
  std::string fault;                       ///< why it differs; "" where it does not
  std::string expected_renderer, actual_renderer;
  PixelMeasures measures;  ///< where both are there and of one size
};

struct Comparison {
  std::filesystem::path expected, actual, mask;
  std::optional<GeometryComparison> geometry;
  PixelLimits limits;
  std::vector<ImageComparison> images;

  int different_images() const;
  bool same() const { return (!geometry || geometry->same()) && different_images() == 0; }
};

/// Two bakes (bake.h5), two characters' exports (glTF), two PNGs, or two folders with bakes or PNGs
/// or both; geometry first. Error(kInput)
/// for what cannot be read, Error(kUsage) for what cannot be compared with one another.
Comparison compare(const std::filesystem::path& expected, const std::filesystem::path& actual,
                   const CompareOptions& options);

/// What differs, for people: the worst first, ten lines of each kind.
std::string comparison_as_text(const Comparison& comparison);
/// All of it, for programs.
std::string comparison_as_json(const Comparison& comparison);
/// One file that needs no other: curves by frame, and of the pictures that differ most expected,
/// actual, difference and a slider between them.
std::string comparison_as_html(const Comparison& comparison);

/// Renderers of pictures that were not drawn by the same; empty where all were.
std::string renderer_note(const Comparison& comparison);

}  // namespace thew::tools
