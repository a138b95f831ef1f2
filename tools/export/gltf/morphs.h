// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tools/export/shot.h"

namespace thew::tools {

/// A motion as morph targets: at frame f the shape is base + sum over k of weights[f][k]
/// targets[k].
struct Morphs {
  Shape base;                  ///< rounded to float32, so that a sum is rounded once
  std::vector<Shape> targets;  ///< displacements
  std::vector<std::string> names;
  std::vector<std::vector<float>>
      weights;  ///< by frame, target; 0 to 1, which some readers ask for
};

/// A target a frame, named after it; frames in which nothing moves share one.
Morphs exact_morphs(const Shape& base, const std::vector<Shape>& frames,
                    const std::vector<std::string>& names);
/// `modes` targets at most that come closest to the positions, and one that leads from the base to
/// where they begin, unless that is there. Normals are fitted to the same weights.
Morphs basis_morphs(const Shape& base, const std::vector<Shape>& frames,
                    const std::vector<std::string>& names, int modes);

/// Whether the shapes are all the same.
bool is_still(const std::vector<Shape>& frames);

/// The shape of a frame as a reader of float32 sees it. Its normals have the length of their sum.
Shape morphed(const Morphs& morphs, std::size_t frame);

/// How far shapes in a file are from the bake's.
struct Deviation {
  double largest = 0.0, squares = 0.0;  ///< m, m^2
  double normal = 0.0;                  ///< rad, the largest angle between normals
  std::size_t count = 0;                ///< of positions
  std::string where;                    ///< mesh, frame and vertex of the largest

  void add(const Vec3& read, const Vec3& baked, const std::string& mesh, int frame,
           std::size_t vertex);
  void add_normal(const Vec3& read, const Vec3& baked);
  double rms() const;  ///< m
};
/// "0.0123 mm"
std::string in_mm(double metres);

}  // namespace thew::tools
