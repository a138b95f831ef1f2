// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "thew/error.h"

namespace thew::tools {

/// What the command ends with.
enum class ExitCode {
  kDone = 0,
  kDifferent = 1,  ///< compared and different, or a quality bound not met
  kUsage = 2,      ///< command line or scene
  kInput = 3,      ///< a bad input file
  kOutput = 4,     ///< cannot write
  kSolver = 5,     ///< the solver could not go on
  kRetry = 75,     ///< interrupted or locked, try again with --resume
};

constexpr ExitCode exit_code_of(ErrorCode code) {
  switch (code) {
    case ErrorCode::kUsage:
      return ExitCode::kUsage;
    case ErrorCode::kInput:
      return ExitCode::kInput;
    case ErrorCode::kOutput:
      return ExitCode::kOutput;
    case ErrorCode::kSolver:
      return ExitCode::kSolver;
    case ErrorCode::kRetry:
      return ExitCode::kRetry;
  }
  return ExitCode::kSolver;
}

}  // namespace thew::tools
