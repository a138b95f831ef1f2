// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/fit/arm.h"
#include "tools/fit/new_options.h"

namespace thew::tools {

/// The character in metres, its arms, and what its file warns of. What the user said of its unit
/// stands; else a humerus that no person has is made an adult's, which one of the notes says.
/// `scale` becomes what the scene is to say.
Character read_in_metres(const NewOptions& options, double& scale, std::vector<ArmBodies>& arms,
                         std::vector<std::string>& notes, std::vector<std::string>& warnings);

}  // namespace thew::tools
