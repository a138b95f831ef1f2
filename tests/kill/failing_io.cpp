// SPDX-License-Identifier: Apache-2.0
// Preloaded into a bake: of its calls that touch files below THEW_FAIL_BELOW, number THEW_FAIL_AT
// (counted from 1) fails with EIO, a write after half of its bytes; with THEW_FAIL_ON all later
// ones as well. How many there were is written to THEW_FAIL_COUNT.
#include <dlfcn.h>
#include <fcntl.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<long> calls{0};
const pid_t process = getpid();  // a child that reads is left alone

bool is_below(const char* path) {
  const char* folder = std::getenv("THEW_FAIL_BELOW");
  return folder && std::strncmp(path, folder, std::strlen(folder)) == 0;
}

bool is_below(int file) {
  char link[64], path[4096];
  std::snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  const ssize_t length = readlink(link, path, sizeof path - 1);
  if (length <= 0) return false;
  path[length] = '\0';
  return is_below(path);
}

bool fails() {
  if (getpid() != process) return false;
  const char* at = std::getenv("THEW_FAIL_AT");
  const long wanted = at ? std::atol(at) : 0, now = ++calls;
  if (wanted == 0 || (std::getenv("THEW_FAIL_ON") ? now < wanted : now != wanted)) return false;
  errno = EIO;
  return true;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(dlsym(RTLD_NEXT, name));
}

struct Count {
  ~Count() {
    const char* file = std::getenv("THEW_FAIL_COUNT");
    if (!file || getpid() != process) return;
    if (std::FILE* out = std::fopen(file, "w")) {
      std::fprintf(out, "%ld\n", calls.load());
      std::fclose(out);
    }
  }
} count;

}  // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (is_below(path) && fails()) return -1;
  return next<int (*)(const char*, int, ...)>("open")(path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  va_list list;
  va_start(list, flags);
  const mode_t mode = (flags & O_CREAT) ? va_arg(list, mode_t) : 0;
  va_end(list);
  if (is_below(path) && fails()) return -1;
  return next<int (*)(const char*, int, ...)>("open64")(path, flags, mode);
}
ssize_t write(int file, const void* bytes, size_t count) {
  const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  if (!is_below(file) || !fails()) return real(file, bytes, count);
  if (real(file, bytes, count / 2) < 0) return -1;
  errno = EIO;
  return -1;
}
ssize_t pwrite64(int file, const void* bytes, size_t count, off64_t offset) {
  const auto real = next<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  if (!is_below(file) || !fails()) return real(file, bytes, count, offset);
  if (real(file, bytes, count / 2, offset) < 0) return -1;
  errno = EIO;
  return -1;
}
ssize_t pwrite(int file, const void* bytes, size_t count, off_t offset) {
  return pwrite64(file, bytes, count, offset);
}
ssize_t read(int file, void* bytes, size_t count) {
  if (is_below(file) && fails()) return -1;
  return next<ssize_t (*)(int, void*, size_t)>("read")(file, bytes, count);
}
int fsync(int file) {
  if (is_below(file) && fails()) return -1;
  return next<int (*)(int)>("fsync")(file);
}
int close(int file) {
  const bool bad = is_below(file) && fails();
  const int result = next<int (*)(int)>("close")(file);
  if (!bad) return result;
  errno = EIO;
  return -1;
}
int rename(const char* from, const char* to) {
  if (is_below(to) && fails()) return -1;
  return next<int (*)(const char*, const char*)>("rename")(from, to);
}
int ftruncate64(int file, off64_t length) {
  if (is_below(file) && fails()) return -1;
  return next<int (*)(int, off64_t)>("ftruncate64")(file, length);
}
int ftruncate(int file, off_t length) { return ftruncate64(file, length); }

}  // extern "C"
