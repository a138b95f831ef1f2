// SPDX-License-Identifier: Apache-2.0
// The public interface, as a stranger sees it: no header of ours but the installed ones.
#include <gtest/gtest.h>
#include <thew/thew.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

namespace {

using thew::Error;
using thew::ErrorCode;

const std::filesystem::path kOneMuscle =
    std::filesystem::path(THEW_SOURCE_DIR) / "tests/scenes/one_muscle/scene.toml";

class Api : public testing::Test {
 protected:
  Api() {
    folder_ =
        std::filesystem::path(testing::TempDir()) /
        ("thew_api_" + std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) +
         "_" + std::to_string(getpid()));
    std::filesystem::remove_all(folder_);
  }
  ~Api() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_;
};

template <typename Call>
void expect_error(ErrorCode code, const std::string& part, const Call& call) {
  try {
    call();
    ADD_FAILURE() << "nothing was thrown, expected: " << part;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

thew::Mesh box(const thew::Vector3& low, const thew::Vector3& high) {
  thew::Mesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.positions.insert(mesh.positions.end(), {(i & 1 ? high : low)[0], (i & 2 ? high : low)[1],
                                                 (i & 4 ? high : low)[2]});
  }
  mesh.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                    2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return mesh;
}

// A tube of square section along -y with `rings` rings of four vertices, closed at both ends.
thew::Mesh tube(double x, double top, double bottom, double half, int rings) {
  thew::Mesh mesh;
  for (int ring = 0; ring < rings; ++ring) {
    const double y = top + (bottom - top) * ring / (rings - 1);
    for (const auto& [dx, dz] : {std::pair(1, 1), {1, -1}, {-1, -1}, {-1, 1}}) {
      mesh.positions.insert(mesh.positions.end(), {x + dx * half, y, dz * half});
    }
  }
  const auto quad = [&](int a, int b, int c, int d) {
    mesh.triangles.insert(mesh.triangles.end(), {a, b, c, a, c, d});
  };
  for (int ring = 0; ring + 1 < rings; ++ring) {
    for (int k = 0; k < 4; ++k) {
      const int a = 4 * ring + k, b = 4 * ring + (k + 1) % 4;
      quad(a, a + 4, b + 4, b);
    }
  }
  const int end = 4 * (rings - 1);
  quad(0, 1, 2, 3);
  quad(end + 3, end + 2, end + 1, end);
  return mesh;
}

// All that a definition can say.
thew::SceneDefinition elbow() {
  thew::SceneDefinition scene;
  scene.name = "elbow";
  scene.last_frame = 6;
  scene.settle = 0.5;
  scene.bodies = {{.name = "humerus"},
                  {.name = "ulna",
                   .parent = "humerus",
                   .joint = {.kind = thew::Joint::Kind::kHinge,
                             .name = "elbow",
                             .position = {0, -0.3, 0},
                             .upper = 2.4}}};
  scene.clip = {{"elbow"}, {1, 6}, {0, 0.8}};
  scene.muscles = {
      {.name = "flexor",
       .mesh = tube(0.04, -0.03, -0.35, 0.008, 17),
       .path = {{"humerus", {0.04, -0.03, 0}}, {"ulna", {0.04, -0.05, 0}}},
       .wraps = {{.segment = 0, .body = "humerus", .centre = {0, -0.3, 0}, .radius = 0.03}},
       .belly = {0.06, 0.26}}};
  return scene;
}

std::vector<double> last_frame(const thew::SceneDefinition& definition) {
  thew::Simulation simulation{thew::Scene(definition)};
  while (simulation.step() < definition.last_frame) continue;
  return simulation.positions("flexor");
}

double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  EXPECT_EQ(a.size(), b.size());
  double most = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) most = std::max(most, std::fabs(a[i] - b[i]));
  return most;
}

