// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/base/command_options.h"

namespace thew::tools {

/// Measures all that results.h knows and writes the page to options.out, whatever stands there.
ExitCode results_command(const CommandOptions& options, bool quick);

}  // namespace thew::tools
