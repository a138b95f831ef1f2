// SPDX-License-Identifier: Apache-2.0
//
// Bodies of the paper that no formula of a surface gives: fields of capsules and rings, blended.
#include <algorithm>
#include <cmath>

#include "tools/lab/paper/shapes.h"

namespace thew::tools {
namespace {

using Field = std::function<double(const Vec3&)>;

// Two distances blended over `width` (m): a polynomial, so the same bytes everywhere.
double blend(double a, double b, double width) {
  const double h = std::max(width - std::abs(a - b), 0.0) / width;
  return std::min(a, b) - 0.25 * h * h * width;
}

struct Limb {
  Vec3 from, to;
  double from_radius, to_radius;
};

double distance_to(const Limb& limb, const Vec3& p) {
  const Vec3 along = limb.to - limb.from;
  const double t = std::clamp((p - limb.from).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (p - limb.from - t * along).norm() - (1.0 - t) * limb.from_radius - t * limb.to_radius;
}

// Relaxed along the surface and put back on it by Newton steps along the field's gradient.
TriMesh smoothed(TriMesh mesh, const Field& field, int passes) {
  const double step = 1e-5;
  std::vector<Vec3>& x = mesh.vertices;
  const auto settle = [&](Vec3& p) {
    for (int i = 0; i < 3; ++i) {
      Vec3 slope;
      for (int k = 0; k < 3; ++k) {
        const Vec3 d = step * Vec3::Unit(k);
        slope[k] = (field(p + d) - field(p - d)) / (2.0 * step);
      }
      p -= field(p) / slope.squaredNorm() * slope;
    }
  };
  for (int pass = 0; pass < passes; ++pass) {
    std::vector<Vec3> sum(x.size(), Vec3::Zero());
    std::vector<int> count(x.size(), 0);
    for (const Triangle& t : mesh.triangles) {
      for (int k = 0; k < 3; ++k) {
        sum[t[k]] += x[t[(k + 1) % 3]];
        ++count[t[k]];
      }
    }
    const std::vector<Vec3> normals = vertex_normals(mesh);
    for (size_t i = 0; i < x.size(); ++i) {
      const Vec3 pull = sum[i] / count[i] - x[i];
      x[i] += 0.5 * (pull - pull.dot(normals[i]) * normals[i]);
      settle(x[i]);
    }
  }
  return mesh;
}

TriMesh from_field(const Field& field, const Vec3& low, const Vec3& high, double cell,
                   int triangles) {
  TriMesh mesh = smoothed(polygonise(field, low, high, cell), field, 3);
  return smoothed(with_count(mesh, triangles), field, 12);
}

}  // namespace

TriMesh paper_two_rings(int triangles) {
  const Field field = [](const Vec3& p) {
    const auto ring = [&](double x) {
      const double out = std::sqrt((p.x() - x) * (p.x() - x) + p.z() * p.z()) - 0.055;
      return std::sqrt(out * out + p.y() * p.y()) - 0.024;
    };
    return blend(ring(-0.062), ring(0.062), 0.02);
  };
  return from_field(field, {-0.155, -0.035, -0.09}, {0.155, 0.035, 0.09}, 0.0052, triangles);
}

TriMesh paper_cow(int triangles) {
  std::vector<Limb> limbs = {
      {{-0.34, 0.02, 0}, {0.30, 0.0, 0}, 0.20, 0.22},     // trunk
      {{-0.36, 0.10, 0}, {-0.60, 0.27, 0}, 0.13, 0.085},  // neck
      {{-0.60, 0.27, 0}, {-0.78, 0.17, 0}, 0.10, 0.058},  // head
      {{0.46, 0.12, 0}, {0.55, -0.22, 0}, 0.03, 0.022},   // tail
      {{0.20, -0.19, 0}, {0.26, -0.22, 0}, 0.075, 0.06},  // udder
  };
  for (double side : {-1.0, 1.0}) {
    limbs.push_back({{-0.62, 0.33, 0.07 * side}, {-0.60, 0.37, 0.17 * side}, 0.03, 0.022});  // ear
    limbs.push_back({{-0.62, 0.36, 0.05 * side}, {-0.65, 0.46, 0.09 * side}, 0.026, 0.016});
    for (double x : {-0.31, 0.34}) {  // legs
      limbs.push_back({{x, -0.08, 0.11 * side}, {x - 0.02, -0.36, 0.12 * side}, 0.10, 0.056});
      limbs.push_back({{x - 0.02, -0.36, 0.12 * side}, {x, -0.62, 0.12 * side}, 0.056, 0.048});
    }
  }
  const Field field = [limbs](const Vec3& p) {
    double d = 1e9;
    for (const Limb& limb : limbs) d = blend(d, distance_to(limb, p), 0.06);
    return d;
  };
  return from_field(field, {-0.92, -0.72, -0.36}, {0.68, 0.56, 0.36}, 0.0165, triangles);
}

TriMesh paper_finger(int triangles) {
  const Limb limb{{-0.035, 0, 0}, {0.035, 0, 0}, 0.0085, 0.0075};
  const Field field = [limb](const Vec3& p) { return distance_to(limb, p); };
  return from_field(field, {-0.046, -0.011, -0.011}, {0.046, 0.011, 0.011}, 0.00113, triangles);
}

}  // namespace thew::tools
