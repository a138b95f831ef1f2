// SPDX-License-Identifier: Apache-2.0
//
// A character's own skin over muscles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "rig/math.h"
#include "skin/depth.h"
#include "skin/skinned_skin.h"
#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr int kSide = 13;

Character of_one_body(const TriMesh& mesh) {
  Character character;
  character.mesh = mesh;
  SkinWeights& weights = character.skin;
  for (size_t i = 0; i < mesh.vertices.size(); ++i) {
    character.map_back.push_back(static_cast<int>(i));
    weights.first.push_back(static_cast<int>(i));
    weights.link.push_back(0);
    weights.weight.push_back(1.0);
  }
  weights.first.push_back(static_cast<int>(mesh.vertices.size()));
  weights.links.push_back({0, Affine::Identity()});
  return character;
}

// A wide sheet at y = 12 mm over a wide flat muscle whose top is at 10 mm.
struct Sheet {
  Character character;
  TriMesh muscle = ball(1.0, Vec3(0, 0, 0), 48, 47);
  Surface surface;
  SkinnedSkin skin;

  template <typename Act>
  auto with_muscle(const Affine& place, Act act) const {
    Points x;
    for (const Vec3& p : muscle.vertices) x.push_back(to_point(Vec3(place * p)));
    const Bvh bvh = build_bvh(surface, x);
    return act(std::vector<Collider>{{&surface, &bvh, &x, nullptr}});
  }

  explicit Sheet(double edge = 0.008, double radius = 0.12, const SkinMaps& maps = {}) {
    for (Vec3& p : muscle.vertices) p = p.cwiseProduct(Vec3(radius, 0.01, radius));
    TriMesh mesh;
    for (int i = 0; i < kSide * kSide; ++i) {
      mesh.vertices.emplace_back(edge * (i % kSide - kSide / 2), 0.012,
                                 edge * (i / kSide - kSide / 2));
    }
    for (int row = 0; row + 1 < kSide; ++row) {
      for (int k = 0; k + 1 < kSide; ++k) {
        const int a = row * kSide + k, b = a + kSide;
        mesh.triangles.push_back({a, b, b + 1});
        mesh.triangles.push_back({a, b + 1, a + 1});
      }
    }
    character = of_one_body(mesh);
    surface = make_surface(muscle.triangles, static_cast<int>(muscle.vertices.size()));
    skin = with_muscle(Affine::Identity(), [&](const std::vector<Collider>& below) {
      return bind_skinned(character, {Affine::Identity()}, below, 1, {1}, {}, maps);
    });
  }

  // The sheet after body and muscle have moved, by 1 mm at a time, and have come to rest.
  Points moved(const Vec3& body, const Vec3& by) const {
    constexpr double kStep = 0.001;  // m
    constexpr int kAtRest = 60;      // steps
    SkinState state = initial_skinned(skin), layer = initial_layer(skin);
    const int steps = std::max(1, static_cast<int>(std::ceil((body.norm() + by.norm()) / kStep)));
    for (int k = 1; k <= steps + kAtRest; ++k) {
      const double share = std::min(1.0, static_cast<double>(k) / steps);
      Affine place = Affine::Identity();
      place.translation() = share * body;
      Affine muscle_place = Affine::Identity();
      muscle_place.translation() = share * (body + by);
      with_muscle(muscle_place, [&](const std::vector<Collider>& below) {
        step_skinned(skin, {place}, below, {}, layer, state);
        return 0;
      });
    }
    return state.x;
  }
  Vec3 middle(const Vec3& body, const Vec3& by) const {
    return to_vec(moved(body, by)[kSide * kSide / 2]);
  }
};

TEST(SkinnedSkin, StaysWhereMusclesGoAsTheWeightsDo) {
  const Sheet sheet;
  constexpr double kSame = 5e-6;  // m: Lengths::clearance, and what its neighbours take of it
  EXPECT_LT((sheet.middle(Vec3::Zero(), Vec3::Zero()) - Vec3(0, 0.012, 0)).norm(), kSame);
  EXPECT_LT((sheet.middle(Vec3(0.1, 0.2, 0.3), Vec3::Zero()) - Vec3(0.1, 0.212, 0.3)).norm(),
            kSame);
}

