// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"
#include "sim/cache/durable_file.h"

namespace thew::tools {

/// A file written piece by piece beside its place and by finish() listed as ours and renamed;
/// without finish() nothing is left of it. Error(kOutput).
class ExportFile {
 public:
  /// Creates the folder where it is missing.
  explicit ExportFile(const std::filesystem::path& file);
  ~ExportFile();
  ExportFile(const ExportFile&) = delete;
  ExportFile& operator=(const ExportFile&) = delete;

  void append(std::string_view bytes);
  /// Over bytes that were appended before.
  void patch(std::uint64_t at, std::string_view bytes);
  /// All that was written from there on, in pieces.
  void read_back(std::uint64_t from, const std::function<void(std::string_view)>& take);
  std::uint64_t size() const { return size_; }
  void finish();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path file_;
  Temporary temporary_;
  std::FILE* out_ = nullptr;
  std::uint64_t size_ = 0;
};

/// The files of one export, in order. Without keep() they are removed again: half a sequence is
/// none.
class WrittenFiles {
 public:
  WrittenFiles() = default;
  ~WrittenFiles();
  WrittenFiles(const WrittenFiles&) = delete;
  WrittenFiles& operator=(const WrittenFiles&) = delete;

  void add(const std::filesystem::path& file);
  std::vector<std::filesystem::path> keep();

 private:
  struct Written {
    std::filesystem::path file;
    std::uint64_t number;  ///< the file system's: another process may write the same names
  };
  std::vector<Written> files_;
};

/// The memory of a number, lowest byte first (Debian's processors all have it so).
template <typename T>
void put(std::string& bytes, T value) {
  char memory[sizeof value];
  std::memcpy(memory, &value, sizeof value);
  bytes.append(memory, sizeof value);
}
/// x, y, z as float32.
void put_floats(std::string& bytes, const Vec3& value);

/// The fewest digits that read back as the same number, in any locale.
std::string digits(float value);
std::string digits(double value);
/// "x y z"
template <typename T>
std::string digits(const Vec3& value, const char* between = " ") {
  return digits(static_cast<T>(value.x())) + between + digits(static_cast<T>(value.y())) + between +
         digits(static_cast<T>(value.z()));
}

}  // namespace thew::tools
