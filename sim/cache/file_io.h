// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace thew::sim {

// Writes and reads the bytes of files. A failure to write is Error(kOutput) with the path, the
// cause and the next move.

/// Throws that error: `what` is the verb, such as "open", `error` an errno.
[[noreturn]] void fail_to_write(const std::filesystem::path& path, const char* what, int error);

/// An open file, closed by the destructor; close() reports a failure, the destructor does not.
class Descriptor {
 public:
  /// `named` is the name of the file in messages, where that is not its path.
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
/// Appends one line and syncs. A kill may leave this line incomplete; the lines before it and those
/// that follow later stay whole.
void append_durably(const std::filesystem::path& file, std::string_view line);
void create_folders(const std::filesystem::path& folder);
/// Error(kOutput) where something else than a file of this type is at the path, in particular a
/// symbolic link. To be called before a long computation, not after it.
void check_replaceable(const std::filesystem::path& path, std::filesystem::file_type type);
/// The paths of all entries of a folder, in no particular order.
std::vector<std::filesystem::path> paths_in(const std::filesystem::path& folder);
/// Removes a file; it need not exist.
void remove_file(const std::filesystem::path& file);

/// All bytes of a regular file of at most `most` bytes. Error(kInput).
std::string read_whole_file(const std::filesystem::path& file, std::size_t most);

}  // namespace thew::sim
