// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/types.h"
#include "tools/base/command_options.h"

namespace thew {

/// Speed against accuracy of the scene's muscles, over a table of solver settings; `stability`:
/// maps of where each integrator fails instead.
ExitCode chart_command(const CommandOptions& options, bool stability);

}  // namespace thew
