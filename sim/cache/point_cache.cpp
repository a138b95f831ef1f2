// SPDX-License-Identifier: Apache-2.0
//
// The formats are described in tools/export/point_cache.cpp, which writes them.
#include "sim/cache/point_cache.h"

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "rig/limits.h"
#include "rig/text.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

std::string lower_ending(const fs::path& file) {
  std::string ending = file.extension().string();
  for (char& c : ending) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + 'a' - 'A') : c;
  return ending;
}

constexpr std::size_t kMostBytes = std::size_t{1} << 29;
constexpr double kMaxSeconds = 1e9;

// A file's numbers one after another, of either byte order.
class Numbers {
 public:
  Numbers(const fs::path& file, bool big)
      : file_(file), big_(big), bytes_(read_whole(file, kMostBytes)) {}

  template <typename T>
  T next() {
    std::array<char, sizeof(T)> bytes{};
    if (left() < sizeof(T)) refuse("its header is cut short");
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at_), sizeof(T), bytes.begin());
    at_ += sizeof(T);
    if (big_) std::reverse(bytes.begin(), bytes.end());
    T value;
    std::memcpy(&value, bytes.data(), sizeof value);
    return value;
  }
  bool skip(const std::string& word) {
    const bool same = bytes_.compare(at_, word.size(), word) == 0;
    at_ += same ? word.size() : 0;
    return same;
  }
  std::size_t left() const { return bytes_.size() - at_; }
  [[noreturn]] void refuse(const std::string& what) const {
    throw Error(ErrorCode::kInput, file_.string() + ": " + what + "; export it again");
  }

 private:
  const fs::path& file_;
  bool big_;
  std::string bytes_;
  std::size_t at_ = 0;
};

struct Header {
  std::int32_t samples = 0, points = 0;
};

void check(const Numbers& in, const Header& header, std::size_t points, std::size_t of_times) {
  if (header.samples <= 0) in.refuse("has " + std::to_string(header.samples) + " samples");
  if (header.points < 0 || static_cast<std::size_t>(header.points) != points) {
    in.refuse("has " + std::to_string(header.points) + " points, and its mesh " +
              std::to_string(points) + " vertices");
  }
  const std::size_t sample = points * 3 * sizeof(float),
                    wanted = of_times + static_cast<std::size_t>(header.samples) * sample;
  if (in.left() == wanted) return;
  in.refuse("has " + std::to_string(in.left()) + " bytes after its header in place of " +
            std::to_string(wanted) + " for " + std::to_string(header.samples) + " samples");
}

void read_positions(Numbers& in, const Header& header, MeshSamples& out) {
  for (std::int32_t k = 0; k < header.samples; ++k) {
    std::vector<Vec3>& positions = out.positions.emplace_back();
    positions.reserve(static_cast<std::size_t>(header.points));
    for (std::int32_t i = 0; i < header.points; ++i) {
      Vec3 p;
      for (double& value : p) value = in.next<float>();
      if (!is_bounded(p, kMaxCoordinate / kMinScale)) {
        in.refuse("sample " + std::to_string(k) + ", point " + std::to_string(i) + " lies at " +
                  point_text(p) + ", which is no place");
      }
      positions.push_back(p);
    }
  }
}

MeshSamples read_pc2(const fs::path& file, std::size_t points, double fps) {
  Numbers in(file, false);
  MeshSamples out;
  Header header;
  if (!in.skip(std::string("POINTCACHE2\0", 12))) in.refuse("is no PC2");
  if (const auto version = in.next<std::int32_t>(); version != 1) {
    in.refuse("is a PC2 of version " + std::to_string(version) + ", and not of 1");
  }
  header.points = in.next<std::int32_t>();
  in.next<float>();  // the first frame, which the scene says
  const double step = in.next<float>();
  header.samples = in.next<std::int32_t>();
  check(in, header, points, 0);
  if (!(step > 0.0 && step <= kMaxSeconds)) {
    in.refuse("its samples are " + number_text(step) + " frames apart");
  }
  for (std::int32_t k = 0; k < header.samples; ++k) out.times.push_back(k * step / fps);
  read_positions(in, header, out);
  return out;
}

MeshSamples read_mdd(const fs::path& file, std::size_t points) {
  Numbers in(file, true);
  MeshSamples out;
  Header header;
  header.samples = in.next<std::int32_t>();
  header.points = in.next<std::int32_t>();
  check(in, header, points, sizeof(float) * static_cast<std::size_t>(std::max(header.samples, 0)));
  double first = 0.0;
  for (std::int32_t k = 0; k < header.samples; ++k) {
    const double time = in.next<float>();
    if (k == 0) first = time;
    if (!(std::abs(time) <= kMaxSeconds) || (k > 0 && !(time - first > out.times.back()))) {
      in.refuse("sample " + std::to_string(k) + " is at " + number_text(time) +
                " s, which is not after the one before");
    }
    out.times.push_back(time - first);
  }
  read_positions(in, header, out);
  return out;
}

}  // namespace

bool names_point_cache(const fs::path& file) {
  const std::string ending = lower_ending(file);
  return ending == ".pc2" || ending == ".mdd";
}

MeshSamples read_point_cache(const fs::path& file, std::size_t points, double fps) {
  if (lower_ending(file) == ".mdd") return read_mdd(file, points);
  return read_pc2(file, points, fps);
}

}  // namespace thew::sim
