// SPDX-License-Identifier: Apache-2.0
#include "muscles/weights.h"
#include "sim/scene/reader.h"
#include "sim/scene/toml.h"
#include "tests/unit/sim/scene_file.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

TEST_F(SceneFile, UnknownKeysAreRefusedAnywhere) {
  EXPECT_EQ(error_of("[solver]\nsubstep = 2\n"),
            ":14: unknown key \"substep\" in [solver]; did you mean \"substeps\"?");
  EXPECT_EQ(error_of("[solvr]\n"),
            ":13: unknown key \"solvr\" in the scene; did you mean \"solver\"?");
  EXPECT_EQ(
      error_of("material = { stifness = 1 }\n"),
      ":13: unknown key \"stifness\" in [muscle.biceps.material]; did you mean \"stiffness\"?");
  EXPECT_EQ(error_of("[output]\nzzz = 1\n"),
            ":14: unknown key \"zzz\" in [output]; there are precision");
  EXPECT_STARTS(error_of("\n[[bound]]\nvolume_err = 1\n"),
                ":15: unknown key \"volume_err\" in [bound.0]");
  EXPECT_STARTS(error_of("[[muscle.wrap]]\nsegment = 0\nbody = \"a\"\ncentre = [0, 0, 0]\n"
                         "axis = [1, 0, 0]\nradius = 1\ntrn = 1\n"),
                ":19: unknown key \"trn\" in [muscle.biceps.wrap.0]; did you mean \"turn\"?");
}

TEST_F(SceneFile, MissingKeys) {
  EXPECT_EQ(error_of("[[muscle]]\nnam = \"b\"\n"),
            ":13: [muscle.1] lacks the key \"name\"; is \"nam\" meant to be it?");
  EXPECT_STARTS(error_of("[[muscle]]\nname = \"b\"\n"),
                ":13: [muscle.b] has none of \"mesh\", \"profile\"; give one");
  EXPECT_STARTS(error_of("[[muscle]]\nname = \"b\"\nprofile = { around = 5 }\n"),
                ":15: [muscle.b.profile] lacks the key \"radius\"; add it");
  EXPECT_STARTS(error_of("[[muscle]]\nname = \"b\"\nprofile = { radius = [[0, 1]] }\n"),
                ":13: [muscle.b] lacks the key \"path\"");
  EXPECT_STARTS(error_of("[skin]\n"), ":13: [skin] lacks the key \"mesh\"");
  EXPECT_STARTS(error_of("[[render.view]]\n"), ":13: [render.view.0] lacks the key \"name\"");
  EXPECT_STARTS(error_of("[[muscle.wrap]]\nsegment = 0\n"), ":13: [muscle.biceps.wrap.0] lacks");
  EXPECT_EQ(usage_error(write("no_rig.toml", "[scene]\n")),
            ": the scene lacks the key \"rig\"; add it");
  EXPECT_STARTS(usage_error(write("no_file.toml", "\n[rig]\n")),
                ":2: [rig] lacks the key \"file\"");
}

