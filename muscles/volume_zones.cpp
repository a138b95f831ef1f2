// SPDX-License-Identifier: Apache-2.0
#include "muscles/volume_zones.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "muscles/volume.h"
#include "rig/math.h"
#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

// Least volume of a zone at rest, as a share of the whole; below it rounding would dominate the
// error.
constexpr double kMinZoneShare = 1e-4;
// How far the weight of a zone fades out on either side of a cut, as a share of its length. 0.25 is
// nearer to finite elements by a tenth where two bellies meet (muscles/notes.md), but needs finer
// meshes than those of the arm.
constexpr double kOverlap = 0.5;

VolumeZones::Cut make_cut(const TriMesh& rest, const std::vector<double>& along, int cut,
                          int count) {
  VolumeZones::Cut out;
  std::vector<double> before;
  for (double u : along) {
    before.push_back(1.0 - smoothstep((cut - kOverlap) / count, (cut + kOverlap) / count, u));
  }
  // A node counts by its surface area, and most in the middle of the section.
  std::vector<double> centre(along.size(), 0.0);
  double sum = 0.0;
  for (int t = 0; t < static_cast<int>(rest.triangles.size()); ++t) {
    const auto& [i, j, k] = rest.triangles[t];
    const std::vector<Vec3>& x = rest.vertices;
    const double area = (x[j] - x[i]).cross(x[k] - x[i]).norm();
    for (int node : {i, j, k}) {
      const double share = area * before[node] * (1.0 - before[node]);
      centre[node] += share;
      sum += share;
    }
    const double part = (before[i] + before[j] + before[k]) / 3.0;
    if (part > 0.0) out.parts.push_back({t, part});
  }
  if (!(sum > 0.0)) {
    throw std::invalid_argument("no node lies near the cut between zones " + std::to_string(cut) +
                                " and " + std::to_string(cut + 1) + " of " + std::to_string(count) +
                                "; give fewer zones, or a finer mesh");
  }
  for (int i = 0; i < static_cast<int>(centre.size()); ++i) {
    if (centre[i] > 0.0) out.section.push_back({i, centre[i] / sum});
  }
  return out;
}

[[gnu::always_inline]] inline Point centre_of(const VolumeZones::Cut& cut, const Points& x) {
  Point centre = {};
  for (const auto& [node, share] : cut.section) centre += share * x[node];
  return centre;
}

THEW_VECTORISED
double volume_before(const VolumeZones::Cut& cut, const Points& x,
                     const std::vector<Triangle>& triangles) {
  const Point centre = centre_of(cut, x);
  Point volume = {};
  for (const auto& [triangle, before] : cut.parts) {
    const auto& [i, j, k] = triangles[triangle];
    const Point a = x[i];
    volume += before * (a - centre) * cross3(x[j] - a, x[k] - a);
  }
  return sum3(volume) / 6.0;
}

// dL/dx1 = before (x2 - a) x (x3 - a) / 6 and cyclic. dL/da = -sum of before N / 6, with N the
// cross product of two edges; the nodes of the section take it by their shares of a.
THEW_VECTORISED
void gradient_before(const VolumeZones::Cut& cut, const Points& x,
                     const std::vector<Triangle>& triangles, Points& gradient) {
  const Point centre = centre_of(cut, x);
  gradient.assign(x.size(), Point{});
  Point pull = {};
  for (const auto& [triangle, before] : cut.parts) {
    const auto& [i, j, k] = triangles[triangle];
    const Point a = x[i] - centre, b = x[j] - centre, c = x[k] - centre;
    const double part = before / 6.0;
    const Point bc = part * cross3(b, c), ca = part * cross3(c, a), ab = part * cross3(a, b);
    gradient[i] += bc;
    gradient[j] += ca;
    gradient[k] += ab;
    pull += (bc + ca) + ab;  // N, whatever the origin
  }
  for (const auto& [node, share] : cut.section) gradient[node] -= share * pull;
}

}  // namespace

VolumeZones make_volume_zones(const TriMesh& rest, const std::vector<double>& along, int count) {
  VolumeZones zones;
  for (int cut = 1; cut < count; ++cut) zones.cuts.push_back(make_cut(rest, along, cut, count));
  volumes_before(zones, to_points(rest.vertices), rest.triangles, zones.rest_before);
  for (int j = 0; j < count; ++j) {
    const double volume = zones.rest_before[j] - (j > 0 ? zones.rest_before[j - 1] : 0.0);
    if (volume > kMinZoneShare * zones.rest_before.back()) continue;
    throw std::invalid_argument("zone " + std::to_string(j + 1) + " of " + std::to_string(count) +
                                " holds next to no volume at rest; give fewer zones");
  }
  return zones;
}

