// SPDX-License-Identifier: Apache-2.0
//
// A bake that goes on from frames of which only some have the solver's state, or none.
#include <gtest/gtest.h>

#include "sim/bake/bake.h"
#include "sim/cache/cache_parts.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "sim/settle.h"
#include "sim/solver/state_archive.h"
#include "tests/unit/sim/cache_bake.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class ResumedBake : public CacheTest {
 protected:
  // All that are written: every second frame.
  BakeOptions options(const std::string& name) {
    BakeOptions out;
    out.folder = folder_ / name;
    for (int frame = model_.first_frame; frame <= 16; frame += 2) out.frames.push_back(frame);
    return out;
  }
  // The solver's state after each frame from the first on.
  std::vector<std::vector<double>> states() {
    Parallel parallel(1);
    StageSeconds unused;
    State state = initial_state(model_);
    settle(model_, parallel, state);
    std::vector<std::vector<double>> all = {pack_state(state)};
    for (int frame = model_.first_frame + 1; frame <= 16; ++frame) {
      step_frame(model_, (frame - model_.first_frame) / model_.fps, parallel, state, unused);
      all.push_back(pack_state(state));
    }
    return all;
  }

  Model model_ = build_model(read_scene(THEW_SOURCE_DIR "/tests/scenes/pair/scene.toml"));
  OnFrame take_ = [](const BakeFrame&) { return true; };
};

TEST_F(ResumedBake, GoesOnFromTheNewestStateThatIsThere) {
  BakeOptions how = options("whole");
  std::vector<BakeFrame> frames;
  bake(model_, how, [&](const BakeFrame& frame) {
    frames.push_back(frame);
    return true;
  });
  ASSERT_EQ(frames.size(), 8u);
  EXPECT_FALSE(frames[0].state.empty());
  const std::string expected = bytes_of(how.folder / "bake.h5");
  const auto of_frame = states();

  using Places = std::vector<size_t>;
  for (const Places& with_state : {Places{}, {0}, {0, 2}, {0, 2, 4}, {4}}) {
    SCOPED_TRACE(with_state.size());
    how = options("resumed");
    fs::remove_all(how.folder);
    {
      BakeWriter writer(how.folder, bake_info(model_, how.frames), false);
      for (size_t i = 0; i < 5; ++i) {
        const bool has = std::find(with_state.begin(), with_state.end(), i) != with_state.end();
        frames[i].state = has ? of_frame[2 * i] : std::vector<double>{};
        writer.write(frames[i]);
      }
    }
    const auto written = fs::last_write_time(how.folder / "bake.parts" / part_file(9));
    how.resume = how.is_chunk = true;
    const BakeResult result = bake(model_, how, take_);
    EXPECT_EQ(result.resumed_frames, 5);
    EXPECT_EQ(result.measures.size(), 8u);
    EXPECT_EQ(fs::last_write_time(how.folder / "bake.parts" / part_file(9)), written);
    how.is_chunk = false;
    EXPECT_EQ(bake(model_, how, take_).resumed_frames, 8);
    EXPECT_EQ(bytes_of(how.folder / "bake.h5"), expected);
  }
}

}  // namespace
}  // namespace thew::tests
