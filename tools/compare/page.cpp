// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <map>

#include "sim/cache/durable_file.h"
#include "sim/cache/version.h"
#include "tools/base/html_page.h"
#include "tools/base/svg_chart.h"
#include "tools/compare/compare.h"
#include "tools/compare/flip.h"

namespace thew::tools {

// compare.css, compare.js
extern const char *const kCompareCss, *const kCompareJs;

namespace {

constexpr std::size_t kLargestPicture = std::size_t{1} << 26;  // bytes
constexpr std::size_t kShown = 12;                             // pictures, so that a browser copes
constexpr std::size_t kLines = 12;                             // of a chart that can be told apart

// An <img> whose class and text for those who do not see it are `name`.
std::string embedded(const std::string& png, const std::string& name) {
  return html_png("class=\"" + name + "\" alt=\"" + name + "\"", png);
}

std::string difference(const ImageComparison& image, const Image* mask) {
  const Image a = read_png(image.expected), b = read_png(image.actual);
  if (a.width != b.width || a.height != b.height) return "";
  const Image heat = heat_map(flip(a, masked(a, b, mask)));
  return html_figure(embedded(encode_png(heat), "difference"),
                     "Difference: FLIP's error, black where both look the same") +
         html_figure(
             "<div class=\"stage\"><img alt=\"expected\"><img alt=\"actual\"></div>\n<input "
             "type=\"range\" min=\"0\" max=\"100\" step=\"0.1\" value=\"50\" aria-label=\"where "
             "expected ends and actual begins\">\n",
             "Expected to the left of the line, actual to the right");
}

std::string pair(const ImageComparison& image, const Image* mask) {
  std::string html = "<h2>" + escape_html(image.name) + "</h2>\n<p>" + escape_html(image.fault) +
                     "</p>\n<div class=\"pair\">\n";
  const auto side = [&](const std::filesystem::path& file, const std::string& name,
                        const std::string& renderer) {
    if (file.empty()) return;
    html += html_figure(embedded(read_whole_file(file, kLargestPicture), name),
                        (name == "expected" ? "Expected" : "Actual") +
                            (renderer.empty() ? "" : ", drawn by " + escape_html(renderer)));
  };
  side(image.expected, "expected", image.expected_renderer);
  side(image.actual, "actual", image.actual_renderer);
  if (!image.expected.empty() && !image.actual.empty()) html += difference(image, mask);
  return html + "</div>\n";
}

std::string pairs(const Comparison& comparison) {
  std::vector<const ImageComparison*> worst;
  for (const ImageComparison& image : comparison.images) worst.push_back(&image);
  std::stable_sort(worst.begin(), worst.end(), [](const auto* a, const auto* b) {
    const auto rank = [](const auto* image) {
      return std::make_pair(image->fault.empty(), -image->measures.flip);
    };
    return rank(a) < rank(b);
  });
  // Those within the limits are shown where nothing is beyond them: the first is the nearest to it.
  const std::size_t different = comparison.different_images();
  worst.resize(std::min({worst.size(), kShown, std::max<std::size_t>(1, different)}));
  std::optional<Image> mask;
  if (!comparison.mask.empty()) mask = read_png(comparison.mask);
  std::string html;
  for (const ImageComparison* image : worst) html += pair(*image, mask ? &*mask : nullptr);
  if (different > worst.size()) {
    html += "<p class=\"soft\">The " + std::to_string(kShown) + " worst of " +
            std::to_string(different) + " pictures that differ are shown.</p>\n";
  }
  return html;
}

std::string geometry_chart(const GeometryComparison& geometry) {
  LineChart chart{"Distance", "mm", geometry.frames, {}, true, 1e3 * geometry.tolerance};
  for (const MeshDistance& mesh : geometry.meshes) {
    if (chart.lines.size() == kLines || mesh.largest == 0.0) break;
    ChartLine line{mesh.name, mesh.by_frame};
    for (double& value : line.values) value *= 1e3;
    chart.lines.push_back(line);
  }
  if (chart.lines.empty()) return "";
  return html_figure(draw_chart(chart),
                     "Of each mesh the node that is farthest from where it was "
                     "expected, by frame; logarithmic, 0 on the floor.");
}

// One curve a view, over the frames of which each view has both pictures.
std::string pixel_chart(const Comparison& comparison, const std::string& title,
                        const std::string& unit, const std::string& caption,
                        double (*value)(const PixelMeasures&)) {
  std::map<std::string, std::map<int, double>> views;
  for (const ImageComparison& image : comparison.images) {
    if (!image.frame || image.expected.empty() || image.actual.empty()) continue;
    views[image.view][*image.frame] = value(image.measures);
  }
  if (views.empty() || views.begin()->second.size() < 2) return "";  // no curve
  LineChart chart{title, unit, {}, {}, false, {}};
  for (const auto& [frame, unused] : views.begin()->second) chart.x.push_back(frame);
  for (const auto& [view, by_frame] : views) {
    ChartLine line{view, {}};
    for (const int frame : chart.x) {
      if (by_frame.contains(frame)) line.values.push_back(by_frame.at(frame));
    }
    if (line.values.size() == chart.x.size()) chart.lines.push_back(line);
  }
  return html_figure(draw_chart(chart), caption);
}

std::string charts(const Comparison& comparison) {
  std::string html;
  if (comparison.geometry) html += geometry_chart(*comparison.geometry);
  html += pixel_chart(comparison, "FLIP", "0 the same, 1 as different as can be",
                      "Mean perceived difference of each picture.",
                      [](const PixelMeasures& m) { return m.flip; });
  html += pixel_chart(comparison, "Changed pixels", "%",
                      "Pixels that differ by more than the threshold.",
                      [](const PixelMeasures& m) { return 100.0 * m.share; });
  return html.empty() ? ""
                      : "<h2>Frame by frame</h2>\n<div class=\"charts\">\n" + html + "</div>\n";
}

}  // namespace

std::string comparison_as_html(const Comparison& comparison) {
  const std::string verdict = comparison.same() ? "The same" : "Different";
  return html_page(verdict + " – comparison", kCompareCss,
                   "<h1>" + verdict + "</h1>\n<p class=\"soft\">Expected <code>" +
                       escape_html(comparison.expected.string()) + "</code>, actual <code>" +
                       escape_html(comparison.actual.string()) + "</code></p>\n<pre class=\"" +
                       (comparison.same() ? "good" : "bad") + "\">" +
                       escape_html(comparison_as_text(comparison)) + "</pre>\n" +
                       charts(comparison) + pairs(comparison) + "<footer>Thew " + kVersion +
                       ". The same numbers for programs: thew compare --json.</footer>\n",
                   kCompareJs);
}

}  // namespace thew::tools
