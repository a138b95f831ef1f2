// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "rig/types.h"

namespace thew {

/// A file written piece by piece beside its place and renamed by finish(); without finish() nothing
/// is left of it. Error(kOutput).
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
  std::uint64_t size() const { return size_; }
  void finish();

 private:
  [[noreturn]] void fail(const char* what) const;

  std::filesystem::path file_;
  std::FILE* out_;
  std::uint64_t size_ = 0;
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

}  // namespace thew
