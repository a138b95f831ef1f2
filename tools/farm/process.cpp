// SPDX-License-Identifier: Apache-2.0
#include "tools/farm/process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "rig/types.h"
#include "sim/cache/file_io.h"
#include "tools/base/signals.h"

namespace thew::tools {

Process start(const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const sim::Descriptor out(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC);
  const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child == 0) {  // nothing that allocates: other threads may hold the heap's lock
    ::prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (::getppid() != parent) ::_exit(1);
    ::dup2(nothing, STDIN_FILENO);
    ::dup2(out.value(), STDOUT_FILENO);
    ::dup2(out.value(), STDERR_FILENO);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);  // as the shell does
  }
  ::close(nothing);
  if (child < 0) {
    throw Error(ErrorCode::kRetry, words[0] +
                                       ": cannot be started; allow more processes or memory "
                                       "(ulimit -a) and run again");
  }
  return {child};
}

std::optional<Ended> look_at(const Process& process) {
  int status = 0;
  struct rusage usage {};
  if (::wait4(process.id, &status, WNOHANG, &usage) == 0) return std::nullopt;
  return Ended{WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status),
               static_cast<double>(usage.ru_maxrss) / 1024.0};
}

Ended wait_for(const Process& process) {
  for (bool told = false;;) {
    if (const auto ended = look_at(process)) return *ended;
    if (interrupted() && !told) told = ::kill(process.id, SIGTERM) == 0;
    ::usleep(5000);
  }
}

}  // namespace thew::tools
