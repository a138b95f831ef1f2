// SPDX-License-Identifier: Apache-2.0
//
// solver.volume = "zonal": each zone of a muscle keeps a volume of its own.
#include <gtest/gtest.h>

#include <cmath>

#include "muscles/volume.h"
#include "sim/bake/measure.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/muscle_step.h"
#include "sim/solver/state_archive.h"
#include "sim/step.h"

namespace thew::tests {
namespace {

const std::string kBar = THEW_SOURCE_DIR "/assets/paper/bar.toml";
const std::string kOneMuscle = THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml";

struct Motion {
  Model model;
  State state;
  double volume = 0.0, zone = 0.0, penetration = 0.0;  // largest of all frames; m
  int fallbacks = 0, unreached = 0;
};

Motion run(const std::string& scene, const std::vector<std::string>& overrides, int frames,
           int threads = 1) {
  Motion out;
  out.model = build_model(read_scene(scene, overrides));
  out.state = initial_state(out.model);
  Parallel parallel(threads);
  settle(out.model, parallel, out.state);
  Measuring measuring = start_measuring(out.model, out.state);
  StageSeconds seconds;
  for (int f = 1; f <= frames; ++f) {
    step_frame(out.model, f / out.model.fps, parallel, out.state, seconds);
    const FrameMeasures at = measure(out.model, measuring, parallel, out.state);
    for (const MuscleMeasures& muscle : at.muscles) {
      out.volume = std::max(out.volume, muscle.volume_error);
      out.zone = std::max(out.zone, muscle.zone_error);
    }
    out.penetration = std::max(out.penetration, at.contact_penetration);
    out.fallbacks += at.zone_fallbacks;
    out.unreached += at.unreached;
  }
  return out;
}

// The largest relative error of the volumes of four zones, under any volume rule.
double strayed(const Motion& motion) {
  const Model divided = build_model(read_scene(motion.model.source, {"solver.volume=zonal"}));
  const Muscle& muscle = divided.muscles[0];
  const MuscleState& now = motion.state.muscles[0];
  std::vector<double> wanted, found;
  zone_targets(muscle, now.target, wanted);
  volumes_before(muscle.zones, now.x, muscle.rest.triangles, found);
  return zone_error(muscle.zones, found, wanted);
}

TEST(Zonal, ASqueezedBellyDoesNotBlowUpTheOther) {
  const Motion exact = run(kBar, {"solver.volume=exact"}, 30);
  EXPECT_EQ(exact.zone, 0.0);  // it has none
  EXPECT_GT(strayed(exact), 0.05);
  for (const char* zones : {"2", "4", "8"}) {
    const Motion zonal = run(kBar, {std::string("muscle.bar.zones=") + zones}, 30);
    EXPECT_LE(zonal.volume, 1e-14) << zones;
    EXPECT_LE(zonal.zone, 1e-11) << zones;
    EXPECT_GT(zonal.zone, 0.0) << zones;
    EXPECT_EQ(zonal.fallbacks, 0) << zones;
    EXPECT_EQ(zonal.unreached, 0) << zones;
    EXPECT_LE(zonal.penetration, 2e-4) << zones;
    EXPECT_NE(zonal.model.hash, exact.model.hash);
  }
}

TEST(Zonal, OneZoneIsTheExactMultiplier) {
  const Motion one = run(kBar, {"muscle.bar.zones=1"}, 12);
  const Motion exact = run(kBar, {"solver.volume=exact"}, 12);
  EXPECT_EQ(pack_state(one.state), pack_state(exact.state));
}

// Plates that close by so much (m) each until this frame.
std::string closing(int frame, double way) {
  const std::string keys = "[[1, 0], [" + std::to_string(frame) + ", " + std::to_string(way) + "]]";
  return "rig.clip.keys={ top = " + keys + ", bottom = " + keys + " }";
}

TEST(Zonal, QuasiStaticEndsInTheSameShape) {
  const std::string plates = closing(4, 0.012);
  const Motion dynamic = run(kBar, {plates, "solver.iterations=20", "muscle.bar.zones=2"}, 60);
  const Motion still =
      run(kBar, {plates, "solver.integrator=quasi_static", "muscle.bar.zones=2"}, 4);
  EXPECT_LE(still.volume, 1e-14);
  EXPECT_LE(still.zone, 1e-11);
  EXPECT_LE(largest_distance(dynamic.state.muscles[0].x, still.state.muscles[0].x), 5e-4);
}

// A muscle that swells as it shortens: its zones have the shares of the volume that they have in
// the carried shape.
TEST(Zonal, ZonesOfACarriedShapeSwellWithIt) {
  const Motion zonal = run(kOneMuscle, {"solver.volume=zonal"}, 23);
  EXPECT_LE(zonal.volume, 1e-14);
  EXPECT_LE(zonal.zone, 1e-11);
  EXPECT_EQ(zonal.fallbacks, 0);
  const Muscle& muscle = zonal.model.muscles[0];
  std::vector<double> wanted;
  zone_targets(muscle, zonal.state.muscles[0].target, wanted);
  ASSERT_EQ(wanted.size(), 4u);
  EXPECT_NEAR(wanted.back(), muscle.rest_volume, 1e-15 * muscle.rest_volume);
  EXPECT_GT(zone_error(muscle.zones, wanted, muscle.zones.rest_before), 1e-3);
  const Motion alone = run(kOneMuscle, {"solver.volume=zonal", "muscle.flexor.shape=weights"}, 23);
  EXPECT_LE(alone.zone, 1e-11);
  zone_targets(alone.model.muscles[0], alone.state.muscles[0].target, wanted);
  EXPECT_EQ(wanted, alone.model.muscles[0].zones.rest_before);
}

TEST(Zonal, SameBytesForAnyThreadsAndFromAnyFrame) {
  const std::string pair = THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml";
  const Motion one = run(pair, {"solver.volume=zonal"}, 5, 1);
  const Motion two = run(pair, {"solver.volume=zonal"}, 5, 2);
  EXPECT_LE(one.zone, 1e-11);
  EXPECT_EQ(pack_state(one.state), pack_state(two.state));
  // From here on as a resumed bake does.
  State later = initial_state(one.model), now = one.state;
  unpack_state(one.model, pack_state(one.state), later);
  Parallel parallel(1);
  StageSeconds seconds;
  for (State* state : {&later, &now}) {
    step_frame(one.model, 6 / one.model.fps, parallel, *state, seconds);
  }
  EXPECT_EQ(pack_state(later), pack_state(now));
}

// Most of the squeezed belly has no weights, so that no motion that they allow restores its zones.
// Only the whole volume is then restored, and the report counts how often.
TEST(Zonal, WhereAZoneCannotBeHeldTheWholeIs) {
  const Motion held = run(kBar, {"muscle.bar.weights={ profile = [[0.4, 0], [0.41, 1]] }"}, 20);
  EXPECT_GT(held.fallbacks, 0);
  EXPECT_GT(held.zone, 1e-3);
  EXPECT_LE(held.volume, 1e-12);
  for (const Point& x : held.state.muscles[0].x) EXPECT_TRUE(std::isfinite(x[0] + x[1] + x[2]));
}

TEST(Zonal, TooManyZonesForAMeshAreRefusedWithTheirPlace) {
  try {
    build_model(read_scene(kOneMuscle, {"solver.volume=zonal", "muscle.flexor.zones=16"}));
    FAIL() << "16 zones of 11 rings";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kUsage);
    const std::string message = error.what();
    EXPECT_NE(message.find("scene.toml:13: muscle \"flexor\": "), std::string::npos) << message;
    EXPECT_NE(message.find("; give fewer zones"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace thew::tests
