// SPDX-License-Identifier: Apache-2.0
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdio>

#include "rig/types.h"
#include "sim/cache/file_io.h"
#include "tools/base/exit_code.h"
#include "tools/base/progress.h"
#include "tools/base/signals.h"
#include "tools/farm/engines.h"
#include "tools/farm/process.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;

constexpr int kTries = 3;  // of a task that ends with 75
constexpr int kRetryCode = 75;
constexpr int kTold = 1;  // of the report

enum class State { kWaits, kRuns, kDone, kFailed, kCancelled };

struct Running {
  int task;
  Process process;
  std::chrono::steady_clock::time_point since;
};

/// The tasks and how far they are.
struct Pool {
  const Graph& graph;
  fs::path program, logs;
  int at_once;
  double memory_mib;  ///< of the machine
  std::vector<State> states;
  std::vector<int> tries;
  std::vector<Running> running;
  int first_failure = -1, code = 0, failed = 0, cancelled = 0, over = 0;
  bool told = false;

  const Task& task(int i) const { return graph.tasks[static_cast<std::size_t>(i)]; }
  State& state(int i) { return states[static_cast<std::size_t>(i)]; }
  fs::path log_of(int i) const { return logs / (name_of(task(i)) + ".log"); }
  std::vector<std::string> words_of(int i) const {
    std::vector<std::string> words = task(i).words;
    words.insert(words.begin(), program.string());
    return words;
  }

  bool is_over(int i) {
    return state(i) == State::kDone || state(i) == State::kFailed || state(i) == State::kCancelled;
  }
  bool fits(int i) const {
    if (running.empty()) return true;
    double taken = task(i).memory_mib;
    for (const Running& one : running) taken += task(one.task).memory_mib;
    return static_cast<int>(running.size()) < at_once && taken <= memory_mib;
  }
  bool is_ready(int i) {
    const std::vector<int>& after = task(i).after;
    const bool is_report = task(i).bake.empty();
    return std::all_of(after.begin(), after.end(), [&](int other) {
      return is_report ? is_over(other) : state(other) == State::kDone;
    });
  }
  bool is_lost(int i) {
    const std::vector<int>& after = task(i).after;
    return !task(i).bake.empty() && std::any_of(after.begin(), after.end(), [&](int other) {
      return state(other) == State::kFailed || state(other) == State::kCancelled;
    });
  }

  // In the graph's order, so that a bake is cancelled before what waits for it is looked at.
  void start_ready() {
    for (int i = 0; i < static_cast<int>(graph.tasks.size()); ++i) {
      if (state(i) != State::kWaits) continue;
      if (is_lost(i)) {
        state(i) = State::kCancelled;
        ++cancelled;
        ++over;
      } else if (is_ready(i) && fits(i)) {
        running.push_back({i, start(words_of(i), log_of(i)), std::chrono::steady_clock::now()});
        state(i) = State::kRuns;
      }
    }
  }

  void end(const Running& one, const Ended& ended) {
    const int i = one.task;
    if (ended.code == kRetryCode && ++tries[static_cast<std::size_t>(i)] < kTries) {
      state(i) = State::kWaits;
      return;
    }
    ++over;
    // A report that ends with 1 is written, and names bakes that failed or miss a bound.
    const bool is_told = task(i).bake.empty() && ended.code == kTold;
    state(i) = ended.code == 0 || is_told ? State::kDone : State::kFailed;
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - one.since;
    std::fprintf(stderr, "thew: %d of %zu: %s, %s\n", over, graph.tasks.size(),
                 name_of(task(i)).c_str(), duration(took.count()).c_str());
    told = told || is_told;
    if (ended.code == 0 || is_told) return;
    ++failed;
    if (first_failure < 0 || i < first_failure) {
      first_failure = i;
      code = ended.code;
    }
    std::fprintf(stderr, "thew: %s ended with %d; %s says why; once more: %s\n",
                 name_of(task(i)).c_str(), ended.code, log_of(i).c_str(),
                 command_text(words_of(i)).c_str());
  }

  void collect() {
    std::vector<Running> left;
    for (const Running& one : running) {
      if (const auto ended = look_at(one.process)) {
        end(one, *ended);
      } else {
        left.push_back(one);
      }
    }
    running = std::move(left);
  }
};

[[noreturn]] void stop(Pool& pool) {
  for (const Running& one : pool.running) ::kill(one.process.id, SIGTERM);
  for (const Running& one : pool.running) wait_for(one.process);
  throw Error(ErrorCode::kRetry,
              "interrupted; run again, and it goes on with what is not complete");
}

ErrorCode code_of(int code) {
  for (const ErrorCode one :
       {ErrorCode::kUsage, ErrorCode::kInput, ErrorCode::kOutput, ErrorCode::kRetry}) {
    if (static_cast<int>(exit_code_of(one)) == code) return one;
  }
  return ErrorCode::kSolver;
}

}  // namespace

ExitCode run_here(const Graph& graph, const fs::path& program, const fs::path& logs, int threads) {
  sim::create_folders(logs);
  const std::size_t count = graph.tasks.size();
  Pool pool{graph,
            program,
            logs,
            std::max(1, threads / graph.threads),
            static_cast<double>(::sysconf(_SC_PHYS_PAGES)) *
                static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1048576.0,
            std::vector<State>(count, State::kWaits),
            std::vector<int>(count, 0),
            {}};
  while (pool.over < static_cast<int>(count)) {
    if (interrupted()) stop(pool);
    pool.start_ready();
    ::usleep(5000);
    pool.collect();
  }
  if (pool.failed == 0) return pool.told ? ExitCode::kDifferent : ExitCode::kDone;
  throw Error(code_of(pool.code), std::to_string(pool.failed) + " of " + std::to_string(count) +
                                      " tasks failed and " + std::to_string(pool.cancelled) +
                                      " waited for them; mend what the logs say and run again");
}

}  // namespace thew::tools
