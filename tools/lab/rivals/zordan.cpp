// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/zordan.h"

#include <memory>

namespace thew::tools {

Stepper zordan_stepper(const RivalBody& body, double drag, double modulus) {
  const auto springs = std::make_shared<const SurfaceSprings>(prepare_springs(body, drag));
  return [springs, modulus, rest = volume_of(body), f = Points(), gradient = Points()](
             const Surroundings& around, double time, double h, RivalBody& now) mutable {
    spring_forces(*springs, now, f, modulus > 0.0 ? &gradient : nullptr);
    if (modulus > 0.0) {
      double thrice = 0.0;  // V = x . dV/dx / 3
      for (size_t i = 0; i < f.size(); ++i) thrice += dot(now.x[i] - now.x[0], gradient[i]);
      const double pressure = modulus * (1.0 - thrice / (3.0 * rest));
      for (size_t i = 0; i < f.size(); ++i) f[i] += pressure * gradient[i];
    }
    free_step(around, time, h, springs->drag, f, now);
  };
}

}  // namespace thew::tools
