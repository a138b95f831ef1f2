// SPDX-License-Identifier: Apache-2.0
#include "tools/render/program.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>

#include "tools/base/signals.h"

namespace thew::tools {

int run_program(const std::vector<std::string>& words) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid(), child = ::fork();
  if (child < 0) return kNotStarted;
  if (child == 0) {  // nothing that allocates: other threads may hold the heap's lock
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);  // or it would write on where we have been killed
    if (::getppid() != parent) ::_exit(1);
    const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(nowhere, stream);
    ::execvp(arguments[0], arguments.data());
    ::_exit(kNotFound);
  }
  int status = 0;
  for (bool told = false;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child || (ended < 0 && errno != EINTR)) break;
    if (interrupted() && !told) told = ::kill(child, SIGKILL) == 0;
    ::usleep(2000);
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

}  // namespace thew::tools