TEST_F(Api, AMeshHasItsVolumeAndItsDefects) {
  thew::Mesh cube = box({0, 0, 0}, {1, 1, 1});
  EXPECT_DOUBLE_EQ(thew::enclosed_volume(cube.positions, cube.triangles), 1.0);
  EXPECT_TRUE(thew::find_defects(cube).empty());
  cube.triangles.resize(cube.triangles.size() - 3);
  ASSERT_FALSE(thew::find_defects(cube).empty());
  EXPECT_EQ(thew::find_defects(cube)[0].count, 3);
  cube.triangles[0] = 8;
  expect_error(ErrorCode::kUsage, "vertex 8 of 8",
               [&] { thew::enclosed_volume(cube.positions, cube.triangles); });
  cube.positions.pop_back();
  expect_error(ErrorCode::kUsage, "23 numbers", [&] { thew::find_defects(cube); });
}

TEST_F(Api, AMeshIsReadInBothOrders) {
  std::filesystem::create_directories(folder_);
  const std::filesystem::path file = folder_ / "a.obj";
  std::ofstream(file) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 0\nv 1 0 0\nv 0 0 1\n"
                         "f 1 3 2\nf 4 5 6\n";
  const thew::MeshFile mesh = thew::read_mesh(file);
  EXPECT_EQ(mesh.welded.positions.size(), 3u * 4);
  EXPECT_EQ(mesh.in_file_order.positions.size(), 3u * 6);
  EXPECT_EQ(mesh.in_file_order.triangles, (std::vector<int>{0, 2, 1, 3, 4, 5}));
  EXPECT_EQ(mesh.welded_vertex, (std::vector<int>{0, 1, 2, 0, 1, 3}));
  expect_error(ErrorCode::kInput, "missing", [] { thew::read_mesh("missing.obj"); });
}

TEST_F(Api, TheGradientIsThatOfTheVolume) {
  thew::Mesh mesh = tube(0.04, -0.03, -0.35, 0.008, 5);
  const std::vector<double> gradient = thew::volume_gradient(mesh.positions, mesh.triangles);
  for (std::size_t i = 0; i < gradient.size(); ++i) {
    const double h = 1e-4, at = mesh.positions[i];
    mesh.positions[i] = at + h;
    const double above = thew::enclosed_volume(mesh.positions, mesh.triangles);
    mesh.positions[i] = at - h;
    const double below = thew::enclosed_volume(mesh.positions, mesh.triangles);
    mesh.positions[i] = at;
    EXPECT_NEAR(gradient[i], (above - below) / (2 * h), 1e-14);
  }
}

TEST_F(Api, AVolumeIsRestoredExactlyWhereTheWeightsSay) {
  const thew::Mesh rest = tube(0.0, 0.1, -0.1, 0.01, 9);
  const double volume = thew::enclosed_volume(rest.positions, rest.triangles);
  const std::size_t nodes = rest.positions.size() / 3;
  std::vector<double> squeezed = rest.positions, weights(nodes, 1.0), inverse_mass(nodes, 20.0);
  for (std::size_t i = 0; i < squeezed.size(); i += 3) squeezed[i] *= 0.3;
  weights[20] = 0.0;
  inverse_mass[0] = 0.0;
  std::vector<double> x = squeezed;
  const thew::RestoredVolume done =
      thew::restore_volume(x, rest.triangles, weights, inverse_mass, volume);
  EXPECT_TRUE(done.reached);
  EXPECT_NE(done.multiplier, 0.0);
  EXPECT_NEAR(thew::enclosed_volume(x, rest.triangles) / volume, 1.0, 1e-14);
  EXPECT_DOUBLE_EQ(done.volume, thew::enclosed_volume(x, rest.triangles));
  for (const std::size_t i : {0, 20}) {
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(x[3 * i + k], squeezed[3 * i + k]);
  }
  const std::vector<double> gradient = thew::volume_gradient(squeezed, rest.triangles);
  EXPECT_NEAR(x[3 * 17] - squeezed[3 * 17], done.multiplier * 20.0 * gradient[3 * 17], 1e-15);
}

