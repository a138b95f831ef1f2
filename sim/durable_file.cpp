// SPDX-License-Identifier: Apache-2.0
#include "sim/durable_file.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

#include "rig/types.h"

namespace thew {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail_to_write(const fs::path& path, const char* what, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw Error(ExitCode::kOutput,
              path.string() + ": cannot " + what + ": " + std::generic_category().message(error) +
                  (full ? "; free some space and run again"
                        : "; check the folder and its permissions, then run again"));
}

/// A file descriptor that closes itself; close() tells when that fails.
class Descriptor {
 public:
  Descriptor(const fs::path& path, int flags)
      : path_(path), value_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
    if (value_ < 0) fail_to_write(path, "open", errno);
  }
  ~Descriptor() {
    if (value_ >= 0) ::close(value_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;

  void write(std::string_view bytes) {
    while (!bytes.empty()) {
      const ssize_t written = ::write(value_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0) fail_to_write(path_, "write", errno);
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }
  void sync() {
    if (::fsync(value_) != 0) fail_to_write(path_, "sync", errno);
  }
  void close() {
    const int closing = value_;
    value_ = -1;
    if (::close(closing) != 0) fail_to_write(path_, "close", errno);
  }

 private:
  fs::path path_;
  int value_;
};

void sync_folder(const fs::path& folder) {
  Descriptor(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY).sync();
}

void verify(const fs::path& file, std::string_view bytes) {
  try {
    if (read_whole_file(file, bytes.size()) == bytes) return;
  } catch (const Error&) {
  }
  fail_to_write(file, "verify", EIO);
}

}  // namespace

void check_replaceable(const fs::path& path, fs::file_type type) {
  std::error_code error;
  const fs::file_type there = fs::symlink_status(path, error).type();
  if (there == type || there == fs::file_type::not_found) return;
  if (there == fs::file_type::none) fail_to_write(path, "open", error.value());
  const std::string what = there == fs::file_type::symlink
                               ? "is a symbolic link, through which nothing is written"
                               : "something else of that name is in the way";
  throw Error(ExitCode::kOutput, path.string() + ": " + what + "; remove it, or write elsewhere");
}

fs::path beside(const fs::path& file) { return fs::path(file) += ".tmp"; }

void write_durably(const fs::path& file, std::string_view bytes) {
  check_replaceable(file, fs::file_type::regular);
  const fs::path temporary = beside(file);
  ::unlink(temporary.c_str());  // of a bake that was killed, or a link that leads elsewhere
  try {
    Descriptor out(temporary, O_WRONLY | O_CREAT | O_EXCL);
    out.write(bytes);
    out.close();
    verify(temporary, bytes);
    rename_durably(file);
  } catch (...) {
    ::unlink(temporary.c_str());  // a full disk gets its space back
    throw;
  }
}

void rename_durably(const fs::path& file) {
  const fs::path temporary = beside(file);
  Descriptor(temporary, O_RDONLY).sync();
  if (::rename(temporary.c_str(), file.c_str()) != 0) fail_to_write(file, "rename to", errno);
  sync_folder(file.parent_path());
}

void append_durably(const fs::path& file, std::string_view line) {
  Descriptor out(file, O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW);
  out.write(std::string(line) + "\n");
  out.sync();
  out.close();
}

void create_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder, error)) error = {ENOTDIR, std::generic_category()};
  if (error) fail_to_write(folder, "create the folder", error.value());
}

// By the system's own calls, here and below: where memory ends within the standard library's
// iterators of folders they end the process.
std::vector<fs::path> paths_in(const fs::path& folder) {
  std::vector<fs::path> paths;
  const std::unique_ptr<DIR, int (*)(DIR*)> open(::opendir(folder.c_str()), ::closedir);
  if (!open) fail_to_write(folder, "list", errno);
  while (const dirent* entry = ::readdir(open.get())) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") paths.push_back(folder / name);
  }
  return paths;
}

namespace {

bool remove_tree(const fs::path& path) {
  struct stat about {};
  if (::lstat(path.c_str(), &about) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) return false;
    fail_to_write(path, "remove", errno);
  }
  if (S_ISDIR(about.st_mode)) {
    for (const fs::path& inside : paths_in(path)) remove_tree(inside);
  }
  if (::remove(path.c_str()) != 0) fail_to_write(path, "remove", errno);
  return true;
}

}  // namespace

void remove_durably(const fs::path& path) {
  if (remove_tree(path)) sync_folder(path.parent_path());
}

std::string read_whole_file(const fs::path& file, std::size_t most) {
  const auto fail = [&](const std::string& cause) {
    throw Error(ExitCode::kInput, file.string() + ": cannot read: " + cause + "; check the file");
  };
  // A pipe would block for ever.
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) fail(std::generic_category().message(errno));
  struct stat about {};
  std::string bytes;
  std::string cause;
  if (::fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode)) {
    cause = "not a regular file";
  } else if (static_cast<std::size_t>(about.st_size) > most) {
    cause = std::to_string(about.st_size) + " bytes, more than " + std::to_string(most);
  } else {
    bytes.resize(static_cast<std::size_t>(about.st_size));
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t got = ::read(descriptor, bytes.data() + done, bytes.size() - done);
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        cause = got < 0 ? std::generic_category().message(errno) : "it became shorter";
        break;
      }
      done += static_cast<std::size_t>(got);
    }
  }
  ::close(descriptor);
  if (!cause.empty()) fail(cause);
  return bytes;
}

FolderLock::FolderLock(const fs::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) fail_to_write(folder, "open", errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  ::close(descriptor_);
  if (error != EWOULDBLOCK) fail_to_write(folder, "lock", error);
  throw Error(ExitCode::kRetry,
              folder.string() +
                  ": another bake is writing here; write elsewhere, or wait for it and run again");
}

FolderLock::~FolderLock() { ::close(descriptor_); }

}  // namespace thew
