// SPDX-License-Identifier: Apache-2.0
//
// What measure() states against the plain definitions of it, node by node and pair by pair, to the
// last bit: on the folding arm, on characters with and without holes, and on both with their
// muscles pushed into one another and out through the skin.
#include <random>

#include "sim/bake/measure.h"
#include "sim/solver/contacts.h"
#include "skin/depth.h"
#include "tests/property/every.h"
#include "tests/unit/tools/fit/new_figure.h"

namespace thew::tests {
namespace {

// Boxes in their order along the longest side of all, so that most of those beside another box need
// not be looked at.
struct SortedBoxes {
  const std::vector<NodeBox>& boxes;
  int axis = 0;
  double longest = 0.0;  // m, of a box along the axis
  std::vector<int> order;

  SortedBoxes(const std::vector<NodeBox>& boxes, const NodeBox& all) : boxes(boxes) {
    for (int k = 1; k < 3; ++k) {
      if (all.high[k] - all.low[k] > all.high[axis] - all.low[axis]) axis = k;
    }
    for (int i = 0; i < static_cast<int>(boxes.size()); ++i) {
      order.push_back(i);
      longest = std::max(longest, boxes[i].high[axis] - boxes[i].low[axis]);
    }
    std::sort(order.begin(), order.end(), [&](int i, int j) { return low(i) < low(j); });
  }
  double low(int i) const { return boxes[i].low[axis]; }
  template <typename Visit>
  void each_near(const NodeBox& box, Visit visit) const {
    const double first = box.low[axis] - longest - 1e-9;
    const auto begin = std::lower_bound(order.begin(), order.end(), first,
                                        [&](int i, double value) { return low(i) < value; });
    for (auto i = begin; i != order.end() && low(*i) <= box.high[axis]; ++i) {
      if (are_near(box, boxes[*i], 0.0)) visit(*i);
    }
  }
};

// Pairs of triangles that cross, each with each. `counts` says whether a pair does.
template <typename Counts>
int crossings(const Collider& a, const Collider& b, Counts counts) {
  const bool itself = a.surface == b.surface;
  const auto boxes = [](const Collider& of) {
    std::vector<NodeBox> out;
    for (const Triangle& t : of.surface->triangles) {
      NodeBox& box = out.emplace_back(empty_box());
      for (const int i : t) grow(box, (*of.x)[i], (*of.x)[i]);
    }
    return out;
  };
  const std::vector<NodeBox> mine = boxes(a), theirs = boxes(b);
  const NodeBox all = box_of(*b.x);
  const SortedBoxes sorted(theirs, all);
  int count = 0;
  for (int i = 0; i < static_cast<int>(mine.size()); ++i) {
    if (!are_near(mine[i], all, 0.0)) continue;
    const Triangle& s = a.surface->triangles[i];
    sorted.each_near(mine[i], [&](int j) {
      if ((itself && j <= i) || !counts(i, j)) return;
      const Triangle& t = b.surface->triangles[j];
      if (itself && std::find_first_of(s.begin(), s.end(), t.begin(), t.end()) != s.end()) return;
      count += are_crossing(*a.surface, *a.x, *b.surface, *b.x, {i, j});
    });
  }
  return count;
}

// Area of the section across the belly, triangle by triangle.
double section(const Muscle& muscle, const CarriedPose& pose, const Points& x, double u) {
  const auto& belly = muscle.shape.belly;
  const double length = belly[1] - belly[0], along = belly[0] + u * length;
  const double reach = std::max(0.35 * length, muscle.shape.lengths.section_reach);
  Vec3 point, tangent;
  curve_at(muscle.shape, pose, along, point, tangent);
  double area = 0.0;
  for (const Triangle& t : muscle.rest.triangles) {
    double height[3];
    bool near = true;
    for (int k = 0; k < 3; ++k) {
      near = near && std::abs(muscle.shape.along[t[k]] - along) < reach;
      height[k] = tangent.dot(to_vec(x[t[k]]) - point);
    }
    Vec3 in = Vec3::Zero(), out = Vec3::Zero();
    int cuts = 0;
    for (int k = 0; near && k < 3; ++k) {
      const int next = (k + 1) % 3;
      if ((height[k] < 0.0) == (height[next] < 0.0)) continue;
      const double s = height[k] / (height[k] - height[next]);
      const Vec3 p = (1.0 - s) * to_vec(x[t[k]]) + s * to_vec(x[t[next]]) - point;
      (height[k] < 0.0 ? in : out) = p;
      ++cuts;
    }
    if (cuts == 2) area += 0.5 * tangent.dot(out.cross(in));
  }
  return std::abs(area);
}

// The figures of bodies against one another, and sections, by their definitions.
FrameMeasures plain(const Model& model, const Measuring& measuring, const State& state) {
  FrameMeasures out;
  out.muscles.resize(state.muscles.size());
  const std::vector<Collider> bodies = colliders_of(model, state);
  for (int m = 0; m < state.count(); ++m) {
    const Muscle& muscle = model.muscles[m];
    const MuscleState& now = state.muscles[m];
    constexpr int kSections = 24;
    double area = 0.0;
    for (int k = 0; k < kSections; ++k) {
      area += section(muscle, now.pose, now.x, (k + 0.5) / kSections);
    }
    out.muscles[m].area_ratio = area / kSections / measuring.rest_areas[m];
    Points free;
    for (size_t i = 0; i < now.x.size(); ++i) {
      if (!muscle.driven[i]) free.push_back(now.x[i]);
    }
    const auto is_free = [&](int body, int triangle) {
      if (body >= state.count()) return false;
      const Triangle& t = model.muscles[body].rest.triangles[triangle];
      return std::any_of(t.begin(), t.end(), [&](int i) { return !model.muscles[body].driven[i]; });
    };
    for (int other = 0; other < model.colliders(); ++other) {
      if (model.ignore[m][other]) continue;
      const Collider& it = bodies[other];
      if (other != m) {
        double& depth = out.muscles[m].penetration;
        depth = std::max(depth, deepest_inside(*it.surface, *it.bvh, *it.x, free));
      }
      if (other < m) continue;
      out.intersecting_pairs += crossings(
          bodies[m], it, [&](int i, int j) { return is_free(m, i) || is_free(other, j); });
    }
  }
  Collider skin{model.skinned ? &model.skinned->surface : &model.skin.surface, &state.skin.bvh,
                &state.skin.x};
  const std::vector<Collider> below = model.skinned ? muscles_of(model, state) : bodies;
  Points seen;  // the others may lie in muscle
  for (size_t i = 0; i < state.skin.x.size(); ++i) {
    if (!model.skinned || model.skinned->seen[i]) seen.push_back(state.skin.x[i]);
  }
  out.skin.max_penetration = deepest_inside(below, seen);
  for (const Collider& flesh : below) {
    out.skin.max_poke_through = std::max(
        out.skin.max_poke_through, farthest_outside(*skin.surface, *skin.bvh, *skin.x, *flesh.x));
  }
  if (!model.skinned) {
    out.skin.intersecting_pairs = crossings(skin, skin, [](int, int) { return true; });
  }
  return out;
}

// How much was found in all frames, so that the test is seen to compare something.
struct Found {
  int crossings = 0;
  double depth = 0.0, penetration = 0.0, poke_through = 0.0;
};

void expect_plain(const Model& model, Measuring& measuring, State& state, Found& found) {
  Parallel two(2);
  const FrameMeasures now = measure(model, measuring, two, state);
  const FrameMeasures expected = plain(model, measuring, state);
  for (size_t m = 0; m < now.muscles.size(); ++m) {
    EXPECT_EQ(now.muscles[m].area_ratio, expected.muscles[m].area_ratio) << model.muscles[m].name;
    EXPECT_EQ(now.muscles[m].penetration, expected.muscles[m].penetration) << model.muscles[m].name;
    found.depth = std::max(found.depth, now.muscles[m].penetration);
  }
  EXPECT_EQ(now.intersecting_pairs, expected.intersecting_pairs);
  // The plain definition does not tell covered vertices from bare ones.
  EXPECT_EQ(std::max(now.skin.max_penetration, now.skin.max_covered_penetration),
            expected.skin.max_penetration);
  EXPECT_EQ(now.skin.max_poke_through, expected.skin.max_poke_through);
  EXPECT_EQ(now.skin.intersecting_pairs, expected.skin.intersecting_pairs);
  found.crossings += now.intersecting_pairs + now.skin.intersecting_pairs;
  found.penetration = std::max(found.penetration, now.skin.max_penetration);
  found.poke_through = std::max(found.poke_through, now.skin.max_poke_through);
}

// Each muscle is moved aside, and each node of the skin a little by itself.
void push(std::mt19937& random, State& state) {
  std::uniform_real_distribution<double> along(-1.0, 1.0);
  const auto anywhere = [&](double reach) {
    return Point{reach * along(random), reach * along(random), reach * along(random), 0.0};
  };
  for (MuscleState& muscle : state.muscles) {
    const Point by = anywhere(0.008);
    for (Point& x : muscle.x) x += by;
  }
  for (Point& x : state.skin.x) x += anywhere(0.001);
}

// Steps to `last`, and compares every eighth frame as it is and every 24th also pushed, or each
// and every third: the plain definitions take many times as long as the steps.
Found compare(const Model& model, int last) {
  Parallel parallel(2);
  State state = initial_state(model);
  Measuring measuring = start_measuring(model, state);
  settle(model, parallel, state);
  StageSeconds seconds;
  std::mt19937 random(7);
  Found found;
  for (int f = 0; f <= last; ++f) {
    SCOPED_TRACE("frame " + std::to_string(model.first_frame + f));
    if (f > 0) step_frame(model, f / model.fps, parallel, state, seconds);
    if (f % every(8) != 0) continue;
    expect_plain(model, measuring, state, found);
    if (f % (3 * every(8)) != 0) continue;
    State pushed = state;
    push(random, pushed);
    expect_plain(model, measuring, pushed, found);
  }
  return found;
}

TEST(Measure, StatesOfTheArmWhatEachNodeAndPairSays) {
  const Model model = build_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {}));
  const Found found = compare(model, 60);
  EXPECT_GT(found.crossings, 100);
  EXPECT_GT(found.depth, 1e-3);
  EXPECT_GT(found.penetration, 1e-3);
  EXPECT_GT(found.poke_through, 1e-3);
}

