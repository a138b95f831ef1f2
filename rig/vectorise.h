// SPDX-License-Identifier: Apache-2.0
#pragma once

// A function marked THEW_VECTORISED is compiled for several vector widths, and the loader chooses
// one. The bytes of its results do not depend on the choice, because kernels sum in a fixed number
// of lanes and contraction to fused multiply-add is off. Builds with sanitizers use one plain
// version, because sanitizers do not support the loader's choice (ifunc). So do builds for one
// processor with AVX (-march=native), because g++ 12 cannot compile a clone for a narrower one.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(THEW_SANITIZED) && \
    !defined(__AVX__)
#define THEW_VECTORISED \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
// A function marked THEW_WIDE uses vectors of 64 bytes; call it only where THEW_HAS_WIDE.
#define THEW_WIDE __attribute__((target("arch=x86-64-v4")))
#define THEW_HAS_WIDE __builtin_cpu_supports("x86-64-v4")
#else
#define THEW_VECTORISED
#define THEW_WIDE
#define THEW_HAS_WIDE false
#endif
