// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>

#include "skin/contact/face_contact.h"
#include "skin/depth.h"
#include "skin/skin_passes.h"
#include "skin/surface/nearest_triangle.h"
#include "tests/property/every.h"
#include "tests/unit/skin/arm.h"

namespace thew::tests {
namespace {

constexpr double kMargin = 0.0015, kDepth = 0.004;

// A tube of 24 cm that bends in its middle, with the memory of the searches for its contacts.
struct Limb {
  Shape shape;
  Points rest;
  std::vector<char> all_free;
  std::vector<SurfacePoint> points;
  MotionHistory followed;
  ContactMemory memory, face_memory;

  explicit Limb(double radius, const Vec3& at)
      : shape(make_shape(spindle(-0.12, 0.12, 12, 23, [&](double, double) { return radius; }))) {
    for (Point& p : shape.x) p += to_point(at);
    rest = shape.x;
    all_free.assign(rest.size(), 1);
    points = rigid_points(shape.surface, rest, nullptr, 0.005);
  }
  // rad and m, from its rest pose.
  void go_to(double bend, const Vec3& by) {
    shape.x = rest;
    for (Point& p : shape.x) {
      const double angle = bend * std::clamp(0.5 + p[1] / 0.06, 0.0, 1.0);
      const Vec3 turned = Eigen::AngleAxisd(angle, Vec3::UnitX()) * to_vec(p);
      p = to_point(turned + by);
    }
    followed.advance(shape.x);
    refit_bvh(shape.surface, shape.x, shape.bvh);
    note_parts(shape.surface, shape.bvh, shape.x, followed.before, followed.parts);
  }
  Collider collider() const {
    Collider it{&shape.surface, &shape.bvh, &shape.x, &all_free, &followed, box_of(shape.x)};
    it.rigid_points = &points;
    return it;
  }
};

std::vector<Contact> contacts_of(const Limb& limb, const Limb& other, ContactMemory& memory,
                                 ContactMemory& face_memory) {
  const std::vector<Collider> colliders{limb.collider(), other.collider()};
  const ContactSettings settings{kMargin, kDepth, 6e-4};
  std::vector<Contact> contacts;
  find_contacts(colliders, 0, {1}, settings, {}, memory, contacts);
  find_face_contacts(colliders, 0, {1}, settings, {}, face_memory, contacts);
  return contacts;
}

// The nodes that a search without a motion bound finds within the margin or up to twice the depth
// inside.
std::vector<int> nodes_near(const Limb& limb, const Limb& other) {
  std::vector<int> nodes;
  for (size_t i = 0; i < limb.rest.size(); ++i) {
    const ClosestPoint near = closest_point(other.shape.surface, other.shape.bvh, other.shape.x,
                                            to_vec(limb.shape.x[i]), 1e3);
    if (near.distance < kMargin && near.distance > -2.0 * kDepth) {
      nodes.push_back(static_cast<int>(i));
    }
  }
  return nodes;
}

// Two tubes that lie along each other bend, are carried far and now and then jump into each other.
// The memory of the steps before hides no contact and saves nearly all searches.
TEST(Search, KnowsWhatCannotHaveComeNear) {
  Limb a(0.012, {0, 0, 0}), b(0.01, {0.012, 0, -0.025});
  std::mt19937 random(7);
  std::uniform_real_distribution<double> even(-1.0, 1.0);
  const auto draw = [&] {  // an order of its own, which arguments have not
    Vec3 v;
    for (int k = 0; k < 3; ++k) v[k] = even(random);
    return v;
  };
  double bend = 0.0;
  Vec3 by = Vec3::Zero(), aside = Vec3::Zero();
  std::int64_t anew = 0;
  size_t found = 0, of_faces = 0, deepest = 0;
  for (int step = 0; step < 400; ++step) {
    bend = 0.8 * (1.0 - std::cos(0.05 * step));
    by += 0.01 * Vec3(1, even(random), 0);
    aside += 1e-4 * draw();
    if (step % 40 == 30) aside = (0.012 + 0.008 * even(random)) * (Vec3(0, 0, 1) + 0.4 * draw());
    if (step % 40 == 34) aside = Vec3::Zero();
    a.go_to(bend, by);
    b.go_to(bend + 0.002 * even(random), by + aside);
    ContactMemory fresh, fresh_of_faces;
    const std::vector<Contact> known = contacts_of(a, b, a.memory, a.face_memory);
    const std::vector<Contact> all = contacts_of(a, b, fresh, fresh_of_faces);
    anew += fresh.searches + fresh_of_faces.searches;
    ASSERT_EQ(known.size(), all.size()) << "step " << step;
    std::vector<int> nodes;
    for (size_t c = 0; c < all.size(); ++c) {
      ASSERT_EQ(known[c].node, all[c].node) << "step " << step;
      ASSERT_EQ(known[c].distance, all[c].distance) << "step " << step;
      if (!all[c].of_face) nodes.push_back(all[c].node);
      of_faces += all[c].of_face;
      deepest += all[c].distance < -kDepth;
    }
    ASSERT_EQ(nodes, nodes_near(a, b)) << "step " << step;
    found += nodes.size();
  }
  const std::int64_t searches = a.memory.searches + a.face_memory.searches;
  std::printf("%zu contacts of nodes, %zu of faces, %zu deep; %ld searches, %ld anew\n", found,
              of_faces, deepest, static_cast<long>(searches), static_cast<long>(anew));
  EXPECT_GT(found, 500u);
  EXPECT_GT(of_faces, 100u);
  EXPECT_GT(deepest, 50u);
  EXPECT_LT(2 * searches, anew);
}

constexpr double kFar = 1.0;  // m

// The nearest triangle of all, one after the other.
ClosestPoint by_brute_force(const Surface& surface, const Bvh& bvh, const Points& x,
                            const Vec3& p) {
  int nearest = -1;
  double best2 = kFar * kFar;
  for (size_t k = 0; k < surface.triangles.size(); ++k) {
    const Triangle& t = surface.triangles[k];
    const double distance2 =
        nearest_on_triangle(to_vec(x[t[0]]), to_vec(x[t[1]]), to_vec(x[t[2]]), p).distance2;
    if (distance2 < best2) best2 = distance2, nearest = static_cast<int>(k);
  }
  const ClosestPoint near = closest_point(surface, bvh, x, p, kFar);
  EXPECT_EQ(near.triangle, nearest);
  EXPECT_EQ(std::abs(near.distance), std::sqrt(best2));
  return near;
}

// A made-up arm that flexes, and the searches of its skin. In each frame they are told by brute
// force for a share of the nodes: one in 13 for the flesh below, one in 19 for covers, one in 7 for
// walls.
struct Flexing {
  static constexpr int kFrames = 21;
  TestArm arm;
  SkinModel model = arm.bind({.iterations = 12, .keeps_volume = true});
  SkinState state = initial_skin(model);
  int frame = 0;

