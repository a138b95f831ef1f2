// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "tools/fit/arm.h"

namespace thew::tools {

/// What surrounds a limb, in as many layers and pieces as there are, closed or not: to be looked at
/// along rays from its bones outwards, of which the last hit counts.
class Limb {
 public:
  explicit Limb(const TriMesh& mesh);

  /// m, to the last triangle that a ray meets within `reach`; -1 where it meets none.
  double outermost(const Vec3& from, const Vec3& to, double reach) const;

  /// Every edge is between two triangles: then what is inside can be told, and is by way_out.
  bool closed() const { return closed_; }
  /// m, where a ray leaves the last of the closed surfaces it began in; -1 where it began in none.
  double way_out(const Vec3& from, const Vec3& to) const;

  /// Of a plane with what of the limb lies within reach: its convex outline, which neither holes
  /// nor inner walls change, nor the trunk's side beside it.
  struct Section {
    Vec3 middle = Vec3::Zero();
    double radius = 0.0;  ///< m, of the circle of that area; 0 where there is none
    std::vector<Eigen::Vector2d> outline;
    Vec3 at, a, b;
    double within(const Vec3& p) const;  ///< m, from the outline; negative outside of it
  };
  /// Through `at`, along unit vectors at right angles. What is farther than `widest` times the
  /// median counts as so far: at the armpit the trunk goes on beside the limb.
  Section section(const Vec3& at, const Vec3& a, const Vec3& b, double reach,
                  double widest = std::numeric_limits<double>::infinity()) const;

 private:
  struct Ball {  // around triangles, so that most of them cost little
    Vec3 middle;
    double reach;  // m
  };
  static constexpr size_t kGroup = 32;  // triangles, one after another in the file

  /// Calls see(triangle), in their order, for those whose balls `misses` does not tell to be
  /// missed.
  template <typename Misses, typename See>
  void look_at(const Misses& misses, const See& see) const {
    for (size_t g = 0; g < groups_.size(); ++g) {
      if (misses(groups_[g])) continue;
      for (size_t i = g * kGroup; i < std::min((g + 1) * kGroup, balls_.size()); ++i) {
        if (!misses(balls_[i])) see(i);
      }
    }
  }

  const TriMesh& mesh_;
  std::vector<Ball> balls_, groups_;  // of each triangle; of kGroup of them
  bool closed_ = false;
};

/// The hand, and fingers that hang on the forearm beside it; none where that carries the hand.
std::vector<int> hand_bodies(const Character& character, const ArmBodies& arm);
/// By their own names or, without these, their objects'; each once.
std::vector<std::string> mesh_names(const Character& character);
/// Triangles, of the meshes named (empty: of all), that mostly hang on the bodies and what is below
/// them; in the rest pose, `x`. Error(kUsage) for a name that is no mesh's.
TriMesh skin_around(const Character& character, const std::vector<int>& bodies,
                    const std::vector<std::string>& meshes, const Points& x,
                    const std::string& place);

}  // namespace thew::tools
