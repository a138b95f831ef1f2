// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace thew {

/// What survives a kill or a power cut: written beside, synced, read back, renamed, folder synced.
/// Whatever cannot be written is Error(kOutput) with the path, the cause and the next move.

/// Where `file` is written before it is renamed.
std::filesystem::path beside(const std::filesystem::path& file);

void write_durably(const std::filesystem::path& file, std::string_view bytes);
/// For a file that something else has written and closed at beside(file).
void rename_durably(const std::filesystem::path& file);
/// Adds one line; a kill may leave it torn, never the lines before it.
void append_durably(const std::filesystem::path& file, std::string_view line);
void create_folders(const std::filesystem::path& folder);
/// Error(kOutput) where something of another type stands, a symbolic link in particular: to be
/// asked before hours of work, not after them.
void check_replaceable(const std::filesystem::path& path, std::filesystem::file_type type);
/// All that a folder holds, in no particular order.
std::vector<std::filesystem::path> paths_in(const std::filesystem::path& folder);
/// Removes a file, or a folder with all that is in it; it need not exist.
void remove_durably(const std::filesystem::path& path);

/// All bytes of a regular file of at most `most` bytes. Error(kInput).
std::string read_whole_file(const std::filesystem::path& file, std::size_t most);

/// The folder is held for one process until this object or the process ends; the next one to ask
/// gets Error(kRetry). Leaves no file behind.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace thew
