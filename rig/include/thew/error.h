// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <stdexcept>
#include <string>

namespace thew {

/// Whose fault an error is, and so what to do about it.
enum class ErrorCode {
  kUsage,   ///< what was asked for, or the scene: mend it
  kInput,   ///< a file that is read
  kOutput,  ///< a file or folder that cannot be written
  kSolver,  ///< the solver could not go on
  kRetry,   ///< interrupted, locked, or short of memory: try again
};

/// The one exception of Thew. The message is "place: what is wrong with what; the next move".
class Error : public std::runtime_error {
 public:
  Error(ErrorCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ErrorCode code() const { return code_; }

 private:
  ErrorCode code_;
};

}  // namespace thew
