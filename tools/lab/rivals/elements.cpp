// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/elements.h"

#include <memory>

namespace thew::tools {

FemBody elements_of(const RivalBody& body, const FemMaterial& material) {
  FemBody out;
  out.material = material;
  out.rest = body.rest;
  for (const Tetrahedron& t : body.tetrahedra) {
    out.elements.insert(out.elements.end(), t.begin(), t.end());
  }
  for (size_t i = 0; i < body.rest.size(); ++i) {
    out.surface.push_back(body.surface[i] && !body.driven[i]);
    for (int k = 0; k < 3; ++k) out.fixed.push_back(body.driven[i]);
  }
  prepare(out);
  return out;
}

Stepper element_stepper(const RivalBody& body, const ElementSetting& setting) {
  const auto fem = std::make_shared<FemBody>(elements_of(body, setting.material));
  return [fem, setting](const Surroundings& around, double time, double h, RivalBody& now) {
    drive_nodes(around, time, h, now);
    for (size_t i = 0; i < now.x.size(); ++i) {
      fem->x[i] = to_vec(now.x[i]);
      fem->v[i] = to_vec(now.v[i]);
    }
    FemStep step;
    step.h = h;
    step.damping = setting.drag;
    step.direct = setting.direct;
    step.iterations = setting.iterations;
    step.tolerance = 1e-5;
    step.residual = 1e-2;  // Newton's next iteration corrects it, for a third of the time
    step.firmness = kFirmness;
    if (around.beyond) {
      step.obstacle = [&](const Vec3& p) { return around.beyond(time, p); };
    }
    solve_step(*fem, step);
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (now.driven[i]) continue;
      now.x[i] = to_point(fem->x[i]);
      now.v[i] = to_point(fem->v[i]);
    }
  };
}

}  // namespace thew::tools
