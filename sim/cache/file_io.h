// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace thew::sim {

/// Bytes into files and out of them. Whatever cannot be written is Error(kOutput) with the path,
/// the cause and the next move.

[[noreturn]] void fail_to_write(const std::filesystem::path& path, const char* what, int error);

/// A file descriptor that closes itself; close() tells when that fails.
class Descriptor {
 public:
  /// `named`: what errors call the file, where that is another name.
  Descriptor(const std::filesystem::path& path, int flags, const std::filesystem::path& named = {});
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(std::string_view bytes);
  void sync();
  void close();
  int value() const { return value_; }

 private:
  std::filesystem::path named_;
  int value_;
};

void sync_folder(const std::filesystem::path& folder);
/// Adds one line; a kill may leave it torn, never the lines before it, nor the next one.
void append_durably(const std::filesystem::path& file, std::string_view line);
void create_folders(const std::filesystem::path& folder);
/// Error(kOutput) where something of another type stands, a symbolic link in particular: to be
/// asked before hours of work, not after them.
void check_replaceable(const std::filesystem::path& path, std::filesystem::file_type type);
/// All that a folder holds, in no particular order.
std::vector<std::filesystem::path> paths_in(const std::filesystem::path& folder);
/// Removes a file; it need not exist.
void remove_file(const std::filesystem::path& file);

/// All bytes of a regular file of at most `most` bytes. Error(kInput).
std::string read_whole_file(const std::filesystem::path& file, std::size_t most);

}  // namespace thew::sim
