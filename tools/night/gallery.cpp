// SPDX-License-Identifier: Apache-2.0
//
// Pictures of frames, small and part of the page.
#include <algorithm>
#include <optional>

#include "sim/cache/file_io.h"
#include "tools/base/html_page.h"
#include "tools/base/text.h"
#include "tools/night/night.h"
#include "tools/render/contact_sheet.h"
#include "tools/render/frame_file.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kWidth = 320;  // pixels

// The view that shows a part best, of those whose names say what they show; else the first.
std::string view_of(const std::vector<std::string>& views, const std::string& part) {
  const std::string word = part == "skin" ? "skin" : "muscle";
  const auto found = std::find_if(views.begin(), views.end(), [&](const std::string& view) {
    return view.find(word) != std::string::npos;
  });
  return found == views.end() ? views.front() : *found;
}

// Of the frame or, where a bake has failed in it, the last one before; nothing where none is there.
std::optional<FrameName> picture_of(const WorstFrame& worst, const fs::path& folder) {
  std::error_code error;
  if (!fs::is_directory(folder, error)) return {};
  std::vector<FrameName> all;
  for (const fs::path& file : sim::paths_in(folder)) {
    if (auto name = read_frame_name(file.filename().string())) all.push_back(std::move(*name));
  }
  int last = 0;
  bool any = false;
  for (const FrameName& name : all) {
    const bool fits =
        worst.shot->failed_frame != 0 ? name.frame <= worst.frame : name.frame == worst.frame;
    if (fits && (!any || name.frame > last)) last = name.frame, any = true;
  }
  if (!any) return {};
  std::vector<std::string> views;
  for (const FrameName& name : all) {
    if (name.frame == last) views.push_back(name.view);
  }
  std::sort(views.begin(), views.end());
  return FrameName{view_of(views, worst.part), last};
}

}  // namespace

std::string thumbnail(const WorstFrame& worst) {
  const fs::path folder = worst.shot->folder / "frames";
  try {
    const auto name = picture_of(worst, folder);
    if (!name) return "";
    const Image image = read_png(frame_file(folder, name->view, name->frame));
    if (image.width < 1) return "";
    const Image small = shrink(image, kWidth, std::max(1, image.height * kWidth / image.width));
    return html_png("alt=\"" + escape_html(name->view) + ", frame " + std::to_string(name->frame) +
                        "\" width=\"" + std::to_string(small.width) + "\" height=\"" +
                        std::to_string(small.height) + "\"",
                    encode_png(small));
  } catch (const Error&) {  // a picture that cannot be read is none
    return "";
  }
}

}  // namespace thew::tools