// A wrong value, the line it stands on, and what is said of it.
TEST_F(SceneFile, WrongValues) {
  const struct {
    const char *more, *message;
  } cases[] = {
      {"[solver]\nsubsteps = \"two\"\n",
       ":14: solver.substeps is \"two\"; give a whole number from 1 to 1000000"},
      {"[solver]\nsubsteps = 2.5\n", ":14: solver.substeps is 2.5; give a whole number"},
      {"[solver]\nsubsteps = 0\n", ":14: solver.substeps is 0; give"},
      {"[solver]\nsubsteps = 99999999999\n", ":14: solver.substeps is 1e+11; give"},
      {"[solver]\nsubsteps = 1979-05-27\n", ":14: solver.substeps is a date; give"},
      {"[[render.view]]\nname = \"v\"\neye = [0, 0, 2]\nfrom = [0, 0, 1]\n",
       ":16: render.view.v.from is an array of 3, in place of eye and target; leave out either"},
      {"[[render.view]]\nname = \"v\"\nfrom = [0, 2, 0]\n",
       ":13: [render.view.v] looks from (0, 1, 0) to (0, 0, 0) with (0, 1, 0) up; give a "
       "direction, "
       "and an up that is not along the view"},
      {"[solver]\nintegrator = \"explicite\"\n",
       ":14: solver.integrator is \"explicite\"; give one of \"explicit\", \"xpbd\", "
       "\"local_global\", \"quasi_static\"; did you"},
      {"[solver]\nintegrator = 3\n", ":14: solver.integrator is 3; give one of"},
      {"[solver]\nvolume = \"exakt\"\n", ":14: solver.volume is \"exakt\"; give one of"},
      {"[solver]\nvolume = \"zonal\"\nintegrator = \"explicit\"\n",
       ":14: solver.volume is \"zonal\", which \"explicit\" cannot hold; take integrator = "
       "\"local_global\" or \"quasi_static\""},
      {"[solver]\nintegrator = \"xpbd\"\nvolume = \"zonal\"\n",
       ":15: solver.volume is \"zonal\", which \"xpbd\" cannot hold"},
      {"[solver]\nintegrator = \"xpbd\"\n[contact]\nfriction = 0.2\n",
       ":16: contact.friction is 0.2, which \"xpbd\" cannot solve; take integrator = "
       "\"local_global\" or \"quasi_static\""},
      {"[solver]\nintegrator = \"explicit\"\n[contact]\nself = [\"biceps\"]\n",
       ":16: contact.self is an array of 1, which \"explicit\" cannot solve; take integrator = "},
      {"[contact]\nfriction = -0.2\n", ":14: contact.friction is -0.2; give a number from 0"},
      {"zones = 17\n", ":13: muscle.biceps.zones is 17; give a whole number from 1 to 16"},
      {"zones = 0\n", ":13: muscle.biceps.zones is 0; give a whole number from 1 to 16"},
      {"shape = \"targt\"\n", ":13: muscle.biceps.shape is \"targt\"; give one of"},
      {"weights = \"lefft\"\n", ":13: muscle.biceps.weights is \"lefft\"; give one of"},
      {"weights = {}\n", ":13: [muscle.biceps.weights] has none of"},
      {"weights = { profile = [[0, -1]] }\n", ":13: muscle.biceps.weights.profile.0.1 is -1; give"},
      {"weights = { profile = [\n[0, 1],\n[0, 1]] }\n",
       ":15: muscle.biceps.weights.profile.1.0 is 0"},
      {"guide = nan\n", ":13: muscle.biceps.guide is no number; give a number from 0"},
      {"damping = inf\n", ":13: muscle.biceps.damping is infinite; give a number from 0"},
      {"fibre_length = 0\n", ":13: muscle.biceps.fibre_length is 0; give a number from 1e"},
      {"belly = [0.1, 0.1]\n", ":13: muscle.biceps.belly.1 is 0.1; give more than 0.1"},
      {"belly = 3\n", ":13: muscle.biceps.belly is 3; give metres along the path"},
      {"colour = [0, 0, 2]\n", ":13: muscle.biceps.colour.2 is 2; give a number from 0 to 1"},
      {"activation = [[1, 1.5]]\n", ":13: muscle.biceps.activation.0.1 is 1.5; give"},
      {"activation = []\n", ":13: muscle.biceps.activation is an array of 0; give pairs"},
      {"material = 5\n", ":13: muscle.biceps.material is 5; give a table"},
      {"wrap = [{ segment = 1, body = \"a\" }]\n",
       ":13: muscle.biceps.wrap.0.segment is 1; give a whole"},
      {"wrap = 5\n", ":13: muscle.biceps.wrap is 5; give tables, [[muscle.biceps.wrap]]"},
      {"[contact]\nenabled = 1\n", ":14: contact.enabled is 1; give true or false"},
      {"[contact]\nignore = [[\"a\"]]\n", ":14: contact.ignore.0 is an array of 1; give a pair of"},
      {"[render]\nsize = [960]\n", ":14: render.size is an array of 1; give pixels"},
      {"[render]\nsize = [960, 20000]\n", ":14: render.size.1 is 20000; give"},
      {"[[render.view]]\nname = \"../v\"\n",
       ":14: render.view.../v.name is \"../v\"; give at most"},
      {"[[render.view]]\nname = \"v\"\nshow = \"bones\"\n",
       ":15: render.view.v.show is \"bones\"; give"},
      {"[[render.view]]\nname = \"v\"\nup = [1, 0, 0]\n",
       ":13: [render.view.v] looks from (1, 0, 0) to"},
      {"[[render.view]]\nname = \"v\"\nshow = \"cutaway\"\n",
       ":13: [render.view.v] has no cut; say where"},
      {"[[render.view]]\nname = \"v\"\ncut = [[0, 0, 0, 1]]\n",
       ":15: render.view.v.cut.0 is an array of 4; give a normal that is not zero"},
      {"[skin]\nmesh = \"rig.urdf\"\niterations = 0\n", ":15: skin.iterations is 0; give a whole"},
      {"[output]\nprecision = \"half\"\n", ":14: output.precision is \"half\"; give one of"},
      {"[[bound]]\npenetration = -1\n", ":14: bound.0.penetration is -1; give"},
      {"[[bound]]\npenetration = 1\n[[bound]]\npenetration = 2\n",
       ":16: bound.1.penetration is 2; remove"},
      {"[[render.view]]\nname = \"v\"\n[[render.view]]\nname = \"v\"\n",
       ":15: a second [render.view.v]"},
      {"[[muscle]]\nname = \"biceps\"\nprofile = { radius = [[0, 1]] }\n"
       "path = [[\"a\", 0, 0, 0], [\"b\", 0, 0, 0]]\n",
       ":13: a second [muscle.biceps]"},
      {"[[muscle]]\nname = \"b\"\nprofile = { around = 1000, rings = 1000, radius = [[0, 1]] }\n",
       ":15: muscle.b.profile.rings is 1000; with around = 1000 that is more than 100000 nodes"},
      {"[[muscle]]\nname = \"b\"\nprofile = { radius = [[0, 1]] }\npath = [[\"a\", 0, 0, 0]]\n",
       ":16: muscle.b.path is an array of 1; give two points or more"},
      {"[[muscle]]\nname = \"b\"\nprofile = { radius = [[0, 1]] }\npath = [[\"a\", 0, 0, "
       "0],\n[\"b\", 0, 0]]\n",
       ":17: muscle.b.path.1 is an array of 3; give a point"},
      {"[[muscle]]\nname = \"a/b\"\n", ":14: muscle.a/b.name is \"a/b\"; give at most 100 letters"},
      {"[rig.clip]\nkeys = { elbow = [[2, 0], [1, 0]] }\n",
       ":14: rig.clip.keys.elbow.1.0 is 1; give more"},
      {"[rig.clip]\nkeys = { elbow = [[1, \"x\"]] }\n",
       ":14: rig.clip.keys.elbow.0.1 is \"x\"; give a number"},
  };
  for (const auto& [more, message] : cases) EXPECT_STARTS(error_of(more), message);
}

