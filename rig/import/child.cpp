// SPDX-License-Identifier: Apache-2.0
#include "rig/import/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>
#include <utility>

#include "rig/import/confine.h"
#include "rig/text.h"
#include "thew/import.h"

namespace thew {
namespace {
std::atomic<ImportMode> import_mode{ImportMode::kIsolated};
}

void set_import_mode(ImportMode mode) { import_mode = mode; }

namespace rig {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;  // bytes
constexpr std::uint64_t kMemoryPerByte = 8;
constexpr unsigned kSeconds = 2;
constexpr std::uint64_t kBytesPerSecond = std::uint64_t{8} << 20;
constexpr int kClockOverProcessor = 5;

constexpr std::uint64_t kMagic = 0x7265776e61776874;  // "thwanwer"
constexpr std::uint64_t kFirstError = 1;  // of an answer: 0 is none, then the codes of Error ...
constexpr std::uint64_t kOtherFailure = 256;  // ... and what is no Error
constexpr std::uint64_t kAsksForFile = 257;   // no answer yet: the text is a name
constexpr int kMostFiles = 1000;              // for one answer
constexpr int kOutOfMemory = 12;              // the child's own exit code

struct Header {
  std::uint64_t magic, code, bytes;
};

bool send_all(int socket, const void* from, std::size_t bytes) {
  const char* at = static_cast<const char*>(from);
  while (bytes > 0) {
    const ssize_t sent = ::send(socket, at, bytes, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent;
    bytes -= static_cast<std::size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, void* to, std::size_t bytes) {
  char* at = static_cast<char*>(to);
  while (bytes > 0) {
    const ssize_t got = ::recv(socket, at, bytes, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
  return true;
}

bool send_text(int socket, std::string_view text) {
  const std::uint64_t bytes = text.size();
  return send_all(socket, &bytes, sizeof bytes) && send_all(socket, text.data(), text.size());
}

bool receive_text(int socket, std::string& text) {
  std::uint64_t bytes = 0;
  if (!receive_all(socket, &bytes, sizeof bytes)) return false;
  text.resize(bytes);
  return receive_all(socket, text.data(), bytes);
}

// Bytes of address space that the process has; 0 where the system does not tell.
std::uint64_t address_space() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::uint64_t{pages} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

// Whether the process may have less than so many bytes more.
bool is_tight(std::uint64_t memory) {
  rlimit now{};
  return ::getrlimit(RLIMIT_AS, &now) == 0 && now.rlim_cur != RLIM_INFINITY &&
         now.rlim_cur < address_space() + memory;
}

void limit(int resource, rlim_t most) {
  rlimit now{};
  ::getrlimit(static_cast<__rlimit_resource>(resource), &now);
  now.rlim_cur = std::min(most, now.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

// What open_in_child() needs; of the child, in which there is one of it, or of the thread that
// reads in its place, which has no socket.
int socket_of_child = -1;
thread_local std::filesystem::path path_of_child;

std::recursive_mutex& one_reader_at_a_time() {
  static std::recursive_mutex mutex;
  return mutex;
}

// The bytes of the file, -1 for none, and beside them its descriptor.
struct FileMessage {
  explicit FileMessage(std::int64_t& bytes) : part{&bytes, sizeof bytes} {
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control;
    message.msg_controllen = sizeof control;
  }
  iovec part;
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(int))] = {};
  msghdr message{};
};

bool send_file(int socket, int descriptor, std::int64_t bytes) {
  FileMessage out(bytes);
  if (descriptor < 0) {
    out.message.msg_controllen = 0;
  } else {
    cmsghdr* head = CMSG_FIRSTHDR(&out.message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(sizeof descriptor);
    std::memcpy(CMSG_DATA(head), &descriptor, sizeof descriptor);
  }
  ssize_t sent = 0;
  while ((sent = ::sendmsg(socket, &out.message, MSG_NOSIGNAL)) < 0 && errno == EINTR) continue;
  return sent == static_cast<ssize_t>(sizeof bytes);
}

bool receive_file(int socket, OpenFile& file) {
  std::int64_t bytes = -1;
  FileMessage in(bytes);
  ssize_t got = 0;
  while ((got = ::recvmsg(socket, &in.message, MSG_CMSG_CLOEXEC)) < 0 && errno == EINTR) continue;
  if (got != static_cast<ssize_t>(sizeof bytes)) return false;
  const cmsghdr* head = CMSG_FIRSTHDR(&in.message);
  if (bytes < 0 || !head || head->cmsg_type != SCM_RIGHTS) return true;
  std::memcpy(&file.descriptor, CMSG_DATA(head), sizeof file.descriptor);
  file.bytes = static_cast<std::uint64_t>(bytes);
  return true;
}

// It dies with its parent, says nothing, leaves no core, and is no place for anyone's handlers.
// Returns the socket, clear of the standard streams, one of which it is where the parent has closed
// its own; of the parent's other descriptors it has none.
int become_child(pid_t parent, std::uint64_t memory, int socket) {
  const int clear = ::fcntl(socket, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
    std::signal(signal, SIG_DFL);
  }
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
  if (clear > STDERR_FILENO + 1) ::close_range(STDERR_FILENO + 1, clear - 1, 0);
  ::close_range(clear + 1, ~0u, 0);
  limit(RLIMIT_CORE, 0);
  if (const std::uint64_t now = address_space()) limit(RLIMIT_AS, now + memory);
#ifndef THEW_SANITIZED
  confine_process();
#endif
  return clear;
}

// Processor time counts from the begin of the process; the limit is in whole seconds.
void allow_seconds(unsigned seconds) {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto spent = static_cast<rlim_t>(used.ru_utime.tv_sec + used.ru_stime.tv_sec);
  limit(RLIMIT_CPU, spent + seconds);
}

// noexcept: the child must not unwind into what its parent was doing.
[[noreturn]] void serve(int socket, unsigned seconds, const Child::Answer& answer) noexcept {
  for (std::string path; receive_text(socket, path);) {
    path_of_child = path;
    allow_seconds(seconds);
    std::string text;
    std::uint64_t code = 0;
    try {
      std::string request;
      if (!receive_text(socket, request)) break;
      text = answer(request);
    } catch (const Error& error) {
      code = kFirstError + static_cast<std::uint64_t>(error.code());
      text = error.what();
    } catch (const std::bad_alloc&) {
      ::_exit(kOutOfMemory);
    } catch (const std::exception& error) {
      code = kOtherFailure;
      text = error.what();
    }
    const Header header{kMagic, code, text.size()};
    if (!send_all(socket, &header, sizeof header)) break;
    if (!send_all(socket, text.data(), text.size())) break;
  }
  ::_exit(0);
}

// `name` is the reader's own where it is a regular file in or below the folder.
OpenFile open_below(const std::filesystem::path& folder, const std::filesystem::path& name) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::canonical(folder / name, error);
  if (error || !is_below(path, folder) || !std::filesystem::is_regular_file(path, error)) return {};
  OpenFile file;
  file.descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (file.descriptor < 0) return file;
  struct stat status {};
  if (::fstat(file.descriptor, &status) == 0 && S_ISREG(status.st_mode)) {
    file.bytes = static_cast<std::uint64_t>(status.st_size);
    return file;
  }
  ::close(file.descriptor);
  return {};
}

}  // namespace

const std::filesystem::path& file_of_child() { return path_of_child; }

OpenFile open_in_child(const std::filesystem::path& name) {
  if (socket_of_child < 0) return open_below(path_of_child.parent_path(), name);
  const std::string& text = name.native();
  const Header header{kMagic, kAsksForFile, text.size()};
  OpenFile file;
  if (!send_all(socket_of_child, &header, sizeof header) ||
      !send_all(socket_of_child, text.data(), text.size()) ||
      !receive_file(socket_of_child, file)) {
    ::_exit(0);  // the parent has gone
  }
  return file;
}

std::string read_in_child(const std::filesystem::path& name, std::size_t limit) {
  const OpenFile file = open_in_child(name);
  std::string bytes;
  bool good = file.descriptor >= 0 && file.bytes <= limit;
  if (good) bytes.resize(file.bytes);
  for (std::size_t at = 0; good && at < bytes.size();) {
    const ssize_t got = ::read(file.descriptor, bytes.data() + at, bytes.size() - at);
    if (got < 0 && errno == EINTR) continue;
    good = got > 0;
    at += good ? static_cast<std::size_t>(got) : 0;
  }
  if (file.descriptor >= 0) ::close(file.descriptor);
  if (good) return bytes;
  throw Error(ErrorCode::kInput, name.string() +
                                     ": cannot be read; check that it is a file of at "
                                     "most " +
                                     std::to_string(limit >> 20) + " MiB, and its permissions");
}

std::unique_lock<std::recursive_mutex> keep_from_forking() {
  return std::unique_lock(one_reader_at_a_time());
}

Child::Child(std::filesystem::path file, std::string advice, const Answer& answer)
    : advice_(std::move(advice)) {
  turn_to(std::move(file));
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file_, error);
  memory_ = kMemory + (error ? 0 : kMemoryPerByte * size);
  seconds_ = kSeconds + static_cast<unsigned>(error ? 0 : size / kBytesPerSecond);
  if (import_mode == ImportMode::kInProcess) {
    answer_ = answer;
    return;
  }
  const auto fail_to_start = [&](const char* what) {
    throw Error(ErrorCode::kRetry, file_.string() + ": cannot start a process to read it in: " +
                                       what + "; end some processes and run again");
  };
  std::array<int, 2> sockets{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    fail_to_start(std::strerror(errno));
  }
  const pid_t parent = ::getpid();
  auto forking = keep_from_forking();
  process_ = ::fork();
  if (process_ == 0) {
    socket_of_child = become_child(parent, memory_, sockets[1]);
    serve(socket_of_child, seconds_, answer);
  }
  const int failure = errno;
  forking.unlock();
  ::close(sockets[1]);
  socket_ = sockets[0];
  if (process_ > 0) return;
  ::close(socket_);
  fail_to_start(std::strerror(failure));
}

Child::~Child() {
  if (answer_) {  // what it has opened is closed by the same libraries
    const std::lock_guard lock(one_reader_at_a_time());
    answer_ = nullptr;
  }
  if (socket_ >= 0) ::close(socket_);
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
}

void Child::turn_to(std::filesystem::path file) {
  file_ = std::move(file);
  std::error_code error;
  real_ = std::filesystem::canonical(file_, error);
  if (error) real_ = std::filesystem::absolute(file_, error);
}

void Child::refuse(const std::string& what) const {
  throw Error(ErrorCode::kInput, file_.string() + ": " + what + "; " + advice_);
}

// Waits for it, and says why it ended, or that it had to be.
void Child::fail() {
  pollfd hung_up{socket_, POLLIN, 0};
  const bool ended = ::poll(&hung_up, 1, 0) > 0;
  if (!ended) ::kill(process_, SIGKILL);
  int status = 0;
  pid_t waited = 0;
  while ((waited = ::waitpid(process_, &status, 0)) < 0 && errno == EINTR) continue;
  process_ = -1;
  const int signal = waited > 0 && WIFSIGNALED(status) ? WTERMSIG(status) : 0;
  if (!ended || signal == SIGXCPU) {
    refuse("reading it was ended after " + std::to_string(seconds_) + " s");
  }
  const bool no_memory = WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory;
  if (is_tight(memory_) && (no_memory || (signal != 0 && signal != SIGSYS))) {
    throw Error(ErrorCode::kRetry, file_.string() +
                                       ": reading it takes more memory than there is; raise the "
                                       "limit (ulimit -v) and try again");
  }
  if (signal == SIGSYS) refuse("its reader was ended: it asked for a network or another process");
  if (signal != 0) refuse(std::string("its reader crashed (") + ::strsignal(signal) + ")");
  if (no_memory) {
    refuse("reading it takes more than " + std::to_string(memory_ >> 20) + " MiB of memory");
  }
  refuse("its reader ended too soon");
}

void Child::receive(void* to, std::size_t bytes) {
  char* at = static_cast<char*>(to);
  while (bytes > 0) {
    pollfd ready{socket_, POLLIN, 0};
    const int polled = ::poll(&ready, 1, static_cast<int>(1000 * kClockOverProcessor * seconds_));
    if (polled < 0 && errno == EINTR) continue;
    const ssize_t got = polled > 0 ? ::recv(socket_, at, bytes, 0) : 0;
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) fail();
    at += got;
    bytes -= static_cast<std::size_t>(got);
  }
}

void Child::hand_over(const std::string& name) {
  const OpenFile file = open_below(real_.parent_path(), name);
  const bool good = file.descriptor >= 0;
  const bool sent =
      send_file(socket_, file.descriptor, good ? static_cast<std::int64_t>(file.bytes) : -1);
  if (good) ::close(file.descriptor);
  if (!sent) fail();
}

std::string Child::answer_here(std::string_view request) {
  const std::lock_guard lock(one_reader_at_a_time());
  struct Current {
    explicit Current(const std::filesystem::path& path)
        : before(std::exchange(path_of_child, path)) {}
    ~Current() { path_of_child = std::move(before); }
    std::filesystem::path before;
  } current(real_);
  try {
    return answer_(request);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::kRetry, file_.string() +
                                       ": reading it takes more memory than there is; free some "
                                       "and try again");
  } catch (const std::exception& error) {
    refuse(error.what());
  }
}

std::string Child::ask(std::string_view request) {
  if (answer_) return answer_here(request);
  if (process_ < 0) refuse("its reader has ended");
  if (!send_text(socket_, real_.native()) || !send_text(socket_, request)) fail();
  Header header{};
  std::string text;
  for (int files = 0;; ++files) {
    receive(&header, sizeof header);
    if (header.magic != kMagic || header.bytes > memory_ || header.code > kAsksForFile) {
      refuse("its reader sent nonsense");
    }
    text.resize(header.bytes);
    receive(text.data(), text.size());
    if (header.code != kAsksForFile) break;
    if (files == kMostFiles) refuse("it needs more than " + std::to_string(files) + " files");
    hand_over(text);
  }
  if (header.code == 0) return text;
  if (header.code == kOtherFailure) refuse(text);
  throw Error(static_cast<ErrorCode>(header.code - kFirstError), text);
}

}  // namespace rig
}  // namespace thew
