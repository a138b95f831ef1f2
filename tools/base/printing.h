// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "rig/types.h"

namespace thew::tools {

/// All that goes to standard output goes through here: Error(kOutput) where it cannot take it all.
void print(std::string_view text);
/// A document whose members are indented by `indent` blanks; what is not UTF-8 in it is replaced,
/// as a name of a file or of a scene may be.
std::string json_text(const nlohmann::ordered_json& document, int indent);
void print_json(const nlohmann::ordered_json& document);

/// What an error says, "FILE:LINE: what is wrong; the next move", taken apart.
struct ErrorParts {
  std::string file;  ///< "" where the error is of no file
  int line = 0;      ///< 0: none is named
  std::string message, next;
};
/// A file's name may hold ": " and "; ": what is one of the command line's `words`, below one of
/// them, or there on the disk is known whole; of other names only the plain ones are found.
ErrorParts split_error(const std::string& message, const std::vector<std::string>& words);
/// {"error": {"code", "file", "line", "message", "next"}}, null where there is none.
nlohmann::ordered_json error_as_json(ErrorCode code, const ErrorParts& parts);

}  // namespace thew::tools
