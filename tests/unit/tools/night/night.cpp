// SPDX-License-Identifier: Apache-2.0
//
// What is said of many bakes, against folders that are written by hand.
#include "sim/bake/bake.h"
#include "sim/cache/cache_parts.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"
#include "tests/unit/tools/night/shots.h"
#include "tools/render/image.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using nlohmann::ordered_json;

TEST_F(ManyBakes, SaysOfEachFolderWhatItHolds) {
  put("a/good", some_report(4e-4));
  put("a/missed", some_report(7e-4));
  put("b/failed", some_report(1e-4));  // of a bake before
  write("show/b/failed/failure.json",
        R"({"error": "muscle \"x\": node 7 is not finite; raise substeps", "frame": 12,
            "scene": "arm", "command": "thew bake b.toml --out b", "directory": "/shots"})");
  const auto part = [&](const std::string& shot, const std::string& command) {
    write(
        "show/" + shot + "/bake.parts/bake.json",
        R"({"scene": "arm", "frames": 10, "directory": "/shots", "command": ")" + command + "\"}");
    std::string lines;
    for (int frame = 1; frame <= 3; ++frame) {
      lines += R"({"frame": )" + std::to_string(frame) + R"(, "file": ")" + part_file(frame) +
               R"(", "bytes": 1, "hash": "b"})" + "\n";
    }
    write("show/" + shot + "/bake.parts/manifest.jsonl", lines);
  };
  part("b/cut", "thew bake c.toml --out c");
  part("b/again", "thew bake c.toml --out c --resume");
  part("b/chunks/1", "thew bake c.toml --out c --chunk");  // waits for --join
  write("show/c/packed/bake.h5", "");
  write("show/c/poses.bake/bake.h5", "");  // of thew poses
  write("show/c/spoilt/report.json", "{\"thew\": \"0.1.0\", \"scene\"");
  ordered_json wrong = some_report(1e-4);
  wrong["bounds"][0]["limit"] = "5e-4";
  put("c/wrong", wrong);
  put("c/.hidden/x", some_report(1e-4));

  const Night night = read();
  std::vector<std::string> names;
  for (const NightShot& shot : night.shots) names.push_back(shot.name);
  EXPECT_EQ(names, (std::vector<std::string>{"a/good", "a/missed", "b/again", "b/cut", "b/failed",
                                             "c/packed", "c/spoilt", "c/wrong"}));
  EXPECT_EQ(named(night, "a/good").state, ShotState::kDone);
  EXPECT_EQ(named(night, "a/good").again, "cd '/home/a show' && thew bake arm.toml --out out");
  EXPECT_EQ(named(night, "a/missed").state, ShotState::kMissed);
  EXPECT_EQ(what_is_wrong(named(night, "a/missed")),
            "penetration is 0.7 mm in frame 2, allowed 0.5 mm");
  const NightShot& failed = named(night, "b/failed");
  EXPECT_EQ(failed.state, ShotState::kFailed);
  EXPECT_EQ(failed.failed_frame, 12);
  EXPECT_HAS(failed.why, "node 7 is not finite");
  EXPECT_EQ(failed.again, "cd /shots && thew bake b.toml --out b");
  const NightShot& cut = named(night, "b/cut");
  EXPECT_EQ(cut.state, ShotState::kUnfinished);
  EXPECT_EQ(cut.frames, 3);
  EXPECT_EQ(cut.wanted_frames, 10);
  EXPECT_HAS(cut.why, "3 of 10 frames");
  EXPECT_EQ(cut.again, "cd /shots && thew bake c.toml --out c --resume");
  EXPECT_EQ(named(night, "b/again").again, cut.again);
  EXPECT_EQ(named(night, "c/packed").state, ShotState::kUnfinished);
  EXPECT_EQ(named(night, "c/spoilt").state, ShotState::kUnreadable);
  EXPECT_HAS(named(night, "c/spoilt").why, "spoilt/report.json: is no JSON");
  EXPECT_EQ(named(night, "c/wrong").state, ShotState::kUnreadable);
  EXPECT_HAS(named(night, "c/wrong").why, "wrong/report.json: /bounds/0/limit is no number");
  EXPECT_EQ(night_as_text(night).substr(0, night_as_text(night).find('\n')),
            "8 bakes: 1 done, 1 bound missed, 3 unfinished, 1 failed, 2 unreadable");
}

