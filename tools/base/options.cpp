// SPDX-License-Identifier: Apache-2.0
#include "tools/base/options.h"

#include <dlfcn.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <set>
#include <string_view>

#include "rig/skeleton.h"
#include "rig/types.h"

namespace thew::tools {
namespace {

constexpr long kMostFrames = 1'000'000;

[[noreturn]] void refuse(const std::string& text, const std::string& what) {
  throw Error(ErrorCode::kUsage, "--frames " + text + ": " + what);
}

/// Takes a whole number off the front; false where there is none.
bool take_number(std::string_view& rest, int& value) {
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc()) return false;
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return true;
}

bool take(std::string_view& rest, std::string_view any_of) {
  if (rest.empty() || any_of.find(rest.front()) == std::string_view::npos) return false;
  rest.remove_prefix(1);
  return true;
}

// ITEM = FRAME [ "-" FRAME [ ("x" | ":") STEP ] ]
void add_item(const std::string& text, std::string_view item, std::set<int>& frames) {
  std::string_view rest = item;
  int first = 0, step = 1;
  bool good = take_number(rest, first);
  int last = first;
  if (good && take(rest, "-")) {
    good = take_number(rest, last);
    if (good && take(rest, "x:")) good = take_number(rest, step);
  }
  if (!good || !rest.empty()) {
    refuse(text, "\"" + std::string(item) +
                     "\" is not a frame or a range; write for instance 1-120, 1-120x2 or 1,5,9-12");
  }
  if (step < 1) refuse(text, "the step has to be 1 or more");
  if (last < first) {
    refuse(text, "the range ends before it begins; write " + std::to_string(last) + "-" +
                     std::to_string(first));
  }
  if ((long{last} - first) / step >= kMostFrames) refuse(text, "more than a million frames");
  for (long frame = first; frame <= last; frame += step) frames.insert(static_cast<int>(frame));
}

}  // namespace

std::vector<int> parse_frames(const std::string& text) {
  std::set<int> frames;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    std::string_view item = rest.substr(0, comma);
    while (take(item, " ")) {
    }
    while (!item.empty() && item.back() == ' ') item.remove_suffix(1);
    add_item(text, item, frames);
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 1);
  }
  return {frames.begin(), frames.end()};
}

std::vector<int> parse_frames(const std::string& text, int first, int last) {
  std::vector<int> frames = parse_frames(text);
  for (const int frame : {frames.front(), frames.back()}) {
    if (frame >= first && frame <= last) continue;
    refuse(text, "frame " + std::to_string(frame) + " is outside the scene's frames " +
                     std::to_string(first) + "-" + std::to_string(last) +
                     "; choose among these or extend the scene");
  }
  return frames;
}

ProgressStyle parse_progress(const std::string& word, bool on_terminal) {
  if (word == "auto") return on_terminal ? ProgressStyle::kBar : ProgressStyle::kPlain;
  if (word == "bar") return ProgressStyle::kBar;
  if (word == "plain") return ProgressStyle::kPlain;
  if (word == "json") return ProgressStyle::kJson;
  if (word == "openjd") return ProgressStyle::kOpenJd;
  if (word == "none") return ProgressStyle::kNone;
  const std::string near = nearest_name(word, {"auto", "bar", "plain", "json", "openjd", "none"});
  throw Error(ErrorCode::kUsage, "--progress " + word + ": " +
                                     (near.empty() ? "" : "did you mean " + near + "? ") +
                                     "choose auto, bar, plain, json, openjd or none");
}

std::string command_text(int argc, const char* const* argv) {
  std::string text;
  for (int i = 0; i < argc; ++i) {
    const std::string word = argv[i];
    const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
      return std::isalnum(c) || c >= 0x80 || std::strchr("_-+./,:=@%", c);
    });
    std::string quoted = "'";
    for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
    text += (i > 0 ? " " : "") + (plain ? word : quoted + "'");
  }
  return text;
}

std::string command_text(const std::vector<std::string>& words) {
  std::vector<const char*> pointers;
  for (const std::string& word : words) pointers.push_back(word.c_str());
  return command_text(static_cast<int>(pointers.size()), pointers.data());
}

std::filesystem::path own_asset(const std::string& name) {
  namespace fs = std::filesystem;
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  const fs::path installed = program.parent_path() / ".." / THEW_SHARE / name;
  // Where this is a module of Python: PREFIX/lib/python3.11/dist-packages/thew/_thew.so.
  Dl_info module{};
  ::dladdr(reinterpret_cast<const void*>(&own_asset), &module);
  const fs::path beside_module = fs::path(module.dli_fname ? module.dli_fname : "").parent_path() /
                                 "../../../.." / THEW_SHARE / name;
  for (const fs::path& path : {installed, beside_module, fs::path(THEW_ASSETS) / name}) {
    if (fs::exists(path, error)) return fs::canonical(path);
  }
  throw Error(ErrorCode::kInput,
              installed.string() + ": is not there; install Thew with its folder share");
}

}  // namespace thew::tools