TEST_F(SceneFile, BrokenToml) {
  EXPECT_STARTS(error_of("[solver\n"), ":13:8: ");
  EXPECT_STARTS(error_of("[solver]\nsubsteps = 1\nsubsteps = 2\n"), ":15:");
  EXPECT_STARTS(error_of("belly = [0,\n  0.1,}\n]\n"), ":14: a value is missing, or");
  std::string deep = "x = ", dotted = "a";
  for (int i = 0; i < 200; ++i) deep += "[";
  for (int i = 0; i < 200; ++i) deep += "]";
  for (int i = 0; i < 1000000; ++i) dotted += ".a";
  EXPECT_STARTS(error_of(deep + "\n"), ":13: tables and arrays are nested too deep");
  EXPECT_STARTS(error_of(dotted + " = 1\n"), ":13: a key has more than 32 parts");
  EXPECT_STARTS(error_of("[" + dotted + "]\n"), ":13: a key has more than 32 parts");
  EXPECT_STARTS(error_of("x = { y = \"#\", " + dotted + " = 1 }\n"), ":13: a key has more than");
  EXPECT_EQ(error_of("# " + std::string(100, '.') + " \"" + dotted + "\n"), "");
  EXPECT_STARTS(error_of("#" + std::string(5 << 20, ' ')), ": is larger than the limit of 4 MiB");
  EXPECT_STARTS(usage_error(folder / "none.toml"), ": there is no such file");
}