// By more than the thickness of the muscle.
TEST(SkinnedSkin, KeepsItsSideOfAMuscleThatComesThrough) {
  const Sheet sheet;
  for (const double way : {0.004, 0.015, 0.028}) {
    EXPECT_NEAR(sheet.middle(Vec3::Zero(), Vec3(0, way, 0)).y(), 0.012 + way, 1e-3) << way;
  }
}

// One vertex hangs on the limb and those around it on the trunk, as at a coarse character's armpit:
// it met no muscle, as none of its triangles was of the layer.
TEST(SkinnedSkin, AVertexAloneOnALimbIsKeptOutOfAMuscle) {
  Sheet sheet(0.03, 0.015);
  const int middle = kSide * kSide / 2;
  SkinWeights& weights = sheet.character.skin;
  weights.links.push_back({1, Affine::Identity()});
  for (int i = 0; i < kSide * kSide; ++i) weights.link[i] = i == middle ? 0 : 1;
  const std::vector<Affine> bodies(2, Affine::Identity());
  sheet.skin = sheet.with_muscle(bodies[0], [&](const std::vector<Collider>& below) {
    return bind_skinned(sheet.character, bodies, below, 1, {1, 0}, {});
  });
  SkinState state = initial_skinned(sheet.skin), layer = initial_layer(sheet.skin);
  constexpr double kStep = 0.001, kWay = 0.015;  // m
  for (int k = 1; k <= 60; ++k) {
    Affine place = Affine::Identity();
    place.translation().y() = std::min(k * kStep, kWay);
    sheet.with_muscle(place, [&](const std::vector<Collider>& below) {
      step_skinned(sheet.skin, bodies, below, {}, layer, state);
      return 0;
    });
  }
  EXPECT_GT(state.x[middle][1], 0.01 + kWay - 1e-3);
}

// It sinks in by more than the reach, as the weights of a bent elbow make it.
TEST(SkinnedSkin, StaysOutsideWhereItsWeightsSinkIn) {
  const Sheet sheet;
  for (const double way : {0.01, 0.025, 0.045, 0.06}) {
    EXPECT_NEAR(sheet.middle(Vec3(0, -way, 0), Vec3(0, way, 0)).y(), 0.012, 1e-3) << way;
  }
}

// A muscle that comes up in the middle of a triangle with no vertex near it, in cells of any width:
// the triangle's corners are moved as far as the layer between them is.
TEST(SkinnedSkin, CoversAMuscleBetweenItsVertices) {
  for (const double width : {0.03, 0.04, 0.05}) {  // m
    const Sheet sheet(width, 0.01);
    const int a = (kSide + 1) * (kSide / 2);  // the muscle's top is under this cell's diagonal
    for (const double way : {0.0, 0.004, 0.012, 0.02}) {
      const Vec3 to(0.425 * width, way, 0.325 * width);
      const Points x = sheet.moved(Vec3::Zero(), to);
      const double u = to.x() / width, v = to.z() / width;  // u > v: the triangle a, b + 1, a + 1
      const double y = (1.0 - u) * x[a][1] + v * x[a + kSide + 1][1] + (u - v) * x[a + 1][1];
      EXPECT_GT(y, 0.01 + way - 2e-3) << width << " " << way;
    }
  }
}

// A muscle that slides along below the skin changes nothing.
TEST(SkinnedSkin, LetsAMuscleSlide) {
  const Sheet sheet;
  EXPECT_NEAR(sheet.middle(Vec3::Zero(), Vec3(0.01, 0, 0)).y(), 0.012, 5e-4);
}

std::vector<double> everywhere(double value) { return std::vector<double>(kSide * kSide, value); }

