// SPDX-License-Identifier: Apache-2.0
#pragma once

// One function compiled for several vector widths and chosen at load time. The bytes of its results
// do not depend on the choice: kernels sum in fixed lanes, and contraction is off. Sanitizers
// cannot see through the loader's choice, so they get the plain build; so does who compiles for one
// wider processor (-march=native), from which g++ 12 cannot step back for a clone.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && !defined(THEW_SANITIZED) && \
    !defined(__AVX__)
#define THEW_VECTORISED \
  __attribute__((target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")))
// A function for processors that have vectors of 64 bytes, to be called on these alone.
#define THEW_WIDE __attribute__((target("arch=x86-64-v4")))
#define THEW_HAS_WIDE __builtin_cpu_supports("x86-64-v4")
#else
#define THEW_VECTORISED
#define THEW_WIDE
#define THEW_HAS_WIDE false
#endif
