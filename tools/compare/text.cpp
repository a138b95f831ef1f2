// SPDX-License-Identifier: Apache-2.0
#include "tools/base/text.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "tools/base/printing.h"
#include "tools/compare/compare.h"

namespace thew::tools {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMostLines = 10;  // of each kind

std::string more(std::size_t count, const std::string& what) {
  return count <= kMostLines
             ? ""
             : "  and " + std::to_string(count - kMostLines) + " more " + what + "\n";
}

std::string moved(const MeshDistance& mesh, const GeometryComparison& geometry) {
  const auto beyond = std::count_if(mesh.by_frame.begin(), mesh.by_frame.end(),
                                    [&](double distance) { return distance > geometry.tolerance; });
  return "  " + mesh.name + " moved " + readable(1e3 * mesh.largest) + " mm in frame " +
         std::to_string(mesh.frame) + " (vertex " + std::to_string(mesh.node) + "; RMS " +
         readable(1e3 * mesh.rms) + " mm; " + std::to_string(beyond) + " of " +
         std::to_string(geometry.frames.size()) + " frames)\n";
}

std::string geometry_as_text(const GeometryComparison& geometry) {
  if (geometry.same()) {
    const double most = geometry.meshes.empty() ? 0.0 : geometry.meshes.front().largest;
    const std::string frames = std::to_string(geometry.frames.size()) + " frames";
    if (geometry.exact) return "geometry: the same to the bit, " + frames + "\n";
    return "geometry: the same within " + readable(1e3 * geometry.tolerance) + " mm, " + frames +
           " (largest distance " + readable(1e3 * most) + " mm" +
           (geometry.rounded ? ", both rounded to float32" : "") + ")\n";
  }
  std::string text = "geometry differs";
  text += !geometry.of_bakes    ? "\n"
          : geometry.same_scene ? ", though scene and inputs are the same\n"
                                : "; scene or inputs differ as well\n";
  for (std::size_t i = 0; i < std::min(kMostLines, geometry.faults.size()); ++i) {
    text += "  " + geometry.faults[i] + "\n";
  }
  text += more(geometry.faults.size(), "of these");
  std::size_t count = 0;
  for (const MeshDistance& mesh : geometry.meshes) {
    if (mesh.largest <= geometry.tolerance) break;
    if (++count <= kMostLines) text += moved(mesh, geometry);
  }
  return text + more(count, "meshes that moved");
}

std::string shift_as_text(const PixelMeasures& m) {
  constexpr double kSeen = 0.02;  // pixels; less is what a limb that moves makes of it
  if (std::hypot(m.shift_x, m.shift_y) < kSeen) return "";
  const auto rounded = [](double pixels) { return readable(std::round(100.0 * pixels) / 100.0); };
  return ", as if shifted by (" + rounded(m.shift_x) + ", " + rounded(m.shift_y) + ") pixels";
}

std::string measures_as_text(const PixelMeasures& m) {
  return "largest difference " + std::to_string(m.largest) + " of 255 at (" + std::to_string(m.x) +
         ", " + std::to_string(m.y) + "), RMSE " + readable(m.rmse) + ", SSIM " +
         readable(m.ssim, 4) + ", FLIP " + readable(m.flip) + shift_as_text(m);
}

std::string images_as_text(const Comparison& comparison) {
  if (comparison.images.empty()) return "";
  const std::size_t count = comparison.images.size(), different = comparison.different_images();
  std::string text;
  if (different == 0) {
    const auto worst = std::max_element(
        comparison.images.begin(), comparison.images.end(),
        [](const auto& a, const auto& b) { return a.measures.flip < b.measures.flip; });
    text = "pictures: " + std::to_string(count) + (count == 1 ? ", " : ", all ") + "the same";
    text += worst->measures.flip > 0.0 ? " within the limits (" + worst->name + ": " +
                                             measures_as_text(worst->measures) + ")\n"
                                       : "\n";
    return text + renderer_note(comparison);
  }
  text = "pictures: " + std::to_string(different) + " of " + std::to_string(count) + " differ\n";
  std::vector<const ImageComparison*> worst;
  for (const ImageComparison& image : comparison.images) {
    if (!image.fault.empty()) worst.push_back(&image);
  }
  std::stable_sort(worst.begin(), worst.end(), [](const auto* a, const auto* b) {
    return a->measures.flip > b->measures.flip;
  });
  for (std::size_t i = 0; i < std::min(kMostLines, worst.size()); ++i) {
    text += "  " + worst[i]->name + ": " + worst[i]->fault;
    if (worst[i]->measures.largest > 0) text += "; " + measures_as_text(worst[i]->measures);
    text += "\n";
  }
  return text + more(different, "pictures") + renderer_note(comparison);
}

ordered_json geometry_as_json(const GeometryComparison& geometry) {
  ordered_json meshes = ordered_json::array();
  for (const MeshDistance& mesh : geometry.meshes) {
    meshes.push_back({{"name", mesh.name},
                      {"max_distance_mm", 1e3 * mesh.largest},
                      {"rms_distance_mm", 1e3 * mesh.rms},
                      {"frame", mesh.frame},
                      {"vertex", mesh.node},
                      {"distance_m", mesh.by_frame}});
  }
  return {{"same", geometry.same()},
          {"exact", geometry.exact},
          {"same_hash", geometry.same_hash},
          {"rounded_to_float32", geometry.rounded},
          {"same_scene", geometry.same_scene},
          {"tolerance_mm", 1e3 * geometry.tolerance},
          {"frames", geometry.frames},
          {"faults", geometry.faults},
          {"meshes", meshes}};
}

ordered_json image_as_json(const ImageComparison& image) {
  ordered_json out = {{"name", image.name},
                      {"same", image.fault.empty()},
                      {"fault", image.fault},
                      {"view", image.view},
                      {"frame", image.frame ? ordered_json(*image.frame) : ordered_json(nullptr)},
                      {"expected_renderer", image.expected_renderer},
                      {"actual_renderer", image.actual_renderer}};
  const PixelMeasures& m = image.measures;
  out["share"] = m.share;
  out["largest"] = m.largest;
  out["at"] = {m.x, m.y};
  out["rmse"] = m.rmse;
  out["ssim"] = m.ssim;
  out["flip"] = m.flip;
  out["shift"] = {m.shift_x, m.shift_y};
  return out;
}

}  // namespace

