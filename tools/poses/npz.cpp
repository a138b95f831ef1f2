// SPDX-License-Identifier: Apache-2.0
//
// Archives of numpy: a zip file (PKWARE's APPNOTE, entries stored as they are, dates 0) of .npy
// files (version 1.0).
#include <zlib.h>

#include <limits>

#include "tools/base/output_file.h"
#include "tools/poses/pose_set.h"

namespace thew::tools {
namespace {

using sim::NamedArray;

// A header of 64, 128, ... bytes, and the numbers.
std::string npy_of(const std::string& type, const std::string& shape, const std::string& numbers) {
  std::string about =
      "{'descr': '" + type + "', 'fortran_order': False, 'shape': (" + shape + "), }";
  constexpr std::size_t kBegin = 10, kAlign = 64;
  about.append((kAlign - (kBegin + about.size() + 1) % kAlign) % kAlign, ' ');
  about += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  put(bytes, static_cast<std::uint16_t>(about.size()));
  return bytes + about + numbers;
}

std::string npy_of(const NamedArray& array) {
  std::string shape, numbers;
  for (const std::size_t n : array.shape) shape += std::to_string(n) + ",";
  for (const double value : array.values) {
    switch (array.type) {
      case NamedArray::Type::kInt32:
        put(numbers, static_cast<std::int32_t>(value));
        break;
      case NamedArray::Type::kFloat32:
        put(numbers, static_cast<float>(value));
        break;
      default:
        put(numbers, value);
    }
  }
  const bool whole = array.type == NamedArray::Type::kInt32;
  const bool is_single = array.type == NamedArray::Type::kFloat32;
  return npy_of(whole ? "<i4" : is_single ? "<f4" : "<f8", shape, numbers);
}

std::string npy_of(const std::string& text) {
  return npy_of("|S" + std::to_string(text.size()), "", text);
}

class Zip {
 public:
  explicit Zip(const std::filesystem::path& file) : path_(file), file_(file) {}

  void add(const std::string& name, const std::string& bytes) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::uint32_t>::max();
    if (file_.size() + bytes.size() > kMost) {
      throw Error(ErrorCode::kUsage, path_.string() +
                                         ": more than 4 GiB do not fit into an .npz; write an .h5, "
                                         "or fewer poses");
    }
    const auto at = static_cast<std::uint32_t>(file_.size());
    const std::string about = entry(name, bytes);
    std::string head;
    put(head, std::uint32_t{0x04034b50});
    file_.append(head + about + name);
    file_.append(bytes);
    put(directory_, std::uint32_t{0x02014b50});
    put(directory_, std::uint16_t{20});  // the version that wrote it: 2.0
    directory_ += about;
    directory_.append(2 + 2 + 2 + 4, '\0');  // comment, disk, attributes
    put(directory_, at);
    directory_ += name;
    ++entries_;
  }

  void finish() {
    std::string end;
    put(end, std::uint32_t{0x06054b50});
    put(end, std::uint32_t{0});  // disks
    put(end, entries_);
    put(end, entries_);
    put(end, static_cast<std::uint32_t>(directory_.size()));
    put(end, static_cast<std::uint32_t>(file_.size()));
    put(end, std::uint16_t{0});  // comment
    file_.append(directory_ + end);
    file_.finish();
  }

 private:
  // What an entry's head and the directory have in common.
  static std::string entry(const std::string& name, const std::string& bytes) {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    const auto crc = static_cast<std::uint32_t>(
        crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
    std::string out;
    put(out, std::uint16_t{20});          // the version that reads it: 2.0
    put(out, std::uint32_t{0});           // flags; method: stored
    put(out, std::uint32_t{0x00210000});  // time and date: 1980-01-01
    put(out, crc);
    put(out, size);
    put(out, size);
    put(out, static_cast<std::uint16_t>(name.size()));
    put(out, std::uint16_t{0});
    return out;
  }

  std::filesystem::path path_;
  ExportFile file_;
  std::string directory_;
  std::uint16_t entries_ = 0;
};

}  // namespace

void write_npz(const PoseSet& set, const std::filesystem::path& file) {
  Zip zip(file);
  for (const auto& [name, text] : set.texts) zip.add(name + ".npy", npy_of(text));
  for (const NamedArray& array : set.arrays) zip.add(array.name + ".npy", npy_of(array));
  zip.finish();
}

}  // namespace thew::tools
