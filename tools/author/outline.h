// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "rig/types.h"

namespace thew::tools {

/// Signed distance (m) from the outline of the limb, near enough close to it; negative
/// inside. In the humerus' frame, the arm hanging.
double limb_level(const Vec3& p);

}  // namespace thew::tools
