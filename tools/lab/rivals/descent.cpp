// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/rivals/descent.h"

#include <Eigen/LU>
#include <memory>

namespace thew::tools {
namespace {

Mat3 deformation(const DescentBody& body, int e, const Points& x) {
  const Tetrahedron& t = body.tetrahedra[e];
  Mat3 out;
  for (int k = 0; k < 3; ++k) out.col(k) = to_vec(x[t[k + 1]] - x[t[0]]);
  return out * body.rest_inverse[e];
}

// psi = shear/2 F:F + penalty/2 (J - 1)^2 - shear (J - 1), as fem.h has it.
double density_of(const FemMaterial& m, const Mat3& f) {
  const double change = f.determinant() - 1.0;
  return 0.5 * m.shear * f.squaredNorm() + change * (0.5 * m.penalty * change - m.shear);
}

Mat3 cofactor(const Mat3& f) {
  Mat3 out;
  for (int k = 0; k < 3; ++k) out.col(k) = f.col((k + 1) % 3).cross(f.col((k + 2) % 3));
  return out;
}

}  // namespace

DescentBody descent_body(const RivalBody& body, const FemMaterial& material) {
  DescentBody out{material, body.tetrahedra, {}, {}, {}};
  out.at.resize(body.rest.size());
  const TetMesh rest{body.rest, {}};
  for (size_t e = 0; e < body.tetrahedra.size(); ++e) {
    const Tetrahedron& t = body.tetrahedra[e];
    Mat3 sides;
    for (int k = 0; k < 3; ++k) sides.col(k) = body.rest[t[k + 1]] - body.rest[t[0]];
    out.rest_inverse.push_back(sides.inverse());
    out.rest_volume.push_back(signed_volume(rest, t));
    for (int k = 0; k < 4; ++k) out.at[t[k]].push_back({static_cast<int>(e), k});
  }
  return out;
}

double descent_energy(const DescentBody& body, const RivalBody& now, const Points& start,
                      const Points& guess, double h, double drag) {
  double sum = 0.0;
  for (size_t i = 0; i < now.x.size(); ++i) {
    const Point a = now.x[i] - guess[i], b = now.x[i] - start[i];
    sum += 0.5 * now.mass[i] * (dot(a, a) / (h * h) + drag / h * dot(b, b));
  }
  for (size_t e = 0; e < body.tetrahedra.size(); ++e) {
    sum += body.rest_volume[e] *
           density_of(body.material, deformation(body, static_cast<int>(e), now.x));
  }
  return sum;
}

void descend(const DescentPass& pass, RivalBody& now) {
  const DescentBody& body = pass.body;
  const FemMaterial& m = body.material;
  const double inertia = 1.0 / (pass.h * pass.h), drag = pass.drag / pass.h;
  for (size_t i = 0; i < now.x.size(); ++i) {
    if (now.driven[i]) continue;
    Vec3 slope = now.mass[i] *
                 to_vec(inertia * (now.x[i] - pass.guess[i]) + drag * (now.x[i] - pass.start[i]));
    Mat3 hessian = now.mass[i] * (inertia + drag) * Mat3::Identity();
    for (const auto& [e, corner] : body.at[i]) {
      // dF/dx_i = e b^T: b is a row of the inverse of the rest sides, or minus their sum.
      const Mat3& inverse = body.rest_inverse[e];
      const Vec3 b =
          corner > 0 ? Vec3(inverse.row(corner - 1)) : Vec3(-inverse.colwise().sum().transpose());
      const Mat3 f = deformation(body, e, now.x);
      const Vec3 dj = cofactor(f) * b;
      const double pressure = m.penalty * (f.determinant() - 1.0) - m.shear;
      slope += body.rest_volume[e] * (m.shear * f * b + pressure * dj);
      hessian += body.rest_volume[e] *
                 (m.shear * b.squaredNorm() * Mat3::Identity() + m.penalty * dj * dj.transpose());
    }
    if (pass.beyond && now.surface[i]) {
      const Vec3 depth = pass.beyond(to_vec(now.x[i]));
      if (!depth.isZero(0.0)) {
        const Vec3 n = depth.normalized();
        slope += kFirmness * depth;
        hessian += kFirmness * n * n.transpose();
      }
    }
    now.x[i] -= to_point(hessian.inverse() * slope);
  }
}

Stepper descent_stepper(const RivalBody& start, const FemMaterial& material, double drag,
                        int iterations) {
  const auto body = std::make_shared<const DescentBody>(descent_body(start, material));
  return
      [body, drag, iterations](const Surroundings& around, double time, double h, RivalBody& now) {
        Points before = now.x, guess = now.x;
        drive_nodes(around, time, h, now);
        for (size_t i = 0; i < now.x.size(); ++i) {
          guess[i] += h * now.v[i];
          if (!now.driven[i]) now.x[i] = guess[i];
        }
        std::function<Vec3(const Vec3&)> beyond;
        if (around.beyond) beyond = [&](const Vec3& p) { return around.beyond(time, p); };
        for (int k = 0; k < iterations; ++k) descend({*body, beyond, before, guess, h, drag}, now);
        for (size_t i = 0; i < now.x.size(); ++i) {
          if (!now.driven[i]) now.v[i] = 1.0 / h * (now.x[i] - before[i]);
        }
      };
}

}  // namespace thew::tools
