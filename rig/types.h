// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <new>
#include <stdexcept>
#include <string>
#include <vector>

namespace thew {

using Vec3 = Eigen::Vector3d;
using Mat3 = Eigen::Matrix3d;
using Transform = Eigen::Isometry3d;
using Triangle = std::array<int, 3>;

/// One node per row: x, y, z and a zero, so that a node is one aligned load. The alignment is said,
/// since without AVX the compiler would give half of it to what lies on the stack, and a function
/// compiled for wider vectors counts on all of it.
using Row = double __attribute__((vector_size(32), aligned(32)));

/// Memory aligned for the widest vectors, whatever the translation unit is compiled for.
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
using Rows = std::vector<Row, AlignedAllocator<Row>>;

[[gnu::always_inline]] inline Row to_row(const Vec3& p) { return Row{p.x(), p.y(), p.z(), 0.0}; }
inline Vec3 to_vec(const Row& r) { return {r[0], r[1], r[2]}; }
inline Rows to_rows(const std::vector<Vec3>& points) {
  Rows rows;
  for (const Vec3& p : points) rows.push_back(to_row(p));
  return rows;
}
inline double dot(const Row& a, const Row& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double norm(const Row& r) { return std::sqrt(dot(r, r)); }
// Always inlined: called across two instruction sets, vectors would be passed in different
// registers.
[[gnu::always_inline]] inline double sum3(const Row& a) { return (a[0] + a[1]) + a[2]; }
[[gnu::always_inline]] inline Row yzx(const Row& a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}
[[gnu::always_inline]] inline Row cross3(const Row& a, const Row& b) {
  return yzx(a * yzx(b) - yzx(a) * b);
}
/// Of nodes of the same number: the greatest distance.
inline double largest_distance(const Rows& a, const Rows& b) {
  double squared = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const Row d = a[i] - b[i];
    squared = std::max(squared, dot(d, d));
  }
  return std::sqrt(squared);
}

/// Exit codes of the command, and what each kind of Error ends it with.
enum class ExitCode {
  kDone = 0,
  kDifferent = 1,  ///< compared and different, or a quality bound not met
  kUsage = 2,      ///< command line or scene
  kInput = 3,      ///< a bad input file
  kOutput = 4,     ///< cannot write
  kSolver = 5,     ///< the solver could not go on
  kRetry = 75,     ///< interrupted or locked, try again with --resume
};

/// The one exception of Thew. The message is "place: what is wrong with what; the next move".
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace thew
