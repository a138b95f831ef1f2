// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace thew::tools {

/// For what is embedded in a page.
std::string base64(const std::string& bytes);

}  // namespace thew::tools