// Each letter of the basic plane, written as UTF-8.
TEST_F(SceneFile, AnyLetterAfterANumberIsASlip) {
  TomlValue root = read_toml(write("a.toml", "a = 1\n"));
  for (unsigned c = 0x80; c < 0x10000; ++c) {
    if (c >= 0xD800 && c < 0xE000) continue;  // halves of pairs
    std::string letter;
    if (c < 0x800) {
      letter = {static_cast<char>(0xC0 | c >> 6), static_cast<char>(0x80 | (c & 63))};
    } else {
      letter = {static_cast<char>(0xE0 | c >> 12), static_cast<char>(0x80 | (c >> 6 & 63)),
                static_cast<char>(0x80 | (c & 63))};
    }
    EXPECT_THROW(override_toml(root, "a=[2" + letter + "]"), Error) << std::hex << c;
  }
}

TEST_F(SceneFile, Overrides) {
  const std::string more =
      "weights = \"left\"\n[[render.view]]\nname = \"v\"\n[[bound]]\nvolume_error = 1e-9\n";
  const Scene scene = read_scene(
      this->scene(more),
      {"muscle.biceps.weights=right", "muscle.biceps.path.1.2 = 0.2", "solver.substeps=4",
       "solver.integrator=\"explicit\"", "render.view.v.show=muscles", "bound.volume_error=1e-6",
       "bound.penetration=0.1", "scene.name=two words", "muscle.biceps.material={stiffness=5}",
       "muscle.0.guide=3", "rig.clip.keys.elbow=[[1,0],[2,1]]",
       "muscle.biceps.material.shear=0.5"});
  EXPECT_EQ(scene.muscles[0].weights.keys, preset_profile("right").keys);
  EXPECT_EQ(scene.muscles[0].path[1].position, Vec3(0, 0.2, 0));
  EXPECT_EQ(scene.muscles[0].material.stiffness, 5);
  EXPECT_EQ(scene.muscles[0].material.shear, 0.5);
  EXPECT_EQ(scene.muscles[0].guide, 3);
  EXPECT_EQ(scene.solver.substeps, 4);
  EXPECT_EQ(scene.solver.integrator, "explicit");
  EXPECT_EQ(scene.render.views[0].show, "muscles");
  EXPECT_EQ(scene.name, "two words");
  EXPECT_EQ(scene.clip.joints, (std::vector<std::string>{"elbow"}));
  ASSERT_EQ(scene.bounds.size(), 2u);
  EXPECT_EQ(scene.bounds[0].limit, 1e-6);
  EXPECT_EQ(scene.bounds[0].location, "--set bound.volume_error");
  EXPECT_EQ(scene.bounds[1].limit, 0.1);
}