TEST(SkinnedSkin, StandsOffByItsFat) {
  const Vec3 none = Vec3::Zero();
  const Sheet thin(0.008, 0.12, {.fat = everywhere(0.002)});
  const Sheet thick(0.008, 0.12, {.fat = everywhere(0.008)});
  const Points a = thin.moved(none, none), b = thick.moved(none, none);
  constexpr double kFacets = 5e-5;  // m, of the muscle below its ellipsoid
  EXPECT_NEAR(a[kSide * kSide / 2][1], 0.012, kFacets);
  EXPECT_NEAR(b[kSide * kSide / 2][1], 0.018, kFacets);
  for (size_t i = 0; i < thin.skin.nodes.size(); ++i) {
    EXPECT_NEAR(thin.skin.layer.fat[i], 0.002, 2e-6);
    EXPECT_NEAR(thick.skin.layer.fat[i], 0.008, 2e-6);
  }
  // The place of a muscle's point below a vertex: along the normal, which for a flat muscle is up.
  double least = 1.0, most = 0.0;
  for (size_t i = 0; i < a.size(); ++i) {
    const double by = norm(b[i] - a[i]);
    least = std::min(least, by), most = std::max(most, by);
  }
  EXPECT_NEAR(least, 0.006, 5e-4);
  EXPECT_NEAR(most, 0.006, 5e-4);
}

// Where there is none it stays as modelled.
TEST(SkinnedSkin, TakesItsFatVertexByVertex) {
  std::vector<double> half = everywhere(-1.0);
  for (int i = 0; i < kSide * kSide; ++i) {
    if (i % kSide < kSide / 2) half[i] = 0.006;
  }
  const Sheet plain, painted(0.008, 0.12, {.fat = half});
  const SkinModel& layer = painted.skin.layer;
  for (size_t i = 0; i < painted.skin.nodes.size(); ++i) {
    const auto& corners = painted.skin.nodes[i].corners;  // of a divided edge, its two ends
    if (std::all_of(corners.begin(), corners.end(), [&](int c) { return half[c] > 0.0; })) {
      EXPECT_NEAR(layer.fat[i], 0.006, 2e-6);
    } else {
      EXPECT_EQ(norm(layer.rest[i] - plain.skin.layer.rest[i]), 0.0);
    }
  }
}

// Body and muscle turn together: what fat adds turns with them.
TEST(SkinnedSkin, ItsFatTurnsWithItsBody) {
  const Sheet thick(0.008, 0.12, {.fat = everywhere(0.008)});
  const Points at_rest = thick.moved(Vec3::Zero(), Vec3::Zero());
  SkinState state = initial_skinned(thick.skin), layer = initial_layer(thick.skin);
  Affine place = Affine::Identity();
  for (int k = 1; k <= 90; ++k) {
    place.linear() = rotation_about(Vec3::UnitZ(), std::min(k, 30) * 3.0 * kDegree);
    thick.with_muscle(place, [&](const std::vector<Collider>& below) {
      step_skinned(thick.skin, {place}, below, {}, layer, state);
      return 0;
    });
  }
  for (size_t i = 0; i < at_rest.size(); ++i) {
    EXPECT_LT((to_vec(state.x[i]) - Vec3(place * to_vec(at_rest[i]))).norm(), 1e-5);
  }
}

// The muscle slides by 5 mm, and the body stays. It is so wide that it is nearly flat: a bulge half
// as wide pushes a tenth of its way before it, without friction, once the skin is at its balance.
TEST(SkinnedSkin, SticksToItsFleshOrSlidesOverIt) {
  const Vec3 along(0.005, 0, 0);
  const auto follows = [&](double slide) {
    const Sheet sheet(0.008, 0.24, {.slide = everywhere(slide)});
    return (sheet.middle(Vec3::Zero(), along).x()) / along.x();
  };
  EXPECT_NEAR(follows(0.0), 1.0, 0.005);
  EXPECT_NEAR(follows(1.0), 0.0, 0.005);
  // Of the flesh's pull 1/l^2 (l = 3 cm) and that of the anchors (12 cm); edges do not pull in the
  // middle of a sheet that goes along as a whole.
  const double pull = 1.0 / (0.03 * 0.03), anchors = 1.0 / (0.12 * 0.12);
  EXPECT_NEAR(follows(0.5), pull / (pull + anchors), 0.005);
}

