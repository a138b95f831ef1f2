// SPDX-License-Identifier: Apache-2.0
#include "tools/base/large_stack.h"

#include <pthread.h>
#include <sys/resource.h>

namespace thew::tools {
namespace {

constexpr rlim_t kStack = rlim_t{8} << 20;  // bytes, what Linux gives unless told otherwise

struct Job {
  const std::function<int()>& work;
  int result = 0;
};

void* run(void* job) {
  Job& of = *static_cast<Job*>(job);
  of.result = of.work();
  return nullptr;
}

}  // namespace

int on_large_stack(const std::function<int()>& work) {
  rlimit limit{};
  if (::getrlimit(RLIMIT_STACK, &limit) != 0 || limit.rlim_cur >= kStack) return work();
  pthread_attr_t large;
  pthread_t thread{};
  Job job{work};
  ::pthread_attr_init(&large);
  ::pthread_attr_setstacksize(&large, kStack);
  ::pthread_setattr_default_np(&large);
  const bool started = ::pthread_create(&thread, &large, run, &job) == 0;
  ::pthread_attr_destroy(&large);
  if (!started) return work();
  ::pthread_join(thread, nullptr);
  return job.result;
}

}  // namespace thew::tools