// What a bake leaves when it is stopped is enough to go on with it.
TEST_F(ManyBakes, AreGoneOnWithByTheCommandThatTheyKeep) {
  const Scene scene = read_scene(THEW_SOURCE_DIR "/tests/scenes/one_muscle/scene.toml");
  const BakeOutput output{true, "", "thew bake 'a scene.toml' --out x", "/a show"};
  int done = 0;
  EXPECT_THROW(bake(build_model(scene), {folder / "show/x", {1, 2, 3, 4, 5}, 1, false, output},
                    [&](const BakeFrame&) { return ++done < 3; }),
               Error);
  const Night night = read();
  ASSERT_EQ(night.shots.size(), 1u);
  const NightShot& shot = night.shots[0];
  EXPECT_EQ(shot.state, ShotState::kUnfinished);
  EXPECT_EQ(shot.scene, scene.name);
  EXPECT_HAS(shot.why, "3 of 5 frames are there");
  EXPECT_EQ(shot.again, "cd '/a show' && thew bake 'a scene.toml' --out x --resume");
}

// A farm has the chunks of FOLDER in FOLDER.chunks, and its page beside the bakes.
TEST_F(ManyBakes, AreMadeOfChunks) {
  const auto chunk = [&](const std::string& shot, int done) {
    const std::string at = "show/" + shot + "/bake.parts/";
    write(at + "bake.json", R"({"scene": "arm", "frames": 2, "command": "thew bake x --chunk"})");
    std::string lines;
    for (int f = 1; f <= done; ++f) {
      lines += R"({"frame": )" + std::to_string(f) + R"(, "file": ")" + part_file(f) +
               R"(", "bytes": 1, "hash": "b"})" + "\n";
    }
    write(at + "manifest.jsonl", lines);
  };
  for (const char* shot : {"joined", "waits", "cut", "broken"}) {
    for (const char* number : {"1", "2"}) chunk(shot + std::string(".chunks/") + number, 2);
  }
  put("joined", some_report(1e-4));
  chunk("cut.chunks/2", 1);
  write("show/broken.chunks/1/failure.json",
        R"({"error": "no way", "frame": 2, "command": "thew bake y --chunk"})");
  write("show/report.json", night_as_json(read()).dump(1));
  for (const bool by_name : {false, true}) {
    Night night = read();
    if (by_name) {
      const fs::path show = folder / "show";
      night.shots = find_shots({show / "joined", show / "waits", show / "cut", show / "broken"});
    }
    ASSERT_EQ(night.shots.size(), 4u);
    EXPECT_EQ(named(night, "joined").state, ShotState::kDone);
    const NightShot& waits = named(night, "waits");
    EXPECT_EQ(waits.state, ShotState::kUnfinished);
    EXPECT_EQ(waits.why, "2 chunks not joined yet");
    EXPECT_EQ(waits.frames, 4);
    const NightShot& cut = named(night, "cut");
    EXPECT_EQ(cut.state, ShotState::kUnfinished);
    EXPECT_HAS(cut.why, "2 of 2 chunks: 1 of 2 frames are there");
    EXPECT_EQ(cut.again, "thew bake x --chunk --resume");
    const NightShot& broken = named(night, "broken");
    EXPECT_EQ(broken.state, ShotState::kFailed);
    EXPECT_EQ(broken.why, "1 of 2 chunks: no way");
    EXPECT_EQ(broken.again, "thew bake y --chunk");
    EXPECT_EQ(broken.failed_frame, 2);
  }
  // The earlier run named other folders: what is in the same folder is the same bake.
  Night one;
  one.shots = find_shots({folder / "show/joined", folder / "nothing/here"});
  EXPECT_EQ(one.shots.at(1).name, "show/joined");
  compare_with(read_night(folder / "show/report.json"), one);
  EXPECT_TRUE(one.shots.at(1).changes.empty());
}

