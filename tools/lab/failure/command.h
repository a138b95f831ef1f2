// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/base/command_options.h"

namespace thew::tools {

/// Maps of where each method fails: stability.html, .csv, .json below options.out.
ExitCode stability_command(const CommandOptions& options);

}  // namespace thew::tools