std::string renderer_note(const Comparison& comparison) {
  std::set<std::string> notes;
  const auto known = [](const std::string& name) { return name.empty() ? "unknown" : name; };
  for (const ImageComparison& image : comparison.images) {
    if (image.expected.empty() || image.actual.empty()) continue;
    if (image.expected_renderer == image.actual_renderer) continue;
    notes.insert("  renderers differ: expected " + known(image.expected_renderer) + "; actual " +
                 known(image.actual_renderer) + "\n");
  }
  std::string text;
  for (const std::string& note : notes) text += note;
  // What llvmpipe and softpipe make of the arm: 0.9 % of the pixels, 28 levels, FLIP 0.0008. A hand
  // that has moved by 0.8 mm is 1.8 %, 81 levels, 0.0016.
  const PixelLimits& limits = comparison.limits;
  const bool strict = limits.share < 0.012 && limits.largest < 40;
  if (!notes.empty() && strict && comparison.different_images() > 0) {
    text +=
        "  edges differ from renderer to renderer: --share 0.012 --largest 40 --flip 0.0012 lets "
        "that "
        "pass, and not a hand that has moved by a millimetre\n";
  }
  return text;
}

std::string comparison_as_text(const Comparison& comparison) {
  std::string text;
  if (comparison.geometry) text += geometry_as_text(*comparison.geometry);
  return text + images_as_text(comparison);
}

std::string comparison_as_json(const Comparison& comparison) {
  ordered_json images = ordered_json::array();
  for (const ImageComparison& image : comparison.images) images.push_back(image_as_json(image));
  const PixelLimits& limits = comparison.limits;
  ordered_json out = {
      {"same", comparison.same()},
      {"expected", comparison.expected.string()},
      {"actual", comparison.actual.string()},
      {"mask", comparison.mask.string()},
      {"limits",
       {{"threshold", limits.threshold}, {"share", limits.share}, {"largest", limits.largest}}},
      {"images", images}};
  const auto limit = [&](const char* name, const std::optional<double>& value) {
    if (value) out["limits"][name] = *value;
  };
  limit("rmse", limits.rmse);
  limit("ssim", limits.ssim);
  limit("flip", limits.flip);
  if (comparison.geometry) out["geometry"] = geometry_as_json(*comparison.geometry);
  return json_text(out, 2);
}

}  // namespace thew::tools