TEST_F(ManyBakes, AreFoundOnceHoweverTheyAreNamed) {
  put("x/1", some_report(1e-4));
  put("y/2", some_report(1e-4));
  const auto names = [&](const std::vector<fs::path>& folders) {
    std::string all;
    for (const NightShot& shot : find_shots(folders)) {
      all += shot.name + (shot.state == ShotState::kMissing ? "? " : " ");
    }
    return all;
  };
  const fs::path show = folder / "show";
  fs::create_directory_symlink(show, show / "round");
  EXPECT_EQ(names({show}), "x/1 y/2 ");
  EXPECT_EQ(names({show / "", show / "x", show / "x/../y/2"}), "x/1 y/2 ");
  EXPECT_EQ(names({show / "x", show / "y/2"}), "x/1 y/2 ");
  EXPECT_EQ(names({show / "x/1"}), "1 ");
  EXPECT_EQ(names({show / "x/1", show / "y/2", show / "z/3"}), "x/1 y/2 z/3? ");
  fs::create_directories(show / "z/3");
  EXPECT_EQ(names({show / "x/1", show / "z/3"}), "x/1 z/3? ");
}

TEST_F(ManyBakes, SumsAndStagesAreThoseOfTheReports) {
  for (const char* name : {"1", "2", "3"}) put(name, some_report(1e-4));
  const json read_back = json::parse(night_as_json(read()).dump());
  EXPECT_EQ(read_back["bakes"]["all"], 3);
  EXPECT_EQ(read_back["bakes"]["done"], 3);
  EXPECT_EQ(read_back["frames"], 6);
  EXPECT_EQ(read_back["seconds"]["total"], 30.0);
  EXPECT_EQ(read_back["cpu_seconds"]["total"], 45.0);
  EXPECT_EQ(read_back["cpu_seconds"]["muscles"], 36.0);
  EXPECT_EQ(read_back["shots"][1]["worst"][0]["frame"], 2);
}

TEST_F(ManyBakes, ChangesSinceAnEarlierRun) {
  put("same", some_report(4e-4));
  put("breaks", some_report(4e-4));
  put("worsens", some_report(2e-4));
  put("a_little", some_report(2e-4));
  put("dear", some_report(2e-4));
  put("as_bad", some_report(9e-4));
  put("fails", some_report(2e-4));
  put("gone", some_report(2e-4));
  ordered_json edited = some_report(2e-4);
  put("moved", edited);
  write("show/mended/failure.json", R"({"error": "no", "frame": 1})");
  const fs::path file = write("then.json", night_as_json(read()).dump());

  put("breaks", some_report(6e-4));
  put("worsens", some_report(3e-4));
  put("a_little", some_report(2.1e-4));
  put("as_bad", some_report(9.6e-4));
  ordered_json dear = some_report(2e-4);
  dear["cpu_seconds"]["total"] = 25.0;
  put("dear", dear);
  fs::remove(folder / "show/fails/report.json");
  write("show/fails/report.json", "");
  fs::remove_all(folder / "show/gone");
  edited["hash"] = "bb";
  put("moved", edited);
  fs::remove(folder / "show/mended/failure.json");
  put("mended", some_report(1e-4));
  put("new", some_report(1e-4));

  Night night = read();
  compare_with(read_night(file), night);
  const auto changes = [&](const std::string& name) {
    std::string all;
    for (const ShotChange& one : named(night, name).changes) {
      const char* mark = one.way == ShotChange::Way::kWorse    ? "-"
                         : one.way == ShotChange::Way::kBetter ? "+"
                                                               : "";
      all += mark + one.what + ": " + one.was + " > " + one.is + "; ";
    }
    return all;
  };
  EXPECT_EQ(changes("same"), "");
  EXPECT_EQ(changes("a_little"), "");
  EXPECT_EQ(changes("as_bad"), "");
  EXPECT_EQ(changes("breaks"), "-state: done > bound missed; -penetration: 0.4 mm > 0.6 mm; ");
  EXPECT_EQ(changes("worsens"), "-penetration: 0.2 mm > 0.3 mm; ");
  EXPECT_EQ(changes("dear"), "-cost a frame: 7.5 s > 12.5 s; ");
  EXPECT_EQ(changes("fails"), "-state: done > unreadable; ");
  EXPECT_EQ(named(night, "fails").again, "cd '/home/a show' && thew bake arm.toml --out out");
  EXPECT_EQ(changes("moved"), "positions: aa > bb; ");
  EXPECT_EQ(changes("mended"), "+state: failed > done; ");
  EXPECT_EQ(changes("new"), "new:  > done; ");
  EXPECT_EQ(night.gone, std::vector<std::string>{"gone"});
  EXPECT_EQ(night.against, "2026-11-24");
  const std::string html = night_as_html(night, folder);
  EXPECT_EQ(times(html, "4 for the worse, 1 for the better"), 0u);
  EXPECT_EQ(times(html, "5 for the worse, 1 for the better"), 1u);
  EXPECT_EQ(times(html, "1 bake with other positions of the same scene"), 1u);

  for (const char* text :
       {"", "[]", "{}", R"({"format": "other", "shots": []})", R"({"format": "thew-night"})",
        R"({"format": "thew-night", "shots": [{"name": 1}]})"}) {
    const fs::path bad = write("bad.json", text);
    EXPECT_HAS(input_error([&] { read_night(bad); }), "bad.json") << text;
  }
  EXPECT_HAS(input_error([&] { read_night(folder / "none.json"); }), "none.json");
}

