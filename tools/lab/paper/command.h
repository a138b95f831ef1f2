// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "tools/base/command_options.h"

namespace thew::tools {

class PaperReport;

/// All experiments.
void run_paper(PaperReport& report);
/// The paper's tables and figures, ours beside the printed ones; `cow`: a mesh to press instead.
ExitCode paper_command(const CommandOptions& options, bool quick, const std::filesystem::path& cow);

}  // namespace thew::tools
