// SPDX-License-Identifier: Apache-2.0
//
// The skin of a dense figure in the fold of its elbow: edges against what the weights alone make.
#include <algorithm>
#include <map>

#include "sim/bake/measure.h"
#include "tests/unit/tools/fit/new_figure.h"

namespace thew::tests {
namespace {

// Each triangle in four, with the weights between those of its corners.
void refine(Figure::Mesh& mesh) {
  std::map<std::array<int, 2>, int> middles;
  const auto middle = [&](int a, int b) {
    const auto [found, is_new] =
        middles.insert({{std::min(a, b), std::max(a, b)}, static_cast<int>(mesh.positions.size())});
    if (!is_new) return found->second;
    std::map<int, float> shares;
    for (const int v : {a, b}) {
      for (int k = 0; k < 4; ++k) shares[mesh.joints[v][k]] += 0.5f * mesh.weights[v][k];
    }
    std::erase_if(shares, [](const auto& share) { return share.second <= 0.0f; });
    EXPECT_LE(shares.size(), 4u);
    std::array<std::uint8_t, 4> joints{};
    std::array<float, 4> weights{};
    int k = 0;
    for (const auto& [joint, weight] : shares) {
      joints[k] = static_cast<std::uint8_t>(joint), weights[k++] = weight;
    }
    mesh.positions.push_back(0.5 * (mesh.positions[a] + mesh.positions[b]));
    mesh.joints.push_back(joints);
    mesh.weights.push_back(weights);
    return found->second;
  };
  std::vector<Triangle> finer;
  for (const auto& [a, b, c] : mesh.triangles) {
    const int p = middle(a, b), q = middle(b, c), r = middle(c, a);
    finer.insert(finer.end(), {{a, p, r}, {p, b, q}, {r, q, c}, {p, q, r}});
  }
  mesh.triangles.swap(finer);
}

double fold_of(const Surface& surface, const Points& x, int a, int b) {
  const Vec3 u = face_normal(surface, x, a), v = face_normal(surface, x, b);
  return std::atan2(u.cross(v).norm(), u.dot(v));
}

// Edges that are folded by more than 40 degrees beyond what the weights alone fold them.
int sharp_edges(const SkinnedSkin& skin, const Points& x, const Points& carried) {
  int count = 0;
  for (int t = 0; t < static_cast<int>(skin.surface.triangles.size()); ++t) {
    for (const int u : skin.surface.neighbours[t]) {
      if (u <= t) continue;
      count += fold_of(skin.surface, x, t, u) > fold_of(skin.surface, carried, t, u) + 40 * kDegree;
    }
  }
  return count;
}

// There were 41 in a frame; none is wanted, and 7 are left.
TEST_F(NewScene, DenseSkinHasFewFinsInTheFold) {
  Figure figure;
  refine(figure.meshes[0]);
  figure.write(folder / "figure.gltf");
  MadeArm arm(asked(folder / "figure.gltf", "right"));
  const SkinnedSkin& skin = *arm.model.skinned;
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  Points carried;
  int sharp = 0;
  double out = 0.0;
  for (int frame = 1; frame <= 36; ++frame) {
    arm.step(frame);
    skin_vertices(skin.weights, skin.mesh, arm.state.bodies, carried);
    sharp = std::max(sharp, sharp_edges(skin, arm.state.skin.x, carried));
    out =
        std::max(out, measure(arm.model, measuring, arm.parallel, arm.state).skin.max_poke_through);
  }
  std::printf("%zu triangles, %d edges too sharp, muscle %.2f mm outside\n",
              skin.surface.triangles.size(), sharp, 1e3 * out);
  EXPECT_LE(sharp, 7);
  EXPECT_LT(out, 2e-3);
}

// To the fold and back: skin was up to 9 mm in muscle in it.
TEST_F(NewScene, SkinAndMusclesKeepTheirSidesInTheFold) {
  MadeArm arm(asked(kFigure, "both"));
  Measuring measuring = start_measuring(arm.model, initial_state(arm.model));
  double in = 0.0, out = 0.0;
  for (int frame = 1; frame <= 72; ++frame) {
    arm.step(frame);
    const SkinMetrics now = measure(arm.model, measuring, arm.parallel, arm.state).skin;
    in = std::max(in, now.max_penetration);
    out = std::max(out, now.max_poke_through);
  }
  std::printf("skin %.2f mm in muscle, muscle %.2f mm outside\n", 1e3 * in, 1e3 * out);
  EXPECT_LT(in, 1e-4);
  EXPECT_LT(out, 1e-4);
}

}  // namespace
}  // namespace thew::tests