TEST_F(Api, AVolumeThatNoMotionReachesIsSaidSo) {
  thew::Mesh cube = box({0, 0, 0}, {1, 1, 1});
  const std::vector<double> held(8, 0.0);
  EXPECT_FALSE(thew::restore_volume(cube.positions, cube.triangles, {}, held, 2.0).reached);
  EXPECT_EQ(cube.positions, box({0, 0, 0}, {1, 1, 1}).positions);
  const std::vector<double> seven(7, 1.0);
  expect_error(ErrorCode::kUsage, "inverse_mass has 7 values for 8 vertices",
               [&] { thew::restore_volume(cube.positions, cube.triangles, {}, seven, 2.0); });
}

TEST_F(Api, ABakeIsWhatASimulationSteps) {
  const thew::Scene scene = thew::Scene::read(kOneMuscle);
  EXPECT_EQ(scene.info().meshes, std::vector<std::string>{"flexor"});
  EXPECT_EQ(scene.info().joints, std::vector<std::string>{"elbow"});
  const thew::Bake bake(thew::bake(scene, folder_));
  const thew::BakeContents& contents = bake.contents();
  EXPECT_EQ(contents.frames.size(), 24u);
  EXPECT_EQ(contents.hash.size(), 32u);
  thew::Simulation simulation(scene, 2);
  simulation.settle();
  for (int frame = 1;; frame = simulation.step()) {
    EXPECT_EQ(simulation.positions("flexor"), bake.positions("flexor", frame)) << frame;
    EXPECT_EQ(simulation.measures().at("length/flexor"),
              bake.measure("length/flexor")[static_cast<std::size_t>(frame - 1)]);
    if (frame == 24) break;
  }
  EXPECT_NEAR(simulation.joints()[0], 1.0471975511965976, 1e-12);
  EXPECT_EQ(simulation.triangles("flexor"), contents.meshes[0].rest.triangles);
  EXPECT_EQ(simulation.measures().size(), contents.measures.size());
  EXPECT_EQ(contents.meshes[0].kind, thew::BakedMesh::Kind::kMuscle);
  EXPECT_EQ(contents.meshes[0].weights.size() * 3, contents.meshes[0].rest.positions.size());
}

TEST_F(Api, AFrameThatStandsByItselfIsThatOfTheBake) {
  const thew::Scene scene = thew::Scene::read(kOneMuscle, {"solver.integrator=quasi_static"});
  const thew::Bake bake(thew::bake(scene, folder_, {.frames = {1, 2, 13}}));
  thew::Simulation simulation(scene);
  simulation.settle();
  EXPECT_EQ(simulation.positions("flexor"), bake.positions("flexor", 1));
  EXPECT_EQ(simulation.step(), 2);
  EXPECT_EQ(simulation.positions("flexor"), bake.positions("flexor", 2));
  simulation.step_to(12 / 24.0);  // without the frames between
  EXPECT_EQ(simulation.positions("flexor"), bake.positions("flexor", 13));
}

TEST_F(Api, ASimulationIsSteppedToAnyLaterTime) {
  thew::Simulation simulation(thew::Scene::read(kOneMuscle, {"scene.settle=0.5"}));
  EXPECT_LT(simulation.time(), 0.0);
  simulation.step_to(0.1);
  EXPECT_EQ(simulation.time(), 0.1);
  expect_error(ErrorCode::kUsage, "give a later time", [&] { simulation.step_to(0.1); });
  EXPECT_EQ(simulation.step(), 4);  // at 0.125 s
  expect_error(ErrorCode::kUsage, "did you mean", [&] { simulation.positions("flexo"); });
}

