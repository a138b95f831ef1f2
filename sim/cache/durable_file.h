// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/cache/file_io.h"
#include "sim/cache/own_files.h"

namespace thew::sim {

// Files that survive a kill or a power cut: written under a temporary name, synced, read back,
// listed (own_files.h), renamed, and their folder synced. Any failure is Error(kOutput).

/// `of` is a key of the file's contents (OwnFile::of), by which a later command may keep the file
/// instead of writing it again.
void write_durably(const std::filesystem::path& file, std::string_view bytes,
                   const std::string& of = {});
/// The same for a file that has been written and closed at `temporary`, in the same folder.
void place_durably(const std::filesystem::path& temporary, const std::filesystem::path& file,
                   const OwnFile& about = {});
/// The same in a folder whose contents all belong to Thew: any regular file of that name is
/// replaced, and nothing is listed.
void replace_durably(const std::filesystem::path& file, std::string_view bytes);

/// Locks a folder for this process until the object or the process ends. Error(kRetry) where
/// another process has locked it. Leaves no file behind.
class FolderLock {
 public:
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace thew::sim
