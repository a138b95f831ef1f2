// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thew::tools {

/// The style sheet that our pages share: nothing in them comes from a network.
extern const char* const kPageStyle;

}  // namespace thew::tools