// A muscle that fills the room between the two shells of a body is in no skin that is seen.
TEST(SkinnedSkin, WallsWithinTheBodyAreNotSeen) {
  const TriMesh outer = ball(0.06, Vec3(0, 0, 0), 24, 23),
                inner = ball(0.02, Vec3(0, 0, 0), 24, 23);
  const Shape muscle = make_shape(ball(0.04, Vec3(0, 0, 0), 24, 23));
  const std::vector<Collider> below = {{&muscle.surface, &muscle.bvh, &muscle.x, nullptr}};
  TriMesh mesh = outer;
  const int first = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), inner.vertices.begin(), inner.vertices.end());
  for (const Triangle& t : inner.triangles) {
    mesh.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
  const auto seen = [&](const TriMesh& of) {
    const SkinnedSkin skin = bind_skinned(of_one_body(of), {Affine::Identity()}, below, 1, {1}, {});
    Points points;
    for (size_t i = 0; i < skin.rest.size(); ++i) {
      if (skin.seen[i]) points.push_back(skin.rest[i]);
    }
    return points;
  };
  EXPECT_EQ(seen(mesh).size(), outer.vertices.size());
  EXPECT_EQ(deepest_inside(below, seen(mesh)), 0.0);
  EXPECT_NEAR(deepest_inside(below, to_points(mesh.vertices)), 0.02, 1e-3);
  // Nor does fat move them.
  const SkinMaps fat{.fat = std::vector<double>(mesh.vertices.size(), 0.004)};
  const SkinnedSkin fatter =
      bind_skinned(of_one_body(mesh), {Affine::Identity()}, below, 1, {1}, {}, fat);
  for (size_t i = 0; i < fatter.nodes.size(); ++i) {
    const bool is_outer = fatter.nodes[i].corners[0] < first;
    EXPECT_NEAR(norm(fatter.lift[i]), is_outer ? 0.016 : 0.0, 1e-3);
  }
  // Without the outer shell the inner one is seen, and is in the muscle.
  TriMesh bare = mesh;
  std::erase_if(bare.triangles, [&](const Triangle& t) { return t[0] < first; });
  EXPECT_NEAR(deepest_inside(below, seen(bare)), 0.02, 1e-3);
}

// The end of this muscle is turned inside out, as that of a muscle that is pinched in a fold may
// be. A point in front of it is not inside, although the sign of the distance to the nearest point
// says so.
TEST(SkinnedSkin, IsDeepInAMuscleOnlyWhereThatGoesRoundIt) {
  TriMesh mesh = spindle(0.0, 0.1, 24, 19, [](double, double) { return 0.01; });
  for (Vec3& p : mesh.vertices) p.z() *= p.y() > 0.093 ? -1.0 : 1.0;
  const Shape muscle = make_shape(mesh);
  const std::vector<Collider> below = {{&muscle.surface, &muscle.bvh, &muscle.x, nullptr}};
  const auto depth = [&](const Vec3& p) { return deepest_inside(below, {to_point(p)}); };
  EXPECT_NEAR(depth(Vec3(0.007, 0.05, 0.0)), 0.003, 2e-4);
  EXPECT_EQ(depth(Vec3(0.011, 0.05, 0.0)), 0.0);
  EXPECT_EQ(depth(Vec3(0.004, 0.098, 0.008)), 0.0);
  EXPECT_EQ(depth(Vec3(0.004, 0.13, 0.0)), 0.0);
}

}  // namespace
}  // namespace thew::tests
