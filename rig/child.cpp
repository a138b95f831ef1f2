// SPDX-License-Identifier: Apache-2.0
#include "rig/child.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace thew {
namespace {

constexpr std::uint64_t kMemory = std::uint64_t{1} << 30;  // bytes
constexpr std::uint64_t kMemoryPerByte = 8;
constexpr unsigned kSeconds = 2;
constexpr std::uint64_t kBytesPerSecond = std::uint64_t{8} << 20;
constexpr int kClockOverProcessor = 5;

constexpr std::uint64_t kMagic = 0x7265776e61776874;  // "thwanwer"
constexpr std::uint64_t kOtherFailure = 256;          // beside the exit codes
constexpr int kOutOfMemory = 12;                      // the child's own exit code

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

// Bytes of address space that the process has; 0 where the system does not tell.
std::uint64_t address_space() {
  unsigned long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%lu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return std::uint64_t{pages} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, rlim_t most) {
  rlimit now{};
  ::getrlimit(static_cast<__rlimit_resource>(resource), &now);
  now.rlim_cur = std::min(most, now.rlim_max);
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

// It dies with its parent, says nothing, leaves no core, and is no place for anyone's handlers.
// Returns the socket, clear of the standard streams, one of which it is where the parent has closed
// its own.
int become_child(pid_t parent, std::uint64_t memory, int socket) {
  const int clear = ::fcntl(socket, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU}) {
    std::signal(signal, SIG_DFL);
  }
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
  limit(RLIMIT_CORE, 0);
  if (const std::uint64_t now = address_space()) limit(RLIMIT_AS, now + memory);
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
  std::uint64_t bytes = 0;
  while (receive_all(socket, &bytes, sizeof bytes)) {
    allow_seconds(seconds);
    std::string text;
    std::uint64_t code = 0;
    try {
      std::string request(bytes, '\0');
      if (!receive_all(socket, request.data(), bytes)) break;
      text = answer(request);
    } catch (const Error& error) {
      code = static_cast<std::uint64_t>(error.code());
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

}  // namespace

Child::Child(std::filesystem::path file, std::string advice, const Answer& answer)
    : file_(std::move(file)), advice_(std::move(advice)) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file_, error);
  memory_ = kMemory + (error ? 0 : kMemoryPerByte * size);
  seconds_ = kSeconds + static_cast<unsigned>(error ? 0 : size / kBytesPerSecond);
  const auto fail_to_start = [&](const char* what) {
    throw Error(ExitCode::kRetry, file_.string() + ": cannot start a process to read it in: " +
                                      what + "; end some processes and run again");
  };
  std::array<int, 2> sockets{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, sockets.data()) != 0) {
    fail_to_start(std::strerror(errno));
  }
  const pid_t parent = ::getpid();
  process_ = ::fork();
  if (process_ == 0) {
    ::close(sockets[0]);
    serve(become_child(parent, memory_, sockets[1]), seconds_, answer);
  }
  const int failure = errno;
  ::close(sockets[1]);
  socket_ = sockets[0];
  if (process_ > 0) return;
  ::close(socket_);
  fail_to_start(std::strerror(failure));
}

Child::~Child() {
  if (socket_ >= 0) ::close(socket_);
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  while (::waitpid(process_, nullptr, 0) < 0 && errno == EINTR) continue;
}

void Child::refuse(const std::string& what) const {
  throw Error(ExitCode::kInput, file_.string() + ": " + what + "; " + advice_);
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
  if (signal != 0) refuse(std::string("its reader crashed (") + ::strsignal(signal) + ")");
  if (WIFEXITED(status) && WEXITSTATUS(status) == kOutOfMemory) {
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

std::string Child::ask(std::string_view request) {
  if (process_ < 0) refuse("its reader has ended");
  const std::uint64_t bytes = request.size();
  if (!send_all(socket_, &bytes, sizeof bytes) ||
      !send_all(socket_, request.data(), request.size())) {
    fail();
  }
  Header header{};
  receive(&header, sizeof header);
  if (header.magic != kMagic || header.bytes > memory_ || header.code > kOtherFailure) {
    refuse("its reader sent nonsense");
  }
  std::string text(header.bytes, '\0');
  receive(text.data(), text.size());
  if (header.code == 0) return text;
  if (header.code == kOtherFailure) refuse(text);
  throw Error(static_cast<ExitCode>(header.code), text);
}

}  // namespace thew