  void advance(const Loop& loop) {
    const double degrees = 115.0 * frame / (kFrames - 1);
    arm.move_to(degrees);
    step_skin(model, arm.pose(degrees), arm.colliders(), loop, state);
  }
  bool is_told(size_t node, int of) const { return (node + frame) % of == 0; }
};

void expect_flesh(const Flexing& flexing, size_t& found) {
  const SkinState& state = flexing.state;
  const SkinSettings& settings = flexing.model.settings;
  for (size_t i = 0; i < state.x.size(); ++i) {
    if (!flexing.is_told(i, every(13))) continue;
    std::vector<double> distances;
    double nearest = settings.lengths.flesh_reach;
    for (const Collider& flesh : flexing.arm.colliders()) {
      const Vec3 p = to_vec(state.x[i]);
      distances.push_back(by_brute_force(*flesh.surface, *flesh.bvh, *flesh.x, p).distance);
      nearest = std::min(nearest, std::abs(distances.back()));
    }
    const double within = std::min(settings.lengths.flesh_reach, nearest + settings.bridging);
    std::erase_if(distances, [&](double d) { return std::abs(d) > within; });
    std::sort(distances.begin(), distances.end());
    std::erase_if(distances, [&](double d) { return d > distances[0] + settings.bridging; });
    ASSERT_EQ(state.planes.count[i], static_cast<int>(distances.size())) << "node " << i;
    for (size_t k = 0; k < distances.size(); ++k) {
      const FleshPlanes::Plane& plane = state.planes.planes[i][k];
      ASSERT_NEAR(plane.normal.dot(to_vec(state.x[i])) - plane.offset, distances[k], 1e-12);
    }
    found += distances.size();
  }
}

void expect_covers(const Flexing& flexing, size_t& found) {
  const SkinState& state = flexing.state;
  const Lengths& lengths = flexing.model.settings.lengths;
  size_t node = 0, covers = 0;
  std::set<int> crossing;  // where the skin crosses itself a node comes out of it without a trace
  for (const auto& pair : crossing_triangles(flexing.model.surface, state.bvh, state.x,
                                             flexing.model.surface, state.bvh, state.x)) {
    crossing.insert(pair.begin(), pair.end());
  }
  for (const Collider& flesh : flexing.arm.colliders()) {
    for (const Point& x : *flesh.x) {
      covers += state.covered[node];
      if (flexing.is_told(node, every(19))) {
        const ClosestPoint near =
            by_brute_force(flexing.model.surface, state.bvh, state.x, to_vec(x));
        // The nearest normal says nothing of the side where the skin is turned inside out.
        const bool is_inside = crossing.empty()
                                   ? near.distance < 0.0
                                   : encloses(flexing.model.surface, state.bvh, state.x, to_vec(x));
        const double distance = is_inside ? -std::abs(near.distance) : std::abs(near.distance);
        const bool covered = distance <= lengths.cover_reach && distance >= -lengths.cover_depth;
        const bool is_clear = !crossing.contains(near.triangle);
        if (is_clear) {
          ASSERT_EQ(state.covered[node], covered) << "node " << node;
          if (covered) {
            ASSERT_EQ(state.cover_over[node].triangle, near.triangle);
          }
        }
        found += covered;
      }
      ++node;
    }
  }
  ASSERT_EQ(state.covers.size(), covers);
}

void expect_walls(const Flexing& flexing, size_t& found) {
  const SkinState& state = flexing.state;
  const std::vector<Triangle>& triangles = flexing.model.surface.triangles;
  for (size_t i = 0; i < state.x.size(); ++i) {
    if (!flexing.is_told(i, every(7))) continue;
    const int node = static_cast<int>(i);
    int wall = -1;
    double nearest = flexing.model.settings.lengths.fold_reach;
    for (size_t t = 0; t < triangles.size(); ++t) {
      const Triangle& c = triangles[t];
      if (c[0] == node || c[1] == node || c[2] == node) continue;
      const Point sum = state.normals[c[0]] + state.normals[c[1]] + state.normals[c[2]];
      if (to_vec(sum).dot(to_vec(state.normals[i])) > 0.0) continue;
      const double away = std::abs(closest_on_triangle(flexing.model.surface, state.x,
                                                       static_cast<int>(t), to_vec(state.x[i]))
                                       .distance);
      if (away > nearest || (away == nearest && wall >= 0)) continue;
      nearest = away;
      wall = static_cast<int>(t);
    }
    ASSERT_EQ(state.walls[i].triangle, wall) << "node " << i;
    found += wall >= 0;
  }
}

TEST(SkinSearch, FindsWhatBruteForceFinds) {
  Flexing flexing;
  size_t flesh = 0, covers = 0, walls = 0;
  for (; flexing.frame < Flexing::kFrames; ++flexing.frame) {
    flexing.advance({});
    const auto colliders = flexing.arm.colliders();
    find_flesh_below(flexing.model, colliders, true, {}, flexing.state);
    const double depth = flexing.model.settings.lengths.cover_depth;
    find_covers(flexing.model, colliders, depth, depth, true, {}, flexing.state);
    find_folds(flexing.model, {}, flexing.state);
    expect_flesh(flexing, flesh);
    expect_covers(flexing, covers);
    expect_walls(flexing, walls);
    // Later searches look again only for what the skin may have come near.
    SkinState& state = flexing.state;
    const Points before = state.x;
    for (int search = 1; search <= 3; ++search) {
      for (size_t i = 0; i < before.size(); ++i) {
        const double by = 4e-4 * search * (static_cast<int>(i + search) % 3 - 1);
        state.x[i] = before[i] + by * state.normals[i];
      }
      find_covers(flexing.model, colliders, depth, 0.0, false, {}, state);
      expect_covers(flexing, covers);
    }
    state.x = before;
    if (HasFatalFailure()) return;
  }
  std::printf("%zu planes, %zu covers, %zu walls\n", flesh, covers, walls);
  EXPECT_GT(flesh, 10000u);
  EXPECT_GT(covers, 200u);
  EXPECT_GT(walls, 20u);
}

TEST(SkinStep, HasTheSameBytesInWhateverOrderItsLoopsRun) {
  Flexing forwards, backwards;
  const Loop reversed(nullptr, [](void*, int count, Loop::Call call, const void* work) {
    for (int i = count; i-- > 0;) call(work, i);
  });
  for (; forwards.frame < Flexing::kFrames; forwards.frame = ++backwards.frame) {
    forwards.advance({});
    backwards.advance(reversed);
    const Points &x = forwards.state.x, &y = backwards.state.x;
    ASSERT_EQ(std::memcmp(x.data(), y.data(), x.size() * sizeof(Point)), 0)
        << "frame " << forwards.frame;
  }
}

}  // namespace
}  // namespace thew::tests