std::vector<double> longest_axis_coordinates(const TriMesh& mesh) {
  Vec3 centre = Vec3::Zero();
  for (const Vec3& p : mesh.vertices) centre += p / static_cast<double>(mesh.vertices.size());
  Mat3 spread = Mat3::Zero();
  for (const Vec3& p : mesh.vertices) spread += (p - centre) * (p - centre).transpose();
  const Mat3 axes = Eigen::SelfAdjointEigenSolver<Mat3>(spread).eigenvectors();
  Vec3 axis = axes.col(2);  // of the largest
  int main = 0;
  axis.cwiseAbs().maxCoeff(&main);
  if (axis[main] < 0.0) axis = -axis;
  double low = std::numeric_limits<double>::infinity(), high = -low;
  std::vector<double> along;
  for (const Vec3& p : mesh.vertices) {
    along.push_back(axis.dot(p));
    low = std::min(low, along.back());
    high = std::max(high, along.back());
  }
  for (double& u : along) u = (u - low) / (high - low);
  return along;
}

void volumes_before(const VolumeZones& zones, const Points& x,
                    const std::vector<Triangle>& triangles, std::vector<double>& before) {
  before.clear();
  for (const VolumeZones::Cut& cut : zones.cuts) before.push_back(volume_before(cut, x, triangles));
  before.push_back(enclosed_volume(x, triangles));
}

void gradients_before(const VolumeZones& zones, const Points& x,
                      const std::vector<Triangle>& triangles, std::vector<Points>& gradients) {
  const size_t cuts = zones.cuts.size();
  gradients.resize(cuts + 1);
  for (size_t c = 0; c < cuts; ++c) gradient_before(zones.cuts[c], x, triangles, gradients[c]);
  volume_gradient(x, triangles, gradients[cuts]);
}

double zone_error(const VolumeZones& zones, const std::vector<double>& before,
                  const std::vector<double>& wanted) {
  double largest = 0.0;
  for (int j = 0; j < zones.count(); ++j) {
    const auto zone = [&](const std::vector<double>& l) { return l[j] - (j > 0 ? l[j - 1] : 0.0); };
    largest = std::max(largest, std::abs(zone(before) - zone(wanted)) / zone(zones.rest_before));
  }
  return largest;
}

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxZones, kMaxZones>;
using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxZones, 1>;

THEW_VECTORISED
double product(const Points& a, const Points& b) {
  Point sum = {};
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum3(sum);
}

THEW_VECTORISED
void move(const Points& direction, double distance, Points& x) {
  for (size_t i = 0; i < x.size(); ++i) x[i] += distance * direction[i];
}

// Row i: how the volume before cut i grows along each direction.
Matrix slopes(const VolumeZones& zones, const std::vector<Triangle>& triangles,
              const std::vector<Points>& directions, const Points& x,
              std::vector<Points>& gradients) {
  gradients_before(zones, x, triangles, gradients);
  Matrix out(zones.count(), zones.count());
  for (int i = 0; i < zones.count(); ++i) {
    for (int j = 0; j < zones.count(); ++j) out(i, j) = product(gradients[i], directions[j]);
  }
  return out;
}

}  // namespace

bool restore_zones(const VolumeZones& zones, const std::vector<Triangle>& triangles,
                   const std::vector<double>& wanted, const std::vector<Points>& directions,
                   ZoneScratch& scratch, Points& x) {
  constexpr int kMaxPasses = 20;
  constexpr double kTolerance = 1e-13;  // of the enclosed volume, near its rounding error
  constexpr double kSingular = 1e-11;   // of the largest pivot
  // If a pass leaves less than this share of the error, the next pass uses the same slopes, because
  // computing them costs more than a pass.
  constexpr double kFast = 0.1;
  const int count = zones.count();
  scratch.start = x;
  Vector missing(count);
  Eigen::FullPivLU<Matrix> system(count, count);
  system.setThreshold(kSingular);
  double before = std::numeric_limits<double>::infinity();
  for (int pass = 0; pass < kMaxPasses; ++pass) {
    volumes_before(zones, x, triangles, scratch.before);
    for (int i = 0; i < count; ++i) missing[i] = wanted[i] - scratch.before[i];
    const double error = missing.cwiseAbs().maxCoeff();
    if (error <= kTolerance * wanted.back()) return true;
    if (!(error < before)) break;
    const bool fast = pass > 0 && error < kFast * before;
    before = error;
    if (!fast) {
      const Matrix now = slopes(zones, triangles, directions, x, scratch.gradients);
      if (!now.allFinite()) break;
      // Rank-deficient if no direction moves a zone; that does not matter while its volume is
      // right.
      system.compute(now);
    }
    const Vector step = system.solve(missing);
    for (int j = 0; j < count; ++j) move(directions[j], step[j], x);
  }
  x = scratch.start;
  return false;
}

}  // namespace thew::muscles
