// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "sim/cache/cache.h"
#include "tools/base/command_options.h"

namespace thew::tools {

enum class BakeStart { kAnew, kGoOn, kComplete };

/// What a bake does with what stands in its folder. Completed frames of the same bake are gone on
/// from, or complete, with --resume and without (which says so); those of another are never thrown
/// away but with --overwrite: Error, kUsage with --resume, else kOutput, that says what differs.
/// Files that are not Thew's: sim/cache/own_files.h. Makes the folder where it is missing.
BakeStart look_into_folder(const CommandOptions& options, const BakeInfo& wanted);

/// Whether report.json and report.html are there and of these pictures (Pictures::key).
bool has_report(const std::filesystem::path& folder, const std::string& pictures);
void list_report(const std::filesystem::path& folder, const std::string& pictures);

}  // namespace thew::tools
