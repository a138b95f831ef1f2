// SPDX-License-Identifier: Apache-2.0
#include "rig/math.h"
#include "sim/scene/reader.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using Pairs = std::vector<std::array<double, 2>>;

const fs::path kScenes = fs::path(THEW_SOURCE_DIR) / "tests/scenes";

TEST(Scene, GeneralKeysAreRead) {
  const fs::path folder = kScenes / "every_key";
  const Scene scene = read_scene(folder / "scene.toml");
  EXPECT_EQ(scene.file, folder / "scene.toml");
  EXPECT_EQ(scene.folder, fs::canonical(folder));
  EXPECT_EQ(scene.name, "every key");
  EXPECT_EQ(scene.fps, 30.0);
  EXPECT_EQ(scene.first_frame, -2);
  EXPECT_EQ(scene.last_frame, 27);
  EXPECT_EQ(scene.settle, 1.5);
  EXPECT_EQ(scene.size, 1.25);
  EXPECT_EQ(scene.skin.settings.bridging, 1.25 * SkinSettings{}.bridging);  // is not given
  EXPECT_EQ(scene.gravity, Vec3(0.5, -3.7, 0));
  EXPECT_EQ(scene.rig, fs::canonical(folder / "rig.urdf"));
  EXPECT_EQ(scene.rig_location, (folder / "scene.toml").string() + ":10");
  EXPECT_EQ(scene.clip_location, (folder / "scene.toml").string() + ":11");
  EXPECT_EQ(scene.clip.interpolation, Clip::Interpolation::kLinear);
  EXPECT_TRUE(scene.clip.angles_only);
  EXPECT_EQ(scene.clip.joints, (std::vector<std::string>{"elbow", "wrist"}));
  EXPECT_EQ(scene.clip.times, (std::vector<double>{0.0, 1.0}));  // frames -2 and 28 at 30 fps
  const std::vector<std::vector<double>> values = {{0.0, 10 * kDegree},
                                                   {90 * kDegree, 20 * kDegree}};
  EXPECT_EQ(scene.clip.values, values);
}