TEST_F(Api, ABakeIsStoppedAndGoneOnFrom) {
  const thew::Scene scene = thew::Scene::read(kOneMuscle);
  thew::BakeOptions options{.frames = {1, 2, 5}};
  options.progress = [](const thew::BakeProgress& now) { return now.done < 2; };
  expect_error(ErrorCode::kRetry, "interrupted", [&] { thew::bake(scene, folder_, options); });
  EXPECT_FALSE(std::filesystem::exists(folder_ / "bake.h5"));
  std::vector<int> shown;
  options.progress = [&](const thew::BakeProgress& now) {
    EXPECT_EQ(now.of, 3);
    shown.push_back(now.frame);
    return true;
  };
  options.resume = true;
  const std::filesystem::path file = thew::bake(scene, folder_, options);
  EXPECT_EQ(shown, (std::vector<int>{1, 2, 5}));
  EXPECT_EQ(thew::bake(scene, folder_, options), file);  // complete: left as it is
  EXPECT_EQ(shown.size(), 3u);
  const thew::Scene other = thew::Scene::read(kOneMuscle, {"muscle.flexor.material.stiffness=900"});
  expect_error(ErrorCode::kUsage, "of another scene", [&] { thew::bake(other, folder_, options); });
  const thew::Bake bake(file);
  EXPECT_EQ(bake.contents().frames, options.frames);
  expect_error(ErrorCode::kUsage, "frame 3 was not baked", [&] { bake.positions("flexor", 3); });
  expect_error(ErrorCode::kUsage, "no mesh \"biceps\"", [&] { bake.positions("biceps", 1); });
  expect_error(ErrorCode::kUsage, "no measure", [&] { bake.measure("volume"); });
}

TEST_F(Api, ASceneFromArraysKeepsItsVolumes) {
  thew::SceneDefinition definition = elbow();
  definition.bones = {{"humerus", "humerus", box({-0.01, -0.28, -0.01}, {0.01, 0, 0.01})}};
  const thew::Scene scene(definition);
  EXPECT_EQ(scene.info().meshes, (std::vector<std::string>{"flexor", "humerus"}));
  thew::Simulation simulation(scene);
  const thew::Mesh& mesh = definition.muscles[0].mesh;
  const double rest = thew::enclosed_volume(mesh.positions, mesh.triangles);
  while (simulation.step() < 6) continue;
  EXPECT_NEAR(thew::enclosed_volume(simulation.positions("flexor"), mesh.triangles) / rest, 1.0,
              1e-12);
  EXPECT_EQ(simulation.positions("humerus"), definition.bones[0].mesh.positions);
  EXPECT_EQ(simulation.triangles("flexor"), mesh.triangles);
  EXPECT_NEAR(simulation.joints()[0], 0.8, 1e-12);
}

TEST_F(Api, EachPartOfADefinitionCounts) {
  const std::vector<double> plain = last_frame(elbow());
  const auto moves = [&](const char* what, const auto& change) {
    thew::SceneDefinition definition = elbow();
    change(definition);
    EXPECT_GT(farthest(plain, last_frame(definition)), 1e-7) << what;
  };
  moves("weights", [](auto& d) {
    std::vector<double>& weights = d.muscles[0].weights;
    for (int i = 0; i < 4 * 17; ++i) weights.push_back(i < 32 ? 1.8 : 0.2);
  });
  moves("belly", [](auto& d) { d.muscles[0].belly = {0.08, 0.24}; });
  moves("wraps", [](auto& d) { d.muscles[0].wraps = {}; });
  moves("stiffness", [](auto& d) { d.muscles[0].stiffness = 300; });
  moves("a map of stiffness", [](auto& d) {
    std::vector<double>& map = d.muscles[0].maps["stiffness"];
    for (int i = 0; i < 4 * 17; ++i) map.push_back(i < 32 ? 400 : 1000);
  });
  moves("activation by joint", [](auto& d) {
    d.muscles[0].f_max = 300;
    d.muscles[0].by_joint = {.joint = "elbow", .curve = {{0, 0.5}, {90, 1}}};
  });
  moves("activation", [](auto& d) {
    d.muscles[0].f_max = 300;
    d.muscles[0].activation = {{1, 0}, {6, 1}};
  });
  moves("gravity", [](auto& d) { d.gravity = {0, 0, 9.81}; });
  moves("solver", [](auto& d) { d.solver = {.integrator = "quasi_static", .iterations = 1}; });
  moves("clip", [](auto& d) { d.clip.values = {0, 0.5}; });
  moves("size", [](auto& d) { d.size = 0.5; });
  moves("fps", [](auto& d) { d.fps = 240; });
}

