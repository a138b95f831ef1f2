// SPDX-License-Identifier: Apache-2.0
#include "tools/report/viewer.h"

#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>

#include "tools/base/bake_mesh.h"
#include "tools/base/html_page.h"
#include "tools/base/output_file.h"
#include "tools/base/svg_chart.h"

namespace thew::tools {

// viewer.html, and viewer.js, WebGL 2 and nothing else.
extern const char *const kViewerHtml, *const kViewerJs;

namespace {

constexpr std::size_t kMostBytes = std::size_t{64} << 20;  // of positions, before they are packed
constexpr double kSteps = 65535.0;

/// Positions as whole steps from a corner of the box of all frames.
struct Grid {
  Vec3 low = Vec3::Zero();
  double step = 1.0;  // m
};

// Only the skin's rest positions are sent: from them the viewer finds its stretch.
bool has_rest(const BakeMesh& mesh) { return mesh.kind == BakeMesh::Kind::kSkin; }

Grid grid_of(const BakeInfo& info, const std::vector<BakeFrame>& frames) {
  Eigen::AlignedBox3d box;
  for (const BakeMesh& mesh : info.meshes) {
    if (!has_rest(mesh)) continue;
    for (const Vec3& p : mesh.rest.vertices) box.extend(p);
  }
  for (const BakeFrame& frame : frames) {
    for (const auto& mesh : frame.positions) {
      for (const Vec3& p : mesh) box.extend(p);
    }
  }
  return {box.min(), std::max(box.sizes().maxCoeff(), 1e-9) / kSteps};
}

std::vector<int> shown_places(const BakeInfo& info) {
  std::size_t vertices = 0;
  for (const BakeMesh& mesh : info.meshes) vertices += mesh.rest.vertices.size();
  const std::size_t most =
      std::max<std::size_t>(1, kMostBytes / (6 * std::max<std::size_t>(vertices, 1)));
  const std::size_t step = (info.frames.size() + most - 1) / most;
  std::vector<int> places;
  for (std::size_t i = 0; i < info.frames.size(); i += step) places.push_back(static_cast<int>(i));
  return places;
}

// By frame and axis, the rest pose before all others where it is sent: the differences to the frame
// before, folded so that small ones of either sign are small numbers, all low bytes before all high
// bytes: this packs best.
void put_motion(std::string& bytes, const std::vector<const std::vector<Vec3>*>& frames,
                const Grid& grid) {
  const std::size_t count = frames.front()->size();
  std::vector<std::uint16_t> before(3 * count, 0);
  for (const std::vector<Vec3>* frame : frames) {
    for (int axis = 0; axis < 3; ++axis) {
      std::string low, high;
      for (std::size_t v = 0; v < count; ++v) {
        const double steps = ((*frame)[v][axis] - grid.low[axis]) / grid.step;
        const auto value = static_cast<std::uint16_t>(std::clamp(std::round(steps), 0.0, kSteps));
        std::uint16_t& last = before[static_cast<std::size_t>(axis) * count + v];
        const auto change = static_cast<std::int16_t>(value - last);
        const auto folded = static_cast<std::uint16_t>(change * 2 ^ (change < 0 ? -1 : 0));
        low += static_cast<char>(folded & 255);
        high += static_cast<char>(folded >> 8);
        last = value;
      }
      bytes += low + high;
    }
  }
}

std::string packed(const std::string& bytes) {
  constexpr int kLevel = 6;
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> deflate(
      libdeflate_alloc_compressor(kLevel), &libdeflate_free_compressor);
  if (!deflate) throw std::bad_alloc();
  std::string result(libdeflate_zlib_compress_bound(deflate.get(), bytes.size()), '\0');
  result.resize(libdeflate_zlib_compress(deflate.get(), bytes.data(), bytes.size(), result.data(),
                                         result.size()));
  return result;
}

std::vector<double> volume_errors(const BakeInfo& info, const std::vector<BakeFrame>& frames,
                                  const std::string& muscle) {
  const auto found = std::find(info.metric_names.begin(), info.metric_names.end(),
                               "volume_error_written/" + muscle);
  std::vector<double> errors;
  if (found == info.metric_names.end()) return errors;
  const auto metric = static_cast<std::size_t>(found - info.metric_names.begin());
  for (const BakeFrame& frame : frames) errors.push_back(frame.metrics[metric]);
  return errors;
}

// Text inside <script> must not end it.
std::string for_script(const nlohmann::json& json) {
  std::string text;
  for (const char c : json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    text += c == '<' ? std::string("\\u003c") : std::string(1, c);
  }
  return text;
}

}  // namespace

std::string report_viewer(const BakeReader& bake) {
  const BakeInfo& info = bake.info();
  std::vector<BakeFrame> frames;
  for (const int place : shown_places(info)) frames.push_back(bake.read(place));
  const Grid grid = grid_of(info, frames);
  nlohmann::json meshes = nlohmann::json::array();
  std::string bytes;
  std::size_t muscles = 0;
  for (std::size_t m = 0; m < info.meshes.size(); ++m) {
    const BakeMesh& mesh = info.meshes[m];
    const bool muscle = mesh.kind == BakeMesh::Kind::kMuscle;
    double heaviest = 2.0;  // end of the colour scale: twice even, or the largest
    for (const double weight : mesh.weights) heaviest = std::max(heaviest, weight);
    meshes.push_back({{"name", mesh.name},
                      {"kind", kind_name(mesh.kind)},
                      {"vertices", mesh.rest.vertices.size()},
                      {"triangles", mesh.rest.triangles.size()},
                      {"weighted", !mesh.weights.empty()},
                      {"rest", has_rest(mesh)},
                      {"colour", muscle ? chart_colour(muscles++) : ""},
                      {"errors", volume_errors(info, frames, mesh.name)}});
    for (const Triangle& triangle : shaded_triangles(mesh)) {
      for (const int vertex : triangle) put(bytes, static_cast<std::uint32_t>(vertex));
    }
    for (const double weight : mesh.weights) {
      bytes += static_cast<char>(std::lround(255.0 * std::max(weight, 0.0) / heaviest));
    }
    std::vector<const std::vector<Vec3>*> motion;
    if (has_rest(mesh)) motion.push_back(&mesh.rest.vertices);
    for (const BakeFrame& frame : frames) motion.push_back(&frame.positions[m]);
    put_motion(bytes, motion, grid);
  }
  std::vector<int> numbers;
  for (const BakeFrame& frame : frames) numbers.push_back(frame.frame);
  const double off = std::sqrt(3.0) * 0.5 * grid.step;
  const nlohmann::json head = {{"fps", info.fps},
                               {"frames", numbers},
                               {"low", {grid.low.x(), grid.low.y(), grid.low.z()}},
                               {"step", grid.step},
                               {"meshes", meshes}};
  std::string note = "Positions are rounded to within " + readable(1e6 * off) + " µm for this view";
  if (frames.size() < info.frames.size()) {
    note += ", and " + std::to_string(frames.size()) + " of " + std::to_string(info.frames.size()) +
            " frames are shown";
  }
  return std::string(kViewerHtml) + "<p class=\"soft\">" + note +
         ". Drag to turn, shift and drag to shift, wheel or two fingers to come nearer, double "
         "click to go back. A click in a chart or on a thumbnail shows that frame.</p>\n" +
         "<script type=\"application/json\" id=\"viewer-head\">" + for_script(head) +
         "</script>\n<script type=\"text/plain\" id=\"viewer-data\">" + base64(packed(bytes)) +
         "</script>\n<script>" + kViewerJs + "</script>\n";
}

}  // namespace thew::tools
