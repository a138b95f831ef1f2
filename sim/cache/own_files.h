// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace thew::sim {

/// Thew replaces and removes what it wrote and nothing else. FOLDER/.thew.jsonl lists that, a line
/// a file:
///   {"file":"skin.0001.png","bytes":12345,"hash":"…","of":"…"}
/// A line is synced before the file is renamed to its place, so that no kill leaves a file of ours
/// that is not listed. The last whole line of a name counts; {"file":"…"} alone: it was removed.
/// What stands in a place of ours and is not listed is Error(kOutput).

struct OwnFile {
  std::size_t bytes = 0;
  std::string hash;  ///< XXH3-128; "" where nobody asks for it
  std::string of;    ///< a key of what it holds
};

std::map<std::string, OwnFile> own_files(const std::filesystem::path& folder);
std::optional<OwnFile> own_file(const std::filesystem::path& file);
void list_own(const std::filesystem::path& file, const OwnFile& about = {});
[[noreturn]] void refuse_foreign(const std::filesystem::path& file);
/// Error(kOutput) unless nothing stands there or a file of ours.
void check_own(const std::filesystem::path& file);
/// The same for all that a command will write, before it works for hours; takes away what killed
/// commands left beside them. `overwrite`: a file of others is ours from here on.
void claim(const std::vector<std::filesystem::path>& files, bool overwrite);
/// A folder of our naming, made where it is missing. Error(kOutput) for a link in its place.
void claim_folder(const std::filesystem::path& folder);
/// Takes away what commands that were killed left half written in a folder.
void remove_leftovers(const std::filesystem::path& folder);
/// Removes the file where it is ours, and from the list.
void remove_own(const std::filesystem::path& file);

/// A name beside `file` that no other process has, and no file at its end unless it was renamed.
struct Temporary {
  explicit Temporary(const std::filesystem::path& file);
  ~Temporary();
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  const std::filesystem::path path;
};

}  // namespace thew::sim
