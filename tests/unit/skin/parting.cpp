// SPDX-License-Identifier: Apache-2.0
#include "skin/contact/parting.h"

#include <gtest/gtest.h>

#include "tests/unit/skin/shapes.h"

namespace thew::tests {
namespace {

constexpr double kLongest = 3.5e-4;  // m, of a step

Shape tube() {
  return make_shape(spindle(-0.05, 0.05, 24, 17, [](double, double) { return 0.01; }));
}

struct Two {
  Shape a = tube(), b = tube();
  std::vector<char> free_a = std::vector<char>(a.x.size(), 1), free_b = free_a;
  Parting of_a, of_b;
  std::vector<std::array<int, 2>> pairs;

  // b beside a and askew, so far (m) in it.
  explicit Two(double deep) {
    for (Point& p : b.x) {
      p = Point{p[0] + 0.02 - deep, 0.92 * p[1] - 0.39 * p[2], 0.39 * p[1] + 0.92 * p[2] + 0.003,
                0.0};
    }
  }
  static Collider body(Shape& shape, std::vector<char>* free) {
    refit_bvh(shape.surface, shape.x, shape.bvh);
    return {&shape.surface, &shape.bvh, &shape.x, free};
  }
  // Finds what crosses; b is a bone without `of_b`.
  size_t find(bool soft) {
    const Collider one = body(a, &free_a), two = body(b, soft ? &free_b : nullptr);
    begin_parting(one, of_a);
    begin_parting(two, of_b);
    find_partable(one, two, soft, pairs);
    push_apart(one, of_a, two, soft ? &of_b : nullptr, pairs, kLongest);
    return pairs.size();
  }
};

double farthest(const Points& x, const Points& from) {
  double most = 0.0;
  for (size_t i = 0; i < x.size(); ++i) most = std::max(most, norm(x[i] - from[i]));
  return most;
}

TEST(Parting, TwoSoftBodiesGiveWayToOneAnother) {
  Two two(4e-4);
  const Points a = two.a.x, b = two.b.x;
  ASSERT_GT(two.find(true), 0u);
  int rounds = 0;
  for (; two.find(true) > 0 && rounds < 20; ++rounds) {
    part(two.of_a, two.a.x);
    part(two.of_b, two.b.x);
  }
  EXPECT_LE(rounds, 8);
  const double of_a = farthest(two.a.x, a), of_b = farthest(two.b.x, b);
  EXPECT_LT(of_a, 1e-3);
  EXPECT_LT(of_b, 1e-3);
  EXPECT_GT(of_a + of_b, 3e-4);  // no less than they were deep, all but the roundness of the tubes
}

TEST(Parting, ABoneStaysAndTheMuscleGoes) {
  Two two(4e-4);
  const Points bone = two.b.x;
  int rounds = 0;
  for (; two.find(false) > 0 && rounds < 20; ++rounds) part(two.of_a, two.a.x);
  EXPECT_LE(rounds, 12);
  EXPECT_EQ(farthest(two.b.x, bone), 0.0);
}

// m: as deep as they first cross, by halving.
double touching() {
  double apart = -1e-3, crossing = 4e-4;
  for (int i = 0; i < 50; ++i) {
    const double middle = 0.5 * (apart + crossing);
    (Two(middle).find(true) > 0 ? crossing : apart) = middle;
  }
  return crossing;
}

// What hardly crosses hardly moves: no difference of rounding is made a millimetre of.
TEST(Parting, StepsGoToZeroWithTheDepth) {
  const double touch = touching();
  double before = 1.0;
  for (const double deep : {1e-4, 1e-5, 1e-6, 1e-7}) {
    Two two(touch + deep);
    ASSERT_GT(two.find(true), 0u) << deep;
    const Points a = two.a.x;
    part(two.of_a, two.a.x);
    const double step = farthest(two.a.x, a);
    EXPECT_GT(step, 0.0);
    EXPECT_LE(step, 8.0 * deep);
    EXPECT_LT(step, before);
    before = step;
  }
}

TEST(Parting, WhatIsApartOrAttachedIsLeft) {
  Two apart(-1e-4);
  EXPECT_EQ(apart.find(true), 0u);
  const Points before = apart.a.x;
  part(apart.of_a, apart.a.x);
  EXPECT_EQ(farthest(apart.a.x, before), 0.0);
  Two attached(4e-4);
  attached.free_a.assign(attached.free_a.size(), 0);
  attached.free_b = attached.free_a;
  EXPECT_EQ(attached.find(true), 0u);
}

}  // namespace
}  // namespace thew::tests
