// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "skin/surface/surface.h"

namespace thew::tests {

/// The edges at which a surface is bent by more than 90 degrees.
inline int folds_beyond_90(const Surface& surface, const Points& x) {
  int folds = 0;
  for (int t = 0; t < static_cast<int>(surface.triangles.size()); ++t) {
    for (const int other : surface.neighbours[t]) {
      if (other > t && face_normal(surface, x, t).dot(face_normal(surface, x, other)) < 0.0) {
        ++folds;
      }
    }
  }
  return folds;
}

}  // namespace thew::tests