class MeasureCharacter : public NewScene {
 protected:
  Found compare_figure(const Figure& figure) {
    const fs::path file = folder / "figure.gltf";
    figure.write(file);
    const NewOptions options = asked(file, "both");
    EXPECT_EQ(new_command(options), ExitCode::kDone);
    return compare(build_model(read_scene(options.out, {"contact.self=[\"brachialis_left\"]"})),
                   40);
  }
};

TEST_F(MeasureCharacter, StatesWhatEachNodeAndPairSays) {
  const Found found = compare_figure(Figure());
  EXPECT_GT(found.crossings, 100);
  EXPECT_GT(found.depth, 1e-3);
  EXPECT_GT(found.penetration, 1e-3);
  EXPECT_GT(found.poke_through, 1e-3);
}

// Rays along x meet the holes at the neck and the waist, and the left hand's muscles stand beside
// the one at the wrist.
TEST_F(MeasureCharacter, StatesItOfASkinWithHoles) {
  Figure figure;
  figure.meshes[0].cut([](const Vec3& p) { return p.y() < 1.1 && std::abs(p.x()) < 0.3; });
  figure.meshes[0].cut([](const Vec3& p) { return p.y() > 1.5; });
  const Found found = compare_figure(figure);
  EXPECT_GT(found.penetration, 1e-3);
  EXPECT_GT(found.poke_through, 1e-3);
}

}  // namespace
}  // namespace thew::tests