TEST_F(Api, AMuscleWithSeamsKeepsItsOrder) {
  const std::vector<double> plain = last_frame(elbow());
  thew::SceneDefinition definition = elbow();
  thew::Mesh& mesh = definition.muscles[0].mesh;
  const int doubled = static_cast<int>(mesh.positions.size() / 3);
  for (int k = 0; k < 3; ++k) mesh.positions.push_back(mesh.positions[3 * 20 + k]);
  *std::find(mesh.triangles.begin(), mesh.triangles.end(), 20) = doubled;
  const std::vector<double> positions = last_frame(definition);
  ASSERT_EQ(positions.size(), plain.size() + 3);
  EXPECT_EQ(std::vector<double>(positions.begin(), positions.end() - 3), plain);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(positions[3 * doubled + k], positions[3 * 20 + k]);
}

TEST_F(Api, ASkinFollows) {
  thew::SceneDefinition definition = elbow();
  definition.bones = {{"humerus", "humerus", box({-0.01, -0.28, -0.01}, {0.01, 0, 0.01})},
                      {"ulna", "ulna", box({-0.01, -0.2, -0.01}, {0.01, -0.02, 0.01})}};
  definition.skin.mesh = tube(0.02, 0.02, -0.5, 0.06, 27);
  definition.skin.keeps_volume = true;
  thew::Simulation simulation{thew::Scene(definition)};
  while (simulation.step() < 6) continue;
  const std::vector<double> x = simulation.positions("skin");
  const thew::Mesh& mesh = definition.skin.mesh;
  EXPECT_NEAR(thew::enclosed_volume(x, mesh.triangles) /
                  thew::enclosed_volume(mesh.positions, mesh.triangles),
              1.0, 1e-9);
  EXPECT_GT(farthest(x, mesh.positions), 0.05);
}

TEST_F(Api, WhatDoesNotFitIsRefusedByName) {
  const auto refused = [](const std::string& part, const auto& spoil) {
    thew::SceneDefinition definition = elbow();
    spoil(definition);
    expect_error(ErrorCode::kUsage, part, [&] { const thew::Scene scene(definition); });
  };
  refused("there is no body", [](auto& d) { d.bodies = {}; });
  refused("body \"ulna\"", [](auto& d) { d.bodies[1].parent = "humrus"; });
  refused("its joint's axis is zero", [](auto& d) { d.bodies[1].joint.axis = {}; });
  refused("the clip has 3 values", [](auto& d) { d.clip.values.push_back(1); });
  refused("frames do not rise", [](auto& d) { d.clip.frames = {6, 1}; });
  refused("muscle \"flexor\": its path has not two points",
          [](auto& d) { d.muscles[0].path.pop_back(); });
  refused("did you mean \"ulna\"", [](auto& d) { d.muscles[0].path[1].body = "una"; });
  refused("open edge", [](auto& d) { d.muscles[0].mesh.triangles.resize(9); });
  refused("weights has 2 values", [](auto& d) { d.muscles[0].weights = {1, 2}; });
  refused("its wrap", [](auto& d) { d.muscles[0].wraps[0].segment = 1; });
  refused("its activation", [](auto& d) { d.muscles[0].activation = {{1, 2}}; });
  refused("map \"stiffness\" holds -1", [](auto& d) { d.muscles[0].maps["stiffness"] = {-1}; });
  refused("stiffness has 2 values", [](auto& d) { d.muscles[0].maps["stiffness"] = {1, 2}; });
  refused("there is no map \"stifness\"; did", [](auto& d) { d.muscles[0].maps["stifness"] = {}; });
  refused("thickness of \"flexor\" has 2", [](auto& d) {
    d.muscles[0].maps["thickness"] = {0, 1e-3};
  });
  refused("did you mean \"elbow\"", [](auto& d) { d.muscles[0].by_joint.joint = "elbw"; });
  refused("did you mean \"xpbd\"", [](auto& d) { d.solver.integrator = "xpb"; });
  refused("its name is empty, taken", [](auto& d) { d.muscles.push_back(d.muscles[0]); });
  refused("fps", [](auto& d) { d.fps = 0; });
}

TEST_F(Api, TheVersionIsThePackages) { EXPECT_STREQ(thew::version(), THEW_VERSION); }

}  // namespace
