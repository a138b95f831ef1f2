// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "tools/author/sections.h"

namespace thew::tools {

/// The muscle's thickness near a point: that of the nearest point of its middle line.
struct Near {
  Vec3 point = Vec3::Zero();
  Slab slab;
  double soft = 0.0;  ///< m, by which its half thickness exceeds a tendon's
};

/// The line through the centres of a muscle's sections from pole to pole, as it is when this is
/// built. It is searched outwards from `place`, beside which nearly all questions are.
class MiddleLine {
 public:
  MiddleLine(const SectionedMuscle& muscle, const Vec3& place);

  /// The thickness near a point that is `away` (m) from `place`; of pieces equally near that of the
  /// first.
  Near near(const Vec3& p, double away) const;
  /// m, at most the distance of the muscle's slabs from such a point.
  double least_distance(double away) const {
    return pieces_.front().distance - away - widest_ - 1e-9;
  }
  /// m, the largest that `near` finds.
  double softest() const { return softest_; }

 private:
  struct Piece {
    Vec3 from, along;
    double squared;   // m^2, the length's
    double distance;  // m, from the place
    size_t number;
  };
  // The nearest of a piece to p, as its share.
  static double share(const Piece& piece, const Vec3& p);

  std::vector<Piece> pieces_;  // the nearest to the place first
  std::vector<Slab> slabs_;    // where pieces meet, from pole to pole
  double tendon_radius_[2];
  double widest_ = 0.0, softest_ = 1e-4;  // m
};

}  // namespace thew::tools
