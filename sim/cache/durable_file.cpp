// SPDX-License-Identifier: Apache-2.0
#include "sim/cache/durable_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "rig/types.h"
#include "sim/cache/hash.h"

namespace thew::sim {
namespace {

namespace fs = std::filesystem;

// Reads piece by piece: a copy of the whole file would cost more than writing it.
void verify(const fs::path& file, std::string_view bytes, const fs::path& named) {
  const Descriptor in(file, O_RDONLY, named);
  char piece[1 << 16];
  while (true) {
    const ssize_t got = ::read(in.value(), piece, sizeof piece);
    if (got < 0 && errno == EINTR) continue;
    if (got == 0 && bytes.empty()) return;
    const auto count = static_cast<std::size_t>(got);
    if (got <= 0 || count > bytes.size() || std::memcmp(piece, bytes.data(), count) != 0) {
      fail_to_write(named, "verify", EIO);
    }
    bytes.remove_prefix(count);
  }
}

// Writes, closes and reads back a file; `named` is the name in messages.
void write_whole(const fs::path& temporary, std::string_view bytes, const fs::path& named) {
  Descriptor out(temporary, O_WRONLY | O_CREAT | O_EXCL, named);
  out.write(bytes);
  out.close();
  verify(temporary, bytes, named);
}

void move_durably(const fs::path& temporary, const fs::path& file) {
  if (::rename(temporary.c_str(), file.c_str()) != 0) fail_to_write(file, "rename to", errno);
  sync_folder(file.parent_path());
}

}  // namespace

void replace_durably(const fs::path& file, std::string_view bytes) {
  check_replaceable(file, fs::file_type::regular);
  const Temporary temporary(file);
  write_whole(temporary.path, bytes, file);
  Descriptor(temporary.path, O_RDONLY, file).sync();
  move_durably(temporary.path, file);
}

void write_durably(const fs::path& file, std::string_view bytes, const std::string& of) {
  check_own(file);
  const Temporary temporary(file);
  write_whole(temporary.path, bytes, file);
  place_durably(temporary.path, file, {bytes.size(), hash_of(bytes), of});
}

void place_durably(const fs::path& temporary, const fs::path& file, const OwnFile& about) {
  check_own(file);
  Descriptor(temporary, O_RDONLY, file).sync();
  list_own(file, about);
  move_durably(temporary, file);
}

FolderLock::FolderLock(const fs::path& folder)
    : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0) fail_to_write(folder, "open", errno);
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int error = errno;
  ::close(descriptor_);
  if (error != EWOULDBLOCK) fail_to_write(folder, "lock", error);
  throw Error(ErrorCode::kRetry,
              folder.string() +
                  ": another bake is writing here; write elsewhere, or wait for it and run again");
}

FolderLock::~FolderLock() {
  // A child that was forked meanwhile (a reader, before it executes or ends) has the descriptor
  // too, and closing ours would leave it the lock.
  ::flock(descriptor_, LOCK_UN);
  ::close(descriptor_);
}

}  // namespace thew::sim
