// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"

namespace thew::tests {

/// Bakes the scene of one muscle without pictures, unless told otherwise.
class OneMuscleCommand : public TempFolder {
 protected:
  OneMuscleCommand() {
    options.input = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml";
    options.out = folder / "out";
    options.progress = "none";
    options.threads = 1;
    options.pictures = false;
  }
  CommandOptions options;
};

}  // namespace thew::tests
