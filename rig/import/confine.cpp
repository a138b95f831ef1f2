// SPDX-License-Identifier: Apache-2.0
#include "rig/import/confine.h"

#include <seccomp.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>

namespace thew::rig {
namespace {

// Calls that a reader needs: to read and write descriptors that are open, to get memory, and to
// end.
constexpr const char* kAllowed[] = {"read",           "readv",           "pread64",
                                    "preadv",         "write",           "writev",
                                    "lseek",          "close",           "recvfrom",
                                    "recvmsg",        "sendto",          "sendmsg",
                                    "poll",           "ppoll",           "brk",
                                    "mmap",           "munmap",          "mremap",
                                    "mprotect",       "madvise",         "futex",
                                    "sched_yield",    "getrandom",       "sched_getaffinity",
                                    "clock_gettime",  "clock_nanosleep", "nanosleep",
                                    "gettimeofday",   "getpid",          "gettid",
                                    "getrusage",      "pause",           "rt_sigaction",
                                    "rt_sigprocmask", "rt_sigreturn",    "sigaltstack",
                                    "exit",           "exit_group",      "restart_syscall"};

// Calls that end the process. Others that are not allowed fail with EPERM, because libraries make
// some harmlessly, such as looking for a file or asking for the time zone.
constexpr const char* kEnds[] = {
    "socket",         "socketpair", "connect",          "bind",
    "listen",         "accept",     "accept4",          "fork",
    "vfork",          "clone",      "clone3",           "execve",
    "execveat",       "ptrace",     "process_vm_readv", "process_vm_writev",
    "kill",           "tkill",      "pidfd_open",       "pidfd_send_signal",
    "io_uring_setup", "bpf",        "unshare",          "setns",
    "mount",          "keyctl",     "userfaultfd"};

// Adds a rule for a call by its name. Machines lack some calls, such as `fork` or `poll`; these
// need no rule.
template <typename... Arguments>
bool rule(scmp_filter_ctx filter, unsigned action, const char* name, Arguments... arguments) {
  const int call = seccomp_syscall_resolve_name(name);
  if (call == __NR_SCMP_ERROR) return true;
  return seccomp_rule_add(filter, action, call, sizeof...(arguments), arguments...) == 0;
}

bool fill(scmp_filter_ctx filter) {
  bool good = true;
  for (const char* name : kAllowed) good = rule(filter, SCMP_ACT_ALLOW, name) && good;
  for (const char* name : kEnds) good = rule(filter, SCMP_ACT_KILL_PROCESS, name) && good;
  // abort() sends a signal to its own process, and a reader sets its limit of CPU seconds anew for
  // each answer.
  const auto self = static_cast<scmp_datum_t>(::getpid());
  good = rule(filter, SCMP_ACT_ALLOW, "tgkill", SCMP_A0(SCMP_CMP_EQ, self)) && good;
  return rule(filter, SCMP_ACT_ALLOW, "prlimit64", SCMP_A0(SCMP_CMP_EQ, 0),
              SCMP_A1(SCMP_CMP_EQ, RLIMIT_CPU)) &&
         good;
}

}  // namespace

bool confine_process() {
  const scmp_filter_ctx filter = seccomp_init(SCMP_ACT_ERRNO(EPERM));
  if (!filter) return false;
  const bool done = fill(filter) && seccomp_load(filter) == 0;
  seccomp_release(filter);
  return done;
}

}  // namespace thew::rig
