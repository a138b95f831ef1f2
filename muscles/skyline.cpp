// SPDX-License-Identifier: Apache-2.0
#include "muscles/skyline.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "rig/vectorise.h"

namespace thew::muscles {
namespace {

using Adjacency = std::vector<std::vector<int>>;

// Breadth-first order from `root` over nodes not yet marked, neighbours by rising degree.
std::vector<int> breadth_first(const Adjacency& adjacency, int root, std::vector<char>& marked) {
  std::vector<int> order{root};
  marked[root] = 1;
  for (size_t head = 0; head < order.size(); ++head) {
    const size_t begin = order.size();
    for (int next : adjacency[order[head]]) {
      if (marked[next]) continue;
      marked[next] = 1;
      order.push_back(next);
    }
    std::stable_sort(order.begin() + begin, order.end(),
                     [&](int a, int b) { return adjacency[a].size() < adjacency[b].size(); });
  }
  return order;
}

// Reverse Cuthill-McKee, started from an end of each component (the last node of a first sweep).
std::vector<int> short_row_order(const Adjacency& adjacency, const std::vector<char>& driven) {
  std::vector<int> order;
  std::vector<char> marked(driven), swept(driven);
  for (size_t node = 0; node < adjacency.size(); ++node) {
    if (marked[node]) continue;
    const int end = breadth_first(adjacency, static_cast<int>(node), swept).back();
    const std::vector<int> component = breadth_first(adjacency, end, marked);
    order.insert(order.end(), component.rbegin(), component.rend());
  }
  return order;
}

// Inlined even without optimisation, because clones for different processors do not return a vector
// in the same register.
template <typename Vector = Point>
[[gnu::always_inline]] inline Vector load(const double* from) {
  Vector vector;
  __builtin_memcpy(&vector, from, sizeof vector);
  return vector;
}

template <typename Vector>
[[gnu::always_inline]] inline void store(const Vector& vector, double* to) {
  __builtin_memcpy(to, &vector, sizeof vector);
}

// Sum of a[k] b[k] in eight lanes, so that its order does not depend on the vector width of the
// processor.
inline double dot(const double* a, const double* b, int count) {
  Point low = {}, high = {};
  int k = 0;
  for (; k + 8 <= count; k += 8) {
    low += load(a + k) * load(b + k);
    high += load(a + k + 4) * load(b + k + 4);
  }
  double tail = 0.0;
  for (; k < count; ++k) tail += a[k] * b[k];
  const Point sum = low + high;
  return ((sum[0] + sum[1]) + (sum[2] + sum[3])) + tail;
}

}  // namespace

Skyline make_skyline(int nodes, const std::vector<std::array<int, 2>>& pairs,
                     const std::vector<char>& driven) {
  Adjacency adjacency(nodes);
  for (const auto& [a, b] : pairs) {
    if (driven[a] || driven[b]) continue;
    adjacency[a].push_back(b);
    adjacency[b].push_back(a);
  }
  Skyline matrix;
  matrix.order = short_row_order(adjacency, driven);
  matrix.position.assign(nodes, -1);
  for (int i = 0; i < matrix.size(); ++i) matrix.position[matrix.order[i]] = i;
  matrix.first.resize(matrix.size());
  matrix.start.resize(matrix.size() + 1, 0);
  for (int i = 0; i < matrix.size(); ++i) {
    int first = i;
    for (int neighbour : adjacency[matrix.order[i]]) {
      first = std::min(first, matrix.position[neighbour]);
    }
    matrix.first[i] = first;
    matrix.start[i + 1] = matrix.start[i] + (i - first + 1);
  }
  if (matrix_bytes(matrix) > kMaxMatrixBytes) {
    throw std::length_error("its " + std::to_string(matrix.size()) +
                            " free nodes need a matrix of " +
                            std::to_string(matrix_bytes(matrix) >> 20) + " MiB, more than " +
                            std::to_string(kMaxMatrixBytes >> 20) + "; use a coarser mesh");
  }
  matrix.values.assign(matrix.start.back(), 0.0);
  return matrix;
}

void add_entry(Skyline& matrix, int a, int b, double k) {
  const int i = std::max(matrix.position[a], matrix.position[b]);
  const int j = std::min(matrix.position[a], matrix.position[b]);
  if (j < 0) return;
  matrix.values[matrix.start[i] + (j - matrix.first[i])] += k;
}

THEW_VECTORISED
bool factorise(const Skyline& matrix, const std::vector<double>& extra, SkylineFactor& factor) {
  const int n = matrix.size();
  factor.values.resize(matrix.values.size());
  factor.inverse_diagonal.resize(n);
  for (int i = 0; i < n; ++i) {
    const int first = matrix.first[i];
    const double* values = matrix.values.data() + matrix.start[i];
    double* row = factor.values.data() + matrix.start[i];
    for (int j = first; j < i; ++j) {
      const int from = std::max(first, matrix.first[j]);
      const double* other = factor.values.data() + matrix.start[j] + (from - matrix.first[j]);
      row[j - first] = (values[j - first] - dot(row + (from - first), other, j - from)) *
                       factor.inverse_diagonal[j];
    }
    const double pivot = values[i - first] + extra[i] - dot(row, row, i - first);
    if (!(pivot > 0.0)) return false;
    row[i - first] = std::sqrt(pivot);
    factor.inverse_diagonal[i] = 1.0 / row[i - first];
  }
  return true;
}

namespace {

// Forward and backward substitution. A vector that is wider than the registers of the processor
// would live in memory, so a pair of points is handled in parts of the size of Vector.
template <typename Vector>
[[gnu::always_inline]] inline void solve_by(const Skyline& matrix, const SkylineFactor& factor,
                                            double* x) {
  constexpr int kPair = 8, kPart = sizeof(Vector) / sizeof(double);
  const int n = matrix.size();
  for (int i = 0; i < n; ++i) {
    const int first = matrix.first[i], count = i - first;
    const double* row = factor.values.data() + matrix.start[i];
#pragma GCC unroll 2
    for (int part = 0; part < kPair; part += kPart) {
      double* const own = x + kPair * i + part;
      const double* at = x + kPair * first + part;
      Vector a = load<Vector>(own), b = {}, c = {},
             d = {};  // four independent sums, so that none waits for another
      int k = 0;
      for (; k + 4 <= count; k += 4, at += 4 * kPair) {
        a -= row[k] * load<Vector>(at);
        b -= row[k + 1] * load<Vector>(at + kPair);
        c -= row[k + 2] * load<Vector>(at + 2 * kPair);
        d -= row[k + 3] * load<Vector>(at + 3 * kPair);
      }
      for (; k < count; ++k, at += kPair) a -= row[k] * load<Vector>(at);
      store<Vector>(((a + b) + (c + d)) * factor.inverse_diagonal[i], own);
    }
  }
  for (int i = n - 1; i >= 0; --i) {
    const int first = matrix.first[i], count = i - first;
    const double* row = factor.values.data() + matrix.start[i];
#pragma GCC unroll 2
    for (int part = 0; part < kPair; part += kPart) {
      double* const own = x + kPair * i + part;
      const Vector solved = load<Vector>(own) * factor.inverse_diagonal[i];
      store<Vector>(solved, own);
      double* at = x + kPair * first + part;
      for (int k = 0; k < count; ++k, at += kPair) {
        store<Vector>(load<Vector>(at) - row[k] * solved, at);
      }
    }
  }
}

THEW_WIDE
void solve_whole(const Skyline& matrix, const SkylineFactor& factor, double* x) {
  solve_by<PointPair>(matrix, factor, x);
}

THEW_VECTORISED
void solve_in_halves(const Skyline& matrix, const SkylineFactor& factor, double* x) {
  solve_by<Point>(matrix, factor, x);
}

}  // namespace

void solve(const Skyline& matrix, const SkylineFactor& factor, PointPairs& b) {
  (THEW_HAS_WIDE ? solve_whole : solve_in_halves)(matrix, factor,
                                                  reinterpret_cast<double*>(b.data()));
}

}  // namespace thew::muscles
