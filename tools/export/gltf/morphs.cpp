// SPDX-License-Identifier: Apache-2.0
#include "tools/export/gltf/morphs.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "rig/math.h"
#include "tools/export/gltf/basis.h"
#include "tools/export/gltf/glb.h"

namespace thew::tools {
namespace {

constexpr double kStill = 1e-9;  // m; what moves less stands still

using Values = std::vector<Vec3>;

Values minus(Values a, const Values& b) {
  for (std::size_t v = 0; v < a.size(); ++v) a[v] -= b[v];
  return a;
}

double largest_difference(const Values& a, const Values& b) {
  double largest = 0.0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    largest = std::max(largest, (a[v] - b[v]).squaredNorm());
  }
  return std::sqrt(largest);
}

Shape rounded(const Shape& shape) {
  return {as_float32(shape.positions), as_float32(shape.normals)};
}

std::vector<const Values*> pointers(const std::vector<Shape>& frames, Values Shape::*of) {
  std::vector<const Values*> values;
  for (const Shape& frame : frames) values.push_back(&(frame.*of));
  return values;
}

// The normals of targets with these weights that come closest to those of the frames.
void fit_normals(const std::vector<Shape>& frames, Morphs& morphs) {
  if (morphs.base.normals.empty()) return;
  std::vector<Values> turns;
  std::vector<const Values*> turn_of;
  for (const Shape& frame : frames) turns.push_back(minus(frame.normals, morphs.base.normals));
  for (const Values& turn : turns) turn_of.push_back(&turn);
  const auto factors = least_squares_factors(morphs.weights);
  for (std::size_t k = 0; k < factors.size(); ++k) {
    morphs.targets[k].normals = combine(factors[k], turn_of);
  }
}

// What is as the base in all frames is so in the file, too: sums of rounded frames are not quite.
void keep_still(const Shape& base, const std::vector<Shape>& frames, Morphs& morphs) {
  for (const auto of : {&Shape::positions, &Shape::normals}) {
    for (std::size_t v = 0; v < (base.*of).size(); ++v) {
      const bool still = std::all_of(frames.begin(), frames.end(), [&](const Shape& frame) {
        return (frame.*of)[v] == (base.*of)[v];
      });
      if (!still) continue;
      for (Shape& target : morphs.targets) (target.*of)[v].setZero();
    }
  }
}

}  // namespace

Morphs exact_morphs(const Shape& base, const std::vector<Shape>& frames,
                    const std::vector<std::string>& names) {
  Morphs morphs{rounded(base), {}, {}, {}};
  std::vector<std::size_t> target_of;
  for (std::size_t f = 0; f < frames.size(); ++f) {
    if (f == 0 || frames[f].positions != frames[f - 1].positions ||
        frames[f].normals != frames[f - 1].normals) {
      morphs.targets.push_back({minus(frames[f].positions, morphs.base.positions),
                                minus(frames[f].normals, morphs.base.normals)});
      morphs.names.push_back(names[f]);
    }
    target_of.push_back(morphs.targets.size() - 1);
  }
  for (const std::size_t target : target_of) {
    morphs.weights.emplace_back(morphs.targets.size(), 0.0f)[target] = 1.0f;
  }
  return morphs;
}

Morphs basis_morphs(const Shape& base, const std::vector<Shape>& frames,
                    const std::vector<std::string>& names, int modes) {
  if (frames.size() <= static_cast<std::size_t>(modes)) return exact_morphs(base, frames, names);
  const auto positions = pointers(frames, &Shape::positions);
  const MotionBasis basis = fit_motion_basis(positions, modes);
  Morphs morphs{rounded(base), {}, {}, basis.weights};
  Values begin = minus(combine(basis.base_factors, positions), morphs.base.positions);
  if (largest_difference(begin, Values(begin.size(), Vec3::Zero())) > kStill) {
    morphs.targets.push_back({std::move(begin), {}});
    morphs.names.emplace_back("begin");
    for (auto& weights : morphs.weights) weights.insert(weights.begin(), 1.0f);
  }
  for (std::size_t k = 0; k < basis.factors.size(); ++k) {
    morphs.targets.push_back({combine(basis.factors[k], positions), {}});
    morphs.names.push_back("mode " + std::to_string(k + 1));
  }
  if (!morphs.targets.empty()) fit_normals(frames, morphs);
  keep_still(base, frames, morphs);
  return morphs;
}

bool is_still(const std::vector<Shape>& frames) {
  return std::all_of(frames.begin(), frames.end(), [&](const Shape& frame) {
    return largest_difference(frame.positions, frames.front().positions) <= kStill;
  });
}

Shape morphed(const Morphs& morphs, std::size_t frame) {
  Shape shape = morphs.base;
  const auto add = [](Values& to, double weight, const Values& target) {
    const Values read = as_float32(target);
    for (std::size_t v = 0; v < to.size(); ++v) to[v] += weight * read[v];
  };
  for (std::size_t k = 0; k < morphs.targets.size(); ++k) {
    const double weight = morphs.weights[frame][k];
    if (weight == 0.0) continue;
    add(shape.positions, weight, morphs.targets[k].positions);
    add(shape.normals, weight, morphs.targets[k].normals);
  }
  return shape;
}

void Deviation::add(const Vec3& read, const Vec3& baked, const std::string& mesh, int frame,
                    std::size_t vertex) {
  const double square = (read - baked).squaredNorm();
  squares += square;
  ++count;
  if (square <= largest * largest) return;
  largest = std::sqrt(square);
  where = mesh + ", frame " + std::to_string(frame) + ", vertex " + std::to_string(vertex);
}

void Deviation::add_normal(const Vec3& read, const Vec3& baked) {
  normal = std::max(normal, arc_tan2(read.cross(baked).norm(), read.dot(baked)));
}

double Deviation::rms() const {
  return count == 0 ? 0.0 : std::sqrt(squares / static_cast<double>(count));
}

std::string in_mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g mm", 1e3 * metres);
  return text;
}

}  // namespace thew::tools
