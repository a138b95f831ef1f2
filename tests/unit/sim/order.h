// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/solver/parallel.h"

namespace thew::tests {

// Loops over muscles and parts, run from their last index to their first: where one index reads
// what another writes, which no sanitizer sees as long as a lock lies between, the result is
// another. A test that includes this is linked with Parallel::run wrapped (CMakeLists.txt).

inline bool loops_run_backwards = false;

using LoopCall = void (*)(const void* work, int index);
void true_run(Parallel* parallel, int count, LoopCall call,
              const void* work) __asm__("__real__ZN4thew3sim8Parallel3runEiPFvPKviES3_");
void run_in_order(Parallel* parallel, int count, LoopCall call,
                  const void* work) __asm__("__wrap__ZN4thew3sim8Parallel3runEiPFvPKviES3_");

void run_in_order(Parallel* parallel, int count, LoopCall call, const void* work) {
  if (!loops_run_backwards) return true_run(parallel, count, call, work);
  for (int i = count - 1; i >= 0; --i) call(work, i);
}

}  // namespace thew::tests
