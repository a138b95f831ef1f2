// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/promayon.h"

#include <memory>

namespace thew::tools {

Stepper promayon_stepper(const RivalBody& body, double drag, bool reaction) {
  const auto springs = std::make_shared<const SurfaceSprings>(prepare_springs(body, drag));
  return [springs, reaction, rest = volume_of(body), f = Points(), direction = Points()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    spring_forces(*springs, now, f, nullptr);
    free_step(around, time, h, springs->drag, f, now);
    const double s = volume_correction(around, time, rest, false, now, direction);
    for (size_t i = 0; i < now.x.size(); ++i) {
      now.x[i] += s * direction[i];
      if (reaction) now.v[i] += s / h * direction[i];
    }
  };
}

}  // namespace thew::tools
