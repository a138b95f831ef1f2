// SPDX-License-Identifier: Apache-2.0
//
// A show of 1,000 bakes by chance: what its page and its JSON say is what was written.
#include <random>

#include "tests/unit/tools/night/shots.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

TEST_F(ManyBakes, OfAThousandAreCountedAndSortedAsTheyWereWritten) {
  constexpr int kBakes = 1000;
  constexpr double kLimit = 5e-4;
  std::mt19937 random(7);
  const auto chance = [&] { return random() / 4294967296.0; };
  int missed = 0, failed = 0, rung_frames = 0;
  double cpu = 0.0, deepest = 0.0;
  std::string deepest_in;
  for (int k = 0; k < kBakes; ++k) {
    const std::string name = "sh" + std::to_string(1000 + k);
    if (chance() < 0.05) {
      write("show/" + name + "/failure.json", R"({"error": "no way", "frame": 3,
        "command": "thew bake x", "directory": "/d"})");
      ++failed;
      continue;
    }
    const double depth = 6e-4 * chance();
    ordered_json report = some_report(depth, kLimit);
    report["cpu_seconds"]["total"] = std::floor(1e4 * chance());
    cpu += report["cpu_seconds"]["total"].get<double>();
    missed += depth > kLimit;
    if (depth > deepest) deepest = depth, deepest_in = name;
    if (chance() < 0.1) {
      const int frames = 1 + static_cast<int>(20 * chance());
      ordered_json list = ordered_json::array();
      for (int f = 1; f <= frames; ++f) list.push_back(f);
      report["rungs"] = {{{"muscle", "brachialis"},
                          {"frames", list},
                          {"rung", "carried"},
                          {"because", "it turned inside out"},
                          {"max_penetration_m", depth}}};
      rung_frames += frames;
    }
    put(name, report);
  }
  ASSERT_GT(failed * missed * rung_frames, 0);

  const Night night = read();
  EXPECT_FALSE(night.is_good());
  const std::string text = night_as_json(night).dump();
  const json told = json::parse(text);
  EXPECT_EQ(told["bakes"]["all"], kBakes);
  EXPECT_EQ(told["bakes"]["failed"], failed);
  EXPECT_EQ(told["bakes"]["bound_missed"], missed);
  EXPECT_EQ(told["bakes"]["done"], kBakes - failed - missed);
  EXPECT_EQ(told["cpu_seconds"]["total"], cpu);
  EXPECT_TRUE(
      std::is_sorted(night.shots.begin(), night.shots.end(),
                     [](const NightShot& a, const NightShot& b) { return a.name < b.name; }));
  const auto worst = worst_frames(night, kBakes);
  EXPECT_EQ(worst.at(0).shot->name, deepest_in);
  EXPECT_EQ(worst.at(missed).shot->state, ShotState::kFailed);

  const std::string html = night_as_html(night, folder);
  const std::string table = html.substr(html.find("id=\"bakes\""));
  EXPECT_EQ(times(table, "<tr>") - 1, static_cast<std::size_t>(kBakes));  // its head is one
  EXPECT_EQ(times(html, "<pre>cd /d &amp;&amp; thew bake x</pre>"),
            static_cast<std::size_t>(failed));
  EXPECT_EQ(times(html, "<dd>" + std::to_string(rung_frames) + " <small>frames of muscles"), 1u);
  EXPECT_EQ(times(html, std::to_string(missed) + " bounds not met"), 1u);
  EXPECT_LT(html.size(), std::size_t{2} << 20);

  // Nothing has changed since itself.
  Night again = read();
  compare_with(read_night(write("night.json", text)), again);
  for (const NightShot& shot : again.shots) EXPECT_TRUE(shot.changes.empty()) << shot.name;
  EXPECT_TRUE(again.gone.empty());
}

}  // namespace
}  // namespace thew::tests