TEST_F(ManyBakes, ThePageNeedsNoOtherFileAndEscapes) {
  ordered_json odd = some_report(7e-4);
  odd["worst"][0]["part"] = "<b>";
  odd["warnings"] = {"<script>alert(1)</script>"};
  odd["rungs"] = {{{"muscle", "psoas"},
                   {"frames", {1, 2}},
                   {"rung", "carried"},
                   {"because", "it <turned> inside out"},
                   {"max_penetration_m", 2e-3}}};
  put("odd <1> & #2?", odd);
  odd["swings"] = {{{"muscle", "soleus"}, {"frames", {1, 2}}, {"swing_m", {1e-4, 2e-4}}}};
  put("odd <1> & #2?", odd);
  put("plain", some_report(1e-4));
  write("show/cut/failure.json", R"({"error": "no", "frame": 3})");
  const std::string html = night_as_html(read(), folder);
  EXPECT_EQ(times(html, "http"), 0u);
  EXPECT_EQ(times(html, "<script"), 1u);
  EXPECT_EQ(times(html, "url("), 0u);
  EXPECT_EQ(times(html, "src="), 0u);
  EXPECT_EQ(times(html, "<1>") + times(html, "<turned>") + times(html, "alert(1)</script>"), 0u);
  EXPECT_GE(times(html, "href=\"show/odd%20%3C1%3E%20%26%20%232%3F/report.html\""), 1u);
  EXPECT_EQ(times(html, "2 of 3 bakes need a look:</b> 1 failed, 1 bound missed"), 1u);
  EXPECT_GE(times(html, ">psoas<"), 1u);
  EXPECT_EQ(times(html, ">soleus<"), 1u);
  EXPECT_EQ(times(html, ">0.2 mm<"), 1u);
  EXPECT_EQ(times(html, "Nothing here says by which command"), 1u);
  EXPECT_EQ(times(html, "<table"), times(html, "</table>"));
  EXPECT_EQ(times(html, "nan"), 0u);
  EXPECT_EQ(night_as_html(read(), folder), html);
  EXPECT_EQ(night_as_html(Night{}, folder).find("nan"), std::string::npos);
}

