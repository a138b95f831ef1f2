// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <vector>

#include "thew/error.h"

// A folder is a namespace that sees those to its left. NOLINTBEGIN(google-build-using-namespace)
namespace thew {
namespace rig {}
namespace muscles {
using namespace rig;
}
namespace skin {
using namespace rig;
using namespace muscles;
}  // namespace skin
namespace sim {
using namespace rig;
using namespace muscles;
using namespace skin;
}  // namespace sim
namespace tools {
using namespace rig;
using namespace muscles;
using namespace skin;
using namespace sim;
}  // namespace tools
namespace tests {
using namespace rig;
using namespace muscles;
using namespace skin;
using namespace sim;
using namespace tools;
}  // namespace tests
}  // namespace thew
// NOLINTEND(google-build-using-namespace)
namespace thew::rig {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Transform = Eigen::Isometry3d;
using Triangle = std::array<int, 3>;

/// A node: x, y, z and a zero, so that it is read by one aligned load. The alignment is stated
/// because without AVX the compiler would align one on the stack to 16 bytes only, and functions
/// that are compiled for wider vectors rely on 32.
using Point = double __attribute__((vector_size(32), aligned(32)));

/// Allocates memory aligned to 64 bytes, for the widest vectors of any processor, whatever the
/// translation unit is compiled for.
template <typename T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  AlignedAllocator() = default;
  template <typename U>
  AlignedAllocator(const AlignedAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  bool operator==(const AlignedAllocator&) const { return true; }
};
using Points = std::vector<Point, AlignedAllocator<Point>>;

[[gnu::always_inline]] inline Point to_point(const Vec3& p) {
  return Point{p.x(), p.y(), p.z(), 0.0};
}
inline Vec3 to_vec(const Point& r) { return {r[0], r[1], r[2]}; }
inline Points to_points(const std::vector<Vec3>& points) {
  Points rows;
  for (const Vec3& p : points) rows.push_back(to_point(p));
  return rows;
}
inline double dot(const Point& a, const Point& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline double norm(const Point& r) { return std::sqrt(dot(r, r)); }
// Always inlined: a call between functions that are compiled for different instruction sets would
// pass vectors in different registers.
[[gnu::always_inline]] inline double sum3(const Point& a) { return (a[0] + a[1]) + a[2]; }
[[gnu::always_inline]] inline Point yzx(const Point& a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline Point cross3(const Point& a, const Point& b) {
  return yzx(a * yzx(b) - yzx(a) * b);
}
/// The largest distance between nodes of the same index.
inline double largest_distance(const Points& a, const Points& b) {
  double squared = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Point d = a[i] - b[i];
    squared = std::max(squared, dot(d, d));
  }
  return std::sqrt(squared);
}

}  // namespace thew::rig
