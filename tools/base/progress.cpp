// SPDX-License-Identifier: Apache-2.0
#include "tools/base/progress.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "rig/text.h"
#include "tools/base/printing.h"

namespace thew::tools {
namespace {

constexpr int kBarWidth = 32;
constexpr int kPlainLines = 20;  // at most, for a whole job

std::string two_digits(long n) { return (n < 10 ? "0" : "") + std::to_string(n); }

}  // namespace

std::string duration(double seconds) {
  const long s = std::lround(std::max(seconds, 0.0));
  if (s >= 3600) return std::to_string(s / 3600) + " h " + two_digits(s / 60 % 60) + " min";
  if (s >= 60) return std::to_string(s / 60) + " min " + two_digits(s % 60) + " s";
  return std::to_string(s) + " s";
}

Progress::Progress(ProgressStyle style, const std::string& what, int total, std::FILE* out)
    : style_(style),
      what_(what),
      total_(std::max(total, 1)),
      out_(out),
      begin_(std::chrono::steady_clock::now()) {}

Progress::~Progress() {
  if (line_open_) std::fputc('\n', out_);
}

void Progress::step(int done, std::optional<int> frame) {
  if (style_ == ProgressStyle::kNone) return;
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
  if (first_done_ < 0) first_done_ = done - 1;
  const double left = seconds * (total_ - done) / std::max(done - first_done_, 1);
  const std::string named = frame ? "frame " + std::to_string(*frame) : "";
  if (style_ == ProgressStyle::kBar) {
    draw_bar(done, named, seconds, left);
  } else if (style_ == ProgressStyle::kJson) {
    nlohmann::ordered_json line = {{"progress", what_}};
    if (frame) line["frame"] = *frame;
    line.update({{"done", done}, {"total", total_}, {"seconds", seconds}, {"seconds_left", left}});
    std::fprintf(out_, "%s\n", line.dump().c_str());
  } else if (style_ == ProgressStyle::kOpenJd) {
    print("openjd_progress: " + number_text(100.0 * std::min(done, total_) / total_) +
          "\nopenjd_status: " + what_ + (frame ? " " + named : "") + ", " + duration(left) +
          " left\n");
  } else {
    const int twentieths = static_cast<int>(std::int64_t{kPlainLines} * done / total_);
    if (twentieths <= told_) return;
    told_ = twentieths;
    std::fprintf(out_, "%s: %s%d of %d, %s left\n", what_.c_str(),
                 frame ? (named + ", ").c_str() : "", done, total_, duration(left).c_str());
  }
  std::fflush(out_);
}

void Progress::draw_bar(int done, const std::string& frame, double seconds, double left) {
  const int full = static_cast<int>(std::int64_t{kBarWidth} * std::min(done, total_) / total_);
  std::string bar;
  for (int i = 0; i < kBarWidth; ++i) bar += i < full ? "█" : "░";
  const std::string time =
      done < total_ ? duration(left) + " left" : "done in " + duration(seconds);
  // Back to the line's start, and what a longer text left behind is wiped.
  std::fprintf(out_, "\r%s %s %d/%d  %s%s%s\x1b[K", what_.c_str(), bar.c_str(), done, total_,
               frame.c_str(), frame.empty() ? "" : "  ", time.c_str());
  line_open_ = true;
}

}  // namespace thew::tools
