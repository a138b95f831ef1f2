// SPDX-License-Identifier: Apache-2.0
#include "tools/export_formats.h"
namespace thew {
Exported export_alembic(const Shot&, const std::filesystem::path& file) {
  throw Error(ExitCode::kUsage, file.string() + ": not yet");
}
}  // namespace thew
