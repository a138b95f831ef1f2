// SPDX-License-Identifier: Apache-2.0
//
// From where a new scene is looked at.
#include "tools/base/obj_text.h"
#include "tools/fit/target.h"

namespace thew::tools {
namespace {

// Towards the camera: from where the arms bend to and a little above; from the side of an only arm,
// and from the first's a little where there are two, so that none hides the other.
Vec3 viewpoint(const std::vector<ArmFit>& fits) {
  const auto level = [](const Vec3& v) { return Vec3(v.x(), 0.0, v.z()); };
  Vec3 bend = Vec3::Zero();
  for (const ArmFit& fit : fits) bend += level(fit.frame.col(0));
  const Vec3 front =
      bend.norm() > 0.3 * static_cast<double>(fits.size()) ? bend.normalized() : Vec3::UnitZ();
  const double side = fits.size() == 1 ? 0.8 : 0.3;
  return (front + side * level(fits.front().frame.col(2)) + 0.25 * Vec3::UnitY()).normalized();
}

// What the camera goes along with, and shows with all that hangs on it: an only arm's humerus; of
// two arms the nearest body that carries both, and the head as well; -1 where none does.
int carrier_of(const Skeleton& skeleton, const std::vector<ArmBodies>& arms) {
  if (arms.size() == 1) return arms.front().humerus;
  int body = arms.front().clavicle;
  while (body >= 0 && !hangs_on(skeleton, arms.back().clavicle, body)) {
    body = skeleton.parent[body];
  }
  return body;
}

}  // namespace

// Views of one camera, which the scene's clip places: another clip needs no other views.
std::string views_text(const Character& character, const std::vector<ArmBodies>& arms,
                       const std::vector<ArmFit>& fits) {
  const int carrier = carrier_of(character.skeleton, arms);
  const std::string from =
      "from = [" + metres(viewpoint(fits), ", ") + "]  # towards the camera; or eye and target\n";
  const std::string follow =
      carrier < 0 ? "" : "follow = " + quoted(character.skeleton.body_names[carrier]) + "\n";
  std::string text;
  for (const char* show : {"skin", "muscles"}) {
    text += "[[render.view]]\nname = " + quoted(show) + "\nshow = " + quoted(show) + "\n" + from +
            follow + "field_of_view = 30\n\n";
  }
  return text;
}

}  // namespace thew::tools
