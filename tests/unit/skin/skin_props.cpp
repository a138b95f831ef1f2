// SPDX-License-Identifier: Apache-2.0
//
// What presses on a skin from outside: a ball of skin, and a small ball in the middle of a face.
#include <gtest/gtest.h>

#include "rig/math.h"
#include "skin/skin_layer.h"
#include "skin/skinned_skin.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kSkin = 0.05, kProp = 0.002;  // m, radii; edges of the skin are 5 to 10 mm
constexpr double kGap = 1e-4;

struct Pressed {
  Shape flesh = make_shape(ball(0.02, Vec3::Zero(), 32, 31));
  std::vector<Collider> below = {{&flesh.surface, &flesh.bvh, &flesh.x, nullptr}};
  TriMesh mesh = ball(kSkin, Vec3::Zero(), 32, 31);
  Vec3 out;  // from the middle to that of a face near the equator
  Shape prop;
  Props props;

  Pressed() {
    Vec3 middle = Vec3::Zero();
    for (const Triangle& t : mesh.triangles) {
      const Vec3 at = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3.0;
      if (std::abs(at.y()) < 0.004) middle = at;
    }
    out = middle.normalized();
  }
  // The small ball reaches to `depth` (m) below the skin as modelled.
  void press(double depth) {
    prop = make_shape(ball(kProp, (kSkin - depth + kProp) * out, 12, 11));
    props = {{{&prop.surface, &prop.bvh, &prop.x, nullptr}}, kGap, 0.05};
  }
  // m, how far the deepest of its points is inside the skin.
  double inside(const Surface& surface, const Points& x) const {
    const Bvh bvh = build_bvh(surface, x);
    double deepest = -1.0;
    for (const Point& p : prop.x) {
      const ClosestPoint near = closest_point(surface, bvh, x, to_vec(p), 1.0);
      deepest = std::max(deepest, -near.distance);
    }
    return deepest;
  }
};

TEST(SkinProps, APropFinerThanALayerDoesNotComeThrough) {
  Pressed it;
  Skeleton skeleton;
  skeleton.body_names = {"bone"};
  skeleton.parent = {-1};
  for (const char* volume : {"free", "kept"}) {
    const SkinModel model =
        bind_skin(it.mesh, skeleton, {Transform::Identity()}, it.below, {0},
                  {.thickness = 0.001, .keeps_volume = volume == std::string("kept")});
    SkinState state = initial_skin(model);
    for (int k = 0; k <= 16; ++k) {  // 8 mm, four times its radius
      it.press(5e-4 * k);
      step_skin(model, {Transform::Identity()}, it.below, {}, state, kReturn, it.props);
      EXPECT_LT(it.inside(model.surface, state.x), 1e-6) << volume << k;
    }
    it.press(-0.02);
    for (int k = 0; k < 100; ++k) {
      step_skin(model, {Transform::Identity()}, it.below, {}, state, kReturn, it.props);
    }
    double most = 0.0;
    for (size_t i = 0; i < state.x.size(); ++i) {
      most = std::max(most, norm(state.x[i] - model.rest[i]));
    }
    EXPECT_LT(most, 1e-4) << volume;  // it comes back
  }
}

TEST(SkinProps, NorThroughACharactersSkin) {
  Pressed it;
  Character character;
  character.mesh = it.mesh;
  SkinWeights& weights = character.skin;
  for (size_t i = 0; i < it.mesh.vertices.size(); ++i) {
    character.map_back.push_back(static_cast<int>(i));
    weights.first.push_back(static_cast<int>(i));
    weights.link.push_back(0);
    weights.weight.push_back(1.0);
  }
  weights.first.push_back(static_cast<int>(it.mesh.vertices.size()));
  weights.links.push_back({0, Affine::Identity()});
  const SkinnedSkin skin = bind_skinned(character, {Affine::Identity()}, it.below, 1, {1}, {});
  SkinState state = initial_skinned(skin), layer = initial_layer(skin);
  for (int k = 0; k <= 16; ++k) {
    it.press(5e-4 * k);
    step_skinned(skin, {Affine::Identity()}, it.below, {}, layer, state, kReturn, it.props);
    EXPECT_LT(it.inside(skin.surface, state.x), 1e-6) << k;
  }
}

}  // namespace
}  // namespace thew::tests
