// SPDX-License-Identifier: Apache-2.0
//
// thew new on figures whose joints lie beside the flesh, or whose flesh is flat: what turns in a
// joint is round about it.
#include "tests/unit/tools/fit/new_figure.h"

namespace thew::tests {
namespace {

constexpr double kHead = 0.025;  // m from the joint up, against the shaft

// Of the right humerus' head, in the body's frame: its middle across the shaft, and how far it
// reaches there along z and along the other axis.
struct Head {
  Vec3 middle = Vec3::Zero();
  double thick = 0.0, wide = 0.0;  // m
};

Head head_of(const Model& model) {
  Head head;
  for (const Bone& bone : model.bones) {
    if (bone.name != "humerus_right") continue;
    Vec3 shaft = Vec3::Zero();
    for (const Vec3& p : bone.in_body.vertices) shaft += p;
    shaft.normalize();
    const Vec3 z = (Vec3::UnitZ() - shaft.z() * shaft).normalized(), y = z.cross(shaft);
    Eigen::AlignedBox2d box;
    for (const Vec3& p : bone.in_body.vertices) {
      if (p.dot(shaft) < 0.0 && p.dot(shaft) > -kHead)
        box.extend(Eigen::Vector2d(p.dot(z), p.dot(y)));
    }
    EXPECT_FALSE(box.isEmpty());
    head = {box.center().x() * z + box.center().y() * y, box.sizes().x(), box.sizes().y()};
  }
  return head;
}

class NewJoints : public FigureScene {
 protected:
  Head head(const Figure& figure) {
    return head_of(built(options(figure, "right"), {"skin.enabled=false"}));
  }
};

// The head was laid into the flesh's middle, 21 mm from where it is, and turned through the muscles
// about it when the arm was raised.
TEST_F(NewJoints, AHumerusTurnsAboutItsHead) {
  const Head usual = head(Figure());
  Figure figure;
  for (Figure::Joint& joint : figure.joints) {
    if (joint.name.ends_with("Arm") && !joint.name.ends_with("ForeArm")) joint.place.z() -= 0.03;
  }
  const Head beside = head(figure);
  const double moved = (beside.middle - usual.middle).norm();
  std::printf("%.1f mm from where it is\n", 1e3 * moved);
  EXPECT_LT(moved, 5e-3);
}

TEST_F(NewJoints, TheHeadOfAFlatArmIsRound) {
  const Head usual = head(Figure());
  Figure figure;
  for (Figure::Mesh& mesh : figure.meshes) {
    for (Vec3& p : mesh.positions) p.z() *= 0.7;
  }
  const Head flat = head(figure);
  const double flatness = flat.thick / flat.wide / (usual.thick / usual.wide);
  std::printf("%.2f as thick for its width\n", flatness);
  EXPECT_NEAR(flatness, 1.0, 0.1);
}

}  // namespace
}  // namespace thew::tests