TEST(Scene, MuscleKeysAreRead) {
  const fs::path file = kScenes / "every_key/scene.toml";
  const Scene scene = read_scene(file);
  ASSERT_EQ(scene.muscles.size(), 6u);
  const SceneMuscle& tube = scene.muscles[0];
  EXPECT_EQ(tube.name, "tube");
  EXPECT_EQ(tube.location, file.string() + ":16");
  EXPECT_TRUE(tube.mesh.empty());
  EXPECT_EQ(tube.profile.around, 12);
  EXPECT_EQ(tube.profile.rings, 11);
  EXPECT_EQ(tube.profile.radius, (Pairs{{0, 0.004}, {0.5, 0.018}, {1, 0.005}}));
  ASSERT_EQ(tube.path.size(), 3u);
  EXPECT_EQ(tube.path[1].body, "ulna");
  EXPECT_EQ(tube.path[1].position, Vec3(0.03, -0.05, 0.01));
  EXPECT_EQ(tube.path[1].location, file.string() + ":20");
  EXPECT_EQ(tube.path[1].with, "humerus");
  EXPECT_EQ(tube.path[1].share, 0.6);
  EXPECT_EQ(tube.path[2].with, "");
  ASSERT_EQ(tube.wraps.size(), 1u);
  EXPECT_EQ(tube.wraps[0].segment, 1);
  EXPECT_EQ(tube.wraps[0].body, "ulna");
  EXPECT_EQ(tube.wraps[0].centre, Vec3(0, -0.29, 0));
  EXPECT_EQ(tube.wraps[0].axis, Vec3(0, 0, 2));
  EXPECT_EQ(tube.wraps[0].radius, 0.016);
  EXPECT_EQ(tube.wraps[0].turn, -1.0);
  EXPECT_EQ(tube.wraps[0].location, file.string() + ":23");
  EXPECT_EQ(tube.belly, (std::array<double, 2>{0.06, 0.24}));
  EXPECT_EQ(tube.twist_from, 0.2);
  EXPECT_EQ(tube.weights.keys, (Pairs{{0, 2}, {0.5, 1}, {1, 0}}));
  EXPECT_EQ(tube.shape, SceneMuscle::Shape::kWeights);
  EXPECT_EQ(tube.guide, 100);
  EXPECT_EQ(tube.damping, 10);
  EXPECT_EQ(tube.f_max, 624);
  EXPECT_EQ(tube.fibre_length, 0.12);
  EXPECT_EQ(tube.activation, (Pairs{{-2, 0}, {10.5, 0.5}, {28, 1}}));
  EXPECT_EQ(tube.material.stiffness, 900);
  EXPECT_EQ(tube.material.anisotropy, 8);
  EXPECT_EQ(tube.material.shear, 0.3);
  EXPECT_EQ(tube.material.bending, 2e-4);
  EXPECT_EQ(tube.material.density, 1050);
  EXPECT_EQ(tube.colour, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(tube.zones, 6);

  EXPECT_EQ(scene.muscles[1].mesh, fs::canonical(file.parent_path() / "skin.obj"));
  EXPECT_EQ(scene.muscles[1].weights.list, (std::vector<double>{0, 0.5, 1, 2}));
  EXPECT_EQ(scene.muscles[1].shape, SceneMuscle::Shape::kTarget);
  EXPECT_FALSE(scene.muscles[1].zone);
  ASSERT_TRUE(scene.muscles[2].zone);
  EXPECT_EQ(scene.muscles[2].zone->smallest_radius, 0.01);
  EXPECT_EQ(scene.muscles[2].zone->largest_radius, 0.05);
  EXPECT_EQ(scene.muscles[2].zone->per_impulse, 1e-3);
  EXPECT_EQ(scene.muscles[2].zone->along_load, 0.5);

  const SceneMuscle& soft = scene.muscles[3];
  EXPECT_TRUE(soft.path.empty());
  EXPECT_EQ(soft.shape, SceneMuscle::Shape::kWeights);
  EXPECT_EQ(soft.guide, 0.0);
  EXPECT_EQ(soft.damping, 0.0);
  EXPECT_EQ(soft.material.shape, 0.0);
  ASSERT_EQ(soft.fixed.size(), 1u);
  EXPECT_EQ(soft.fixed[0].body, "ulna");
  EXPECT_EQ(soft.fixed[0].low, Vec3(-1, -1, 0));
  EXPECT_EQ(soft.fixed[0].high, Vec3(1, 0.5, 1));
}

TEST(Scene, KeysOfSkinSolverContactAndRenderAreRead) {
  const fs::path file = kScenes / "every_key/scene.toml";
  const Scene scene = read_scene(file);
  EXPECT_EQ(scene.skin.mesh, fs::canonical(file.parent_path() / "skin.obj"));
  EXPECT_EQ(scene.skin.location, file.string() + ":50");
  EXPECT_EQ(scene.skin.settings.thickness, 0.003);
  EXPECT_EQ(scene.skin.settings.smoothing, 0.25);
  EXPECT_EQ(scene.skin.settings.iterations, 7);
  EXPECT_EQ(scene.skin.settings.fold_gap, 1e-3);
  EXPECT_TRUE(scene.skin.settings.keeps_volume);
  EXPECT_EQ(scene.solver.integrator, "quasi_static");
  EXPECT_EQ(scene.solver.volume, "linear");
  EXPECT_EQ(scene.solver.substeps, 3);
  EXPECT_EQ(scene.solver.iterations, 9);
  EXPECT_EQ(scene.solver.location, file.string() + ":60");
  EXPECT_FALSE(scene.contact.enabled);
  EXPECT_EQ(scene.contact.settings.margin, 0.004);
  EXPECT_EQ(scene.contact.settings.max_depth, 0.03);
  EXPECT_EQ(scene.contact.settings.gap, 1e-4);
  EXPECT_EQ(scene.contact.settings.spacing, 0.007);
  EXPECT_EQ(scene.contact.friction, 0.3);
  const std::vector<std::pair<std::string, std::string>> ignore = {{"tube", "by_mesh"},
                                                                   {"tube", "zoned"}};
  EXPECT_EQ(scene.contact.ignore, ignore);
  const std::vector<std::pair<std::string, double>> thickness = {{"tube", 0.001}};
  EXPECT_EQ(scene.contact.thickness, thickness);
  EXPECT_EQ(scene.contact.self, std::vector<std::string>{"tube"});
  EXPECT_EQ(scene.contact.location, file.string() + ":73");
  EXPECT_EQ(scene.render.width, 640);
  EXPECT_EQ(scene.render.height, 360);
  ASSERT_EQ(scene.render.views.size(), 3u);
  const SceneView& front = scene.render.views[0];
  EXPECT_EQ(front.name, "front");
  EXPECT_EQ(front.show, "muscles");
  EXPECT_EQ(front.eye, Vec3(0, 0, 2));
  EXPECT_EQ(front.target, Vec3(0, -0.3, 0));
  EXPECT_EQ(front.up, Vec3(1, 0, 0));
  EXPECT_EQ(front.field_of_view, 40);
  EXPECT_EQ(scene.render.views[1].show, "weights");  // by its name
  EXPECT_EQ(scene.render.views[1].from, Vec3(0, 0, 1));
  EXPECT_EQ(scene.render.views[1].follow, "ulna");
  const SceneView& open = scene.render.views[2];
  EXPECT_EQ(open.show, "cutaway");
  ASSERT_EQ(open.cut.size(), 1u);
  EXPECT_EQ(open.cut[0], (std::array<double, 4>{0, 0, 1, 0.01}));  // the normal is made a unit
  EXPECT_EQ(open.light, Vec3(0, 1, 1));
  // Of [render] alone nothing else is asked.
  const SceneRender alone = read_render(file, {"rig.file=nowhere.urdf"});
  EXPECT_EQ(alone.width, 640);
  EXPECT_EQ(alone.views.size(), 3u);
  EXPECT_TRUE(scene.output.double_precision);
  ASSERT_EQ(scene.bounds.size(), 5u);
  EXPECT_EQ(scene.bounds[0].quantity, "volume_error");
  EXPECT_EQ(scene.bounds[0].limit, 1e-9);
  EXPECT_EQ(scene.bounds[0].location, file.string() + ":100");
  EXPECT_EQ(scene.bounds[4].quantity, "attachment_gap");
  EXPECT_EQ(scene.bounds[4].limit, 1e-6);
}

TEST(Scene, ShortSceneKeepsDefaults) {
  const Scene scene = read_scene(kScenes / "one_muscle/scene.toml");
  const Scene fresh;
  EXPECT_EQ(scene.gravity, fresh.gravity);
  EXPECT_EQ(scene.settle, fresh.settle);
  EXPECT_EQ(scene.size, 1.0);
  EXPECT_EQ(scene.solver.integrator, fresh.solver.integrator);
  EXPECT_TRUE(scene.skin.mesh.empty());
  ASSERT_EQ(scene.muscles.size(), 1u);
  EXPECT_EQ(scene.muscles[0].weights.keys, preset_profile("left").keys);
  EXPECT_EQ(scene.clip.times, (std::vector<double>{0.0, 23.0 / 24.0}));
}

TEST_F(SceneFile, WithoutClipTheRigRests) {
  const Scene scene = read_scene(this->scene());
  EXPECT_EQ(scene.clip.times.size(), 1u);
  EXPECT_EQ(scene.clip.values.size(), 1u);
  EXPECT_TRUE(scene.clip.joints.empty());
}

TEST_F(SceneFile, FramesInEveryWriting) {
  const auto frames = [&](const std::string& value) {
    const Scene scene = read_scene(this->scene(), {"scene.frames=" + value});
    return std::array<int, 2>{scene.first_frame, scene.last_frame};
  };
  using Two = std::array<int, 2>;
  EXPECT_EQ(frames("1-120"), (Two{1, 120}));
  EXPECT_EQ(frames("[3, 5]"), (Two{3, 5}));
  EXPECT_EQ(frames("7"), (Two{7, 7}));
  EXPECT_EQ(frames("-5--1"), (Two{-5, -1}));
  for (const char* wrong :
       {"5-1", "1-120x2", "1-", "[1, 2, 3]", "1.5", "[1, 2.5]", "all", "1-9999999"}) {
    EXPECT_STARTS(usage_error(this->scene(), {std::string("scene.frames=") + wrong}),
                  "--set scene.frames: scene.frames");
  }
}

// Each joint passes through its own keys; on the other joints' keys it stands on its own curve.
TEST_F(SceneFile, JointsKeyedOnDifferentFrames) {
  const Scene scene =
      read_scene(this->scene("[rig.clip]\ninterpolation = \"linear\"\nkeys = { a = [[1, 0], [10, "
                             "9]], b = [[1, 4], [5.5, 1]] }\n"));
  const Clip& clip = scene.clip;
  EXPECT_EQ(clip.joints, (std::vector<std::string>{"a", "b"}));
  ASSERT_EQ(clip.times.size(), 11u);  // ten frames and 5.5
  for (std::size_t k = 0; k < clip.times.size(); ++k) {
    const double frame = 1.0 + 24.0 * clip.times[k];
    EXPECT_NEAR(clip.values[k][0], frame - 1.0, 1e-12);
    EXPECT_NEAR(clip.values[k][1], frame < 5.5 ? 4.0 - (frame - 1.0) / 1.5 : 1.0, 1e-12);
  }
}

TEST_F(SceneFile, ClipFiles) {
  write("elbow.csv", "time,elbow_deg,marker\n0,0,7\n0.5,90,7\n");
  const std::string columns = "columns = { elbow_deg = \"elbow\", marker = \"\" }\n";
  const Clip clip = read_scene(scene("[rig.clip]\nfile = \"elbow.csv\"\n" + columns)).clip;
  EXPECT_EQ(clip.joints, (std::vector<std::string>{"elbow"}));
  EXPECT_EQ(clip.times, (std::vector<double>{0.0, 0.5}));
  EXPECT_NEAR(clip.values[1][0], kPi / 2, 1e-12);
  write("elbow.txt", "time\n");
  EXPECT_EQ(error_of("[rig.clip]\nfile = \"elbow.txt\"\n"),
            ":14: rig.clip.file is \"elbow.txt\"; give a .mot, .sto or .csv file");
  EXPECT_STARTS(error_of("[rig.clip]\nfile = \"elbow.csv\"\nkeys = {}\n"),
                ":14: [rig.clip] has both");
  EXPECT_STARTS(error_of("[rig.clip]\nkeys = {}\n"), ":14: rig.clip.keys is a table; give");
  EXPECT_STARTS(error_of("[rig.clip]\nunit = \"rad\"\n"),
                ":13: [rig.clip] has none of \"keys\", \"file\"");
}

TEST(Scene, CachesAreAsTheFileHasThem) {
  const Scene scene = read_scene(kScenes / "every_key/cached.toml");
  EXPECT_TRUE(scene.cached_rig.given && scene.rig.empty());
  EXPECT_EQ(scene.cached_rig.scale, 0.01);
  EXPECT_EQ(scene.cached_rig.start, 3.0);
  EXPECT_EQ(scene.cached_rig.bind, 4.0);
  EXPECT_EQ(scene.character.bones[0].cache.filename(), "weights.txt");
  EXPECT_EQ(scene.colliders[0].start, 5.0);
  EXPECT_EQ(scene.colliders[0].scale, 0.1);
  EXPECT_EQ(scene.colliders[1].part, "skin");
  EXPECT_TRUE(scene.colliders[1].mesh.empty());
  EXPECT_EQ(scene.skin.cache.filename(), "weights.txt");
  EXPECT_EQ(scene.skin.start, 6.0);
}

}  // namespace
}  // namespace thew::tests
