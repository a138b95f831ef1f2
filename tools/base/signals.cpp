// SPDX-License-Identifier: Apache-2.0
#include "tools/base/signals.h"

#include <atomic>
#include <csignal>

#include "rig/types.h"

namespace thew::tools {
namespace {

std::atomic<bool> signal_seen{false};  // read by any thread

}  // namespace

bool interrupted() { return signal_seen; }

void stop_if_interrupted() {
  if (interrupted()) throw Error(ErrorCode::kRetry, "interrupted; run again");
}

void listen_for_signals() {
  const auto handler = [](int) { signal_seen = true; };
  std::signal(SIGTERM, handler);
  std::signal(SIGINT, handler);
  std::signal(SIGXFSZ, SIG_IGN);  // a file that may not grow is an error of the write
  std::signal(SIGPIPE, SIG_IGN);  // and so is a reader that has gone
  sigset_t ours;
  sigemptyset(&ours);
  sigaddset(&ours, SIGTERM);
  sigaddset(&ours, SIGINT);
  sigprocmask(SIG_UNBLOCK, &ours, nullptr);  // whoever started us may have blocked them
}

}  // namespace thew::tools