// The worst first, and each with the picture of its frame in the view that shows it.
TEST_F(ManyBakes, ShowsTheWorstFrames) {
  put("z_far", some_report(9e-4));
  put("over", some_report(6e-4));
  put("under", some_report(4e-4));
  put("bare", some_report(1e-4));
  put("spoilt", some_report(3e-4));
  ordered_json odd = some_report(1e-4);
  odd["swings"] = {{{"muscle", "soleus"}, {"frames", {1, 7}}, {"swing_m", {1e-4, 2e-4}}}};
  put("swings", odd);
  odd["rungs"] = {{{"muscle", "psoas"}, {"frames", {4}}, {"rung", "carried"}},
                  {{"muscle", "psoas"}, {"frames", {1, 2}}, {"rung", "substeps"}}};
  put("stands_in", odd);
  write("show/failed/failure.json", R"({"error": "no", "frame": 5})");
  const auto draw = [&](const std::string& file, std::uint8_t level) {
    fs::create_directories((folder / "show" / file).parent_path());
    write_png(folder / "show" / file,
              {640, 360, std::vector<std::uint8_t>(std::size_t{3} * 640 * 360, level)});
  };
  draw("z_far/frames/muscles.0002.png", 10);
  draw("z_far/frames/skin.0002.png", 20);
  draw("z_far/frames/muscles.0001.png", 30);
  draw("over/frames/side.0002.png", 40);
  draw("failed/frames/side.0003.png", 50);
  draw("failed/frames/side.0004.png", 60);
  draw("failed/frames/side.0006.png", 70);  // of a bake before
  write("show/spoilt/frames/side.0002.png", "no PNG");
  const Night night = read();
  const auto worst = worst_frames(night, 10);
  std::vector<std::string> names;
  for (const WorstFrame& one : worst) names.push_back(one.shot->name);
  EXPECT_EQ(names, (std::vector<std::string>{"z_far", "over", "failed", "stands_in", "swings",
                                             "under", "spoilt", "bare"}));
  EXPECT_EQ(worst[0].frame, 2);
  EXPECT_EQ(worst[0].what, "penetration 0.9 mm of 0.5 mm, frame 2, brachialis");
  EXPECT_EQ(worst_frames(night, 2).size(), 2u);
  const std::string of_far = thumbnail(worst[0]);
  EXPECT_HAS(of_far, "alt=\"muscles, frame 2\" width=\"320\" height=\"180\"");
  EXPECT_HAS(of_far, "data:image/png;base64,");
  EXPECT_HAS(thumbnail(worst[2]), "side, frame 4");
  EXPECT_HAS(thumbnail(worst[1]), "side, frame 2");
  EXPECT_EQ(worst[3].frame, 4);
  EXPECT_EQ(worst[4].what, "soleus swings by 0.2 mm, frame 7");
  EXPECT_EQ(named(night, "stands_in").rung_frames(), 1);
  for (const int none : {3, 4, 5, 6, 7}) EXPECT_EQ(thumbnail(worst[none]), "") << none;
  EXPECT_EQ(times(night_as_html(night, folder), "data:image/png;base64,"), 3u);
  EXPECT_EQ(times(night_as_html(night, folder), "no picture"), 5u);
}

TEST_F(ManyBakes, TheCommandEndsAsTheBakesDid) {
  put("1", some_report(1e-4));
  CommandOptions options;
  NightOptions asked{{folder / "show"}, folder / "to/page.html", folder / "to/night.json", {}};
  EXPECT_EQ(report_command(asked, options), ExitCode::kDone);
  EXPECT_TRUE(fs::exists(asked.html));
  put("1", some_report(6e-4));
  asked.against = asked.json;  // tonight's takes its place
  EXPECT_EQ(report_command(asked, options), ExitCode::kDifferent);
  asked.bounds_fail = false;
  EXPECT_EQ(report_command(asked, options), ExitCode::kDone);
  write("show/2/failure.json", R"({"error": "no", "frame": 1})");
  EXPECT_EQ(report_command(asked, options), ExitCode::kDifferent);
  fs::remove_all(folder / "show/2");
  asked.bounds_fail = true;
  EXPECT_EQ(report_command(asked, options), ExitCode::kDifferent);
  const Night kept = read_night(asked.json);
  EXPECT_EQ(kept.shots.at(0).state, ShotState::kMissed);
  std::ifstream in(asked.html);
  EXPECT_HAS(std::string(std::istreambuf_iterator<char>(in), {}), "Since the last run");
  asked.html = write("mine.html", "not of Thew");
  EXPECT_THROW(report_command(asked, options), Error);
  asked.html.clear();
  asked.folders = {folder / "nowhere"};
  EXPECT_EQ(report_command(asked, options), ExitCode::kDifferent);
}

}  // namespace
}  // namespace thew::tests
