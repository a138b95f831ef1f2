// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "rig/mesh.h"

namespace thew::tools {

/// A thick line whose radius runs from one end to the other, its section longer by `flat` along a
/// direction. Points in metres, in the humerus' frame at rest.
struct BoneStroke {
  Vec3 from, to;
  double from_radius, to_radius;
  double flat = 1.0;
  Vec3 flat_along = Vec3::UnitX();
};

/// A bone: strokes melted into one another.
struct BoneShape {
  std::string body;
  double blend = 0.006;                   ///< m, over which strokes melt
  Vec3 cell = Vec3(0.004, 0.008, 0.004);  ///< m, of the grid that its mesh is taken from
  std::vector<BoneStroke> strokes;
  std::vector<BoneStroke> hollows;  ///< cut out of it
};

/// Our own bones of the right arm, by the landmarks that the muscles need; the fingers' come last.
std::vector<BoneShape> arm_bones();

/// The smaller of two distances (m), rounded where they are within `blend` (m) of one another.
double melt(double a, double b, double blend);

/// Signed distance (m) to the bone, near enough close to its surface; negative inside.
double bone_distance(const BoneShape& bone, const Vec3& p);

/// A closed mesh of it, in the humerus' frame.
TriMesh bone_mesh(const BoneShape& bone);

}  // namespace thew::tools
