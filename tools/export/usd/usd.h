// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tools/base/output_file.h"
#include "tools/export/usd/usd_scene.h"

namespace thew::tools {

/// Both read the frames and write the whole layer, from where `out` is.
void write_usda(const Shot& shot, UsdLayer& layer, ExportFile& out);
void write_usdc(const Shot& shot, UsdLayer& layer, ExportFile& out);

}  // namespace thew::tools
