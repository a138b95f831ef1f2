// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>

namespace thew::tools {

/// Runs `work`, which throws nothing, and gives back what it returns. Where the limit of stacks is
/// small (ulimit -s) it runs in a thread with a stack of 8 MiB, as do all threads from then on:
/// Mesa's compilers and assimp's parsers know no limit of their own.
int on_large_stack(const std::function<int()>& work);

}  // namespace thew::tools
