// SPDX-License-Identifier: Apache-2.0
#include "rig/limits.h"

#include "rig/text.h"

namespace thew::rig {

bool is_bounded(const Vec3& p, double limit) { return (p.array().abs() <= limit).all(); }

void check_position(const Vec3& p, const std::string& where, const std::string& next) {
  if (is_bounded(p)) return;
  throw Error(ErrorCode::kInput,
              where +
                  (p.allFinite() ? " lies at " + point_text(p) + " m, farther than 10 km; "
                                 : " lies where no number is; ") +
                  next);
}

}  // namespace thew::rig
