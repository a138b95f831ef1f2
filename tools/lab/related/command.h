// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/base/command_options.h"

namespace thew::tools {

/// `thew paper --related`: the methods of the paper's related work beside it.
ExitCode related_command(const CommandOptions& options, bool quick);

}  // namespace thew::tools
