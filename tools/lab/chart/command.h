// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/base/command_options.h"

namespace thew::tools {

/// Speed against accuracy of the scene's muscles, over a table of solver settings.
ExitCode chart_command(const CommandOptions& options);

}  // namespace thew::tools
