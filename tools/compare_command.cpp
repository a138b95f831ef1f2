// SPDX-License-Identifier: Apache-2.0
#include <cstdio>

#include "sim/durable_file.h"
#include "tools/commands.h"
#include "tools/options.h"

namespace thew {

ExitCode compare_command(const std::filesystem::path& expected, const std::filesystem::path& actual,
                         const CommandOptions& options, CompareOptions limits) {
  if (!options.frames.empty()) limits.frames = parse_frames(options.frames);
  const Comparison comparison = compare(expected, actual, limits);
  if (!options.out.empty()) write_durably(options.out, comparison_as_html(comparison));
  std::printf("%s", options.json ? (comparison_as_json(comparison) + "\n").c_str()
                                 : comparison_as_text(comparison).c_str());
  return comparison.same() ? ExitCode::kDone : ExitCode::kDifferent;
}

}  // namespace thew
