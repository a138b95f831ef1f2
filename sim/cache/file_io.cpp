// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/file_io.h"

#include <dirent.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <memory>
#include <system_error>

#include "rig/types.h"

namespace thew::sim {

namespace fs = std::filesystem;

void fail_to_write(const fs::path& path, const char* what, int error) {
  const bool full = error == ENOSPC || error == EDQUOT || error == EFBIG;
  throw Error(ErrorCode::kOutput,
              path.string() + ": cannot " + what + ": " + std::generic_category().message(error) +
                  (full ? "; free some space and run again"
                        : "; check the folder and its permissions, then run again"));
}

Descriptor::Descriptor(const fs::path& path, int flags, const fs::path& named)
    : named_(named.empty() ? path : named), value_(::open(path.c_str(), flags | O_CLOEXEC, 0666)) {
  if (value_ < 0) fail_to_write(named_, "open", errno);
}

Descriptor::~Descriptor() {
  if (value_ >= 0) ::close(value_);
}

void Descriptor::write(std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(value_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail_to_write(named_, "write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

void Descriptor::sync() {
  if (::fsync(value_) != 0) fail_to_write(named_, "sync", errno);
}

void Descriptor::close() {
  const int closing = value_;
  value_ = -1;
  if (::close(closing) != 0) fail_to_write(named_, "close", errno);
}

void sync_folder(const fs::path& folder) {
  Descriptor(folder.empty() ? "." : folder, O_RDONLY | O_DIRECTORY).sync();
}

void check_replaceable(const fs::path& path, fs::file_type type) {
  std::error_code error;
  const fs::file_type there = fs::symlink_status(path, error).type();
  if (there == type || there == fs::file_type::not_found) return;
  if (there == fs::file_type::none) fail_to_write(path, "open", error.value());
  const std::string what = there == fs::file_type::symlink
                               ? "is a symbolic link, through which nothing is written"
                               : "something else of that name is in the way";
  throw Error(ErrorCode::kOutput, path.string() + ": " + what + "; remove it, or write elsewhere");
}

void append_durably(const fs::path& file, std::string_view line) {
  Descriptor out(file, O_RDWR | O_CREAT | O_APPEND | O_NOFOLLOW);
  // Machines that share the file over a network would otherwise append at the same place. Where
  // the file system has no locks, processes of one machine need none.
  while (::flock(out.value(), LOCK_EX) != 0 && errno == EINTR) {
  }
  // An incomplete line that a kill or a full disk has left is ended first, in the same write, so
  // that the lines of other processes stay whole.
  char last = '\n';
  const off_t size = ::lseek(out.value(), 0, SEEK_END);
  if (size > 0 && ::pread(out.value(), &last, 1, size - 1) != 1) fail_to_write(file, "read", EIO);
  std::string text(last == '\n' ? "" : "\n");
  text += line;
  text += '\n';
  out.write(text);
  out.sync();
  out.close();
  if (size == 0) sync_folder(file.parent_path());  // it may have been made just now
}

void create_folders(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (!error && !fs::is_directory(folder, error)) error = {ENOTDIR, std::generic_category()};
  if (error) fail_to_write(folder, "create the folder", error.value());
}

// By system calls, since the standard library's iterators of folders end the process where memory
// runs out.
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

void remove_file(const fs::path& file) {
  if (::unlink(file.c_str()) == 0) {
    sync_folder(file.parent_path());
  } else if (errno != ENOENT && errno != ENOTDIR) {
    fail_to_write(file, "remove", errno);
  }
}

std::string read_whole_file(const fs::path& file, std::size_t most) {
  const auto fail = [&](const std::string& cause) {
    throw Error(ErrorCode::kInput, file.string() + ": cannot read: " + cause + "; check the file");
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

}  // namespace thew::sim
