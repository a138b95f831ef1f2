// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "sim/cache/file_io.h"
#include "sim/cache/own_files.h"

namespace thew::sim {

/// What survives a kill or a power cut: written beside, synced, read back, listed as ours
/// (own_files.h), renamed, folder synced. Error(kOutput).

/// `of`: a key of what the file holds, for whoever wants to keep it instead of writing it again.
void write_durably(const std::filesystem::path& file, std::string_view bytes,
                   const std::string& of = {});
/// For a file that something else has written and closed at `temporary`, in the same folder.
void place_durably(const std::filesystem::path& temporary, const std::filesystem::path& file,
                   const OwnFile& about = {});
/// The same as write_durably in a folder that is ours with all that is in it: whatever regular file
/// stands there is replaced, and nothing is listed.
void replace_durably(const std::filesystem::path& file, std::string_view bytes);

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

}  // namespace thew::sim