TEST_F(SceneFile, WrongOverrides) {
  const struct {
    const char *setting, *message;
  } cases[] = {
      {"solver.substep=4",
       "--set solver.substep: unknown key \"substep\" in [solver]; did you mean \"substeps\"?"},
      {"solvr.substeps=4",
       "--set solvr.substeps: unknown key \"solvr\" in the scene; did you mean"},
      {"solver.substeps=many", "--set solver.substeps: solver.substeps is \"many\"; give a whole"},
      {"solver.substeps=1\nfps = 2",
       "--set solver.substeps: solver.substeps is \"1?fps = 2\"; give"},
      {"solver.substeps", "--set solver.substeps: is not KEY=VALUE"},
      {"=4", "--set =4: is not KEY=VALUE"},
      {"scene.gravity=[1,", "--set scene.gravity: \"[1,\" is no TOML value"},
      {"scene.gravity=[1,}", "--set scene.gravity:1: a value is missing"},
      {"muscle.bicep.guide=1",
       "--set muscle.bicep.guide: muscle has no \"bicep\"; did you mean \"biceps\"?"},
      {"muscle.7.guide=1", "--set muscle.7.guide: muscle has no \"7\""},
      {"scene.frames.first=1",
       "--set scene.frames.first: scene.frames is \"1-10\", which has no keys"},
      {"rig.file=a.urdf", "--set rig.file: rig.file is \"a.urdf\", but"},
  };
  for (const auto& [setting, message] : cases) EXPECT_STARTS(error_of("", {setting}), message);
}

TEST_F(SceneFile, PathsStayBelowTheFolder) {
  const fs::path inner = folder / "inner";
  write("outside.urdf", "<robot/>");
  write("inner/rig.urdf", "<robot/>");
  const auto with_rig = [&](const std::string& rig) {
    return write("inner/arm.toml", "[rig]\nfile = \"" + rig + "\"\n");
  };
  EXPECT_EQ(usage_error(with_rig("rig.urdf")), "");
  EXPECT_EQ(usage_error(with_rig("../inner/./rig.urdf")), "");  // leads back
  EXPECT_EQ(usage_error(with_rig("../outside.urdf")),
            ":2: rig.file is \"../outside.urdf\", which lies outside " +
                fs::canonical(inner).string() + "; copy it there, or allow another folder");
  EXPECT_STARTS(usage_error(with_rig("none/../../none.urdf")), ":2: rig.file is");
  EXPECT_STARTS(usage_error(with_rig((inner / "rig.urdf").string())), ":2: rig.file is");
  fs::create_symlink("../outside.urdf", inner / "link.urdf");
  EXPECT_STARTS(usage_error(with_rig("link.urdf")),
                ":2: rig.file is \"link.urdf\", which lies outside");
  fs::create_directory_symlink("..", inner / "up");
  EXPECT_STARTS(usage_error(with_rig("up/outside.urdf")),
                ":2: rig.file is \"up/outside.urdf\", which lies");
  EXPECT_STARTS(usage_error(with_rig("none.urdf")), ":2: rig.file is \"none.urdf\", but");
  EXPECT_STARTS(usage_error(with_rig(".")), ":2: rig.file is");
  // Another folder may be allowed; paths stay relative to the scene.
  const Scene scene = read_scene(with_rig("../outside.urdf"), {}, folder);
  EXPECT_EQ(scene.rig, fs::canonical(folder / "outside.urdf"));
  EXPECT_EQ(scene.folder, fs::canonical(folder));
}

TEST_F(SceneFile, WeightFiles) {
  const std::string more = "weights = { file = \"w.txt\" }\n";
  write("w.txt", "1\r\n 2 \n3");
  EXPECT_EQ(read_scene(scene(more)).muscles[0].weights.list, (std::vector<double>{1, 2, 3}));
  for (const char* text : {"1\nx\n", "1\n-1\n", "1\nnan\n", "1\n2 3\n", "1\n\n2\n"}) {
    write("w.txt", text);
    EXPECT_HAS(input_error([&] { read_scene(scene(more)); }), "w.txt:2: is not a value of weights");
  }
}

}  // namespace
}  // namespace thew::tests
