// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace thew::sim {

// Thew replaces and removes files that it wrote, and no others. FOLDER/.thew.jsonl is the journal
// of these files, one line a file:
//   {"file":"skin.0001.png","bytes":12345,"hash":"…","of":"…"}
// A line is synced before the file gets its name, so that after a kill no file of Thew is unlisted.
// The last complete line of a name counts; a line {"file":"…"} says that the file was removed. A
// file in the way that is not listed is foreign: Error(kOutput).

struct OwnFile {
  std::size_t bytes = 0;
  std::string hash;  ///< XXH3-128, hex; "" where it is not needed
  std::string of;    ///< a key of its contents, by which a later command may keep it
};

/// All files that the journal of a folder lists, by name.
std::map<std::string, OwnFile> own_files(const std::filesystem::path& folder);
/// What the journal says of one file; nothing where it is not listed.
std::optional<OwnFile> own_file(const std::filesystem::path& file);
/// Adds a line to the journal of the file's folder, and syncs it.
void list_own(const std::filesystem::path& file, const OwnFile& about = {});
/// Throws Error(kOutput): the file is there and was not written by Thew.
[[noreturn]] void refuse_foreign(const std::filesystem::path& file);
/// Error(kOutput) unless the file is listed or not there.
void check_own(const std::filesystem::path& file);
/// The same for all files that a command will write, to be called before a long computation. With
/// `overwrite` foreign files are added to the journal instead. Removes leftovers from their
/// folders.
void claim(const std::vector<std::filesystem::path>& files, bool overwrite);
/// Makes the folder where it is missing. Error(kOutput) where something else of its name is there,
/// also a symbolic link.
void claim_folder(const std::filesystem::path& folder);
/// Removes temporary files that killed commands have left in a folder.
void remove_leftovers(const std::filesystem::path& folder);
/// Removes the file if it is listed, and says so in the journal.
void remove_own(const std::filesystem::path& file);

/// A unique temporary name in the folder of `file`. Whatever has that name at the end of this
/// object is removed.
struct Temporary {
  explicit Temporary(const std::filesystem::path& file);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  const std::filesystem::path path;
};

}  // namespace thew::sim
