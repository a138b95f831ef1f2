// SPDX-License-Identifier: Apache-2.0
//
// The tasks of a show: which bakes JOBS.toml lists, what they are divided into, and what waits for
// what.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "tests/unit/rig/temp.h"
#include "tools/cli/commands.h"
#include "tools/farm/engines.h"

namespace thew::tests {
namespace {

namespace fs = std::filesystem;

class Farm : public TempFolder {
 protected:
  Farm() {
    fs::copy(THEW_SOURCE_DIR "/tests/scenes/pair", folder / "pair", fs::copy_options::recursive);
  }
  Jobs jobs(const std::string& text) {
    std::ofstream(folder / "jobs.toml") << text;
    return read_jobs(folder / "jobs.toml");
  }
  void refused(const std::string& text, const std::string& word) {
    try {
      jobs(text);
      ADD_FAILURE() << "taken: " << text;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kUsage);
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
};

constexpr const char* kShow = R"(
chunk = 5
pictures = 6
exports = ["a.usda", "b.obj"]
[[shot]]
name = "one"
frames = "1-15x2"
[[shot]]
name = "two"
set = ["scene.frames=1-40"]
characters = ["posed"]
[[character]]
name = "moving"
scene = "pair/scene.toml"
[[character]]
name = "posed"
scene = "pair/scene.toml"
set = ["solver.integrator=quasi_static"]
[[setting]]
name = "a"
[[setting]]
name = "b"
set = ["skin.enabled=false", "scene.name=it's b"]
)";

std::map<std::string, Task> by_name(const Graph& graph) {
  std::map<std::string, Task> tasks;
  for (const Task& task : graph.tasks) tasks[name_of(task)] = task;
  return tasks;
}

std::string after(const std::vector<std::string>& words, const std::string& option) {
  const auto found = std::find(words.begin(), words.end(), option);
  return found == words.end() || found + 1 == words.end() ? "" : *(found + 1);
}

TEST_F(Farm, ListsShotsTimesCharactersTimesSettings) {
  const Jobs show = jobs(kShow);
  std::vector<std::string> names;
  for (const ShotBake& bake : show.bakes) names.push_back(bake.name);
  EXPECT_EQ(names, (std::vector<std::string>{"one/moving/a", "one/moving/b", "one/posed/a",
                                             "one/posed/b", "two/posed/a", "two/posed/b"}));
  EXPECT_EQ(show.out, folder / "bakes");
  EXPECT_EQ(show.bakes[0].folder, folder / "bakes/one/moving/a");
  EXPECT_EQ(show.bakes[0].frames, (std::vector<int>{1, 3, 5, 7, 9, 11, 13, 15}));
  EXPECT_EQ(show.bakes[0].simulated, 15);
  EXPECT_FALSE(show.bakes[0].stands_alone);
  EXPECT_TRUE(show.bakes[2].stands_alone);
  EXPECT_EQ(show.bakes[4].frames.size(), 40u);
  EXPECT_EQ(show.bakes[2].costs_as, show.bakes[4].costs_as);  // another shot costs no pilot
  EXPECT_NE(show.bakes[2].costs_as, show.bakes[3].costs_as);

  EXPECT_EQ(read_jobs(THEW_SOURCE_DIR "/tools/examples/night.toml").bakes.size(), 4u);

  const std::string shot = "[[shot]]\nname = \"s\"\n", scene = "scene = \"pair/scene.toml\"\n";
  EXPECT_EQ(jobs(shot + scene).bakes.at(0).name, "s");
  refused("", "[[shot]]");
  refused(shot, "no scene");
  refused(shot + scene + "[[character]]\nname = \"c\"\n" + scene, "two");
  refused(shot + scene + shot + scene, "name of its own");
  refused(shot + scene + "frames = \"1-17\"\n", "outside the scene's frames 1-16");
  refused(shot + scene + "set = [\"solver.substep=3\"]\n", "did you mean");
  refused(shot + scene + "chunks = 3\n", "chunks");
  refused(shot + "characters = [\"her\"]\n[[character]]\nname = \"hero\"\n" + scene,
          "did you mean \"hero\"");
  refused("threads = 0\n" + shot + scene, "threads");
  refused("exports = [\"../a.usda\"]\n" + shot + scene, "folder of each bake");
  refused("[[shot]]\nname = \"a/b\"\n" + scene, "name");
}

TEST_F(Farm, DividesABakeAndPutsItTogether) {
  const Jobs show = jobs(kShow);
  const Graph graph = plan_tasks(show, {});
  EXPECT_EQ(graph.bakes, 6);
  EXPECT_EQ(graph.done, 0);
  const auto tasks = by_name(graph);
  EXPECT_EQ(tasks.size(), graph.tasks.size()) << "two tasks of one name";
  for (size_t i = 0; i < graph.tasks.size(); ++i) {
    for (const int other : graph.tasks[i].after) EXPECT_LT(other, static_cast<int>(i));
  }
  const auto waits_for = [&](const std::string& name) {
    std::set<std::string> names;
    for (const int other : tasks.at(name).after) {
      names.insert(name_of(graph.tasks[static_cast<size_t>(other)]));
    }
    return names;
  };
  using Names = std::set<std::string>;
  EXPECT_FALSE(tasks.contains("one.moving.a.chunk.1"));  // its frames need those before
  EXPECT_EQ(waits_for("one.moving.a.bake.1"), Names{});
  EXPECT_EQ(waits_for("one.posed.a.join.1"), (Names{"one.posed.a.chunk.1", "one.posed.a.chunk.2"}));
  EXPECT_EQ(waits_for("one.posed.a.pictures.2"), Names{"one.posed.a.join.1"});
  EXPECT_EQ(waits_for("one.posed.a.finish.1"),
            (Names{"one.posed.a.pictures.1", "one.posed.a.pictures.2"}));
  EXPECT_EQ(waits_for("two.posed.b.export.2"), Names{"two.posed.b.join.1"});
  EXPECT_EQ(after(tasks.at("one.posed.a.chunk.1").words, "--frames"), "1-9x2");
  EXPECT_EQ(after(tasks.at("one.posed.a.chunk.2").words, "--frames"), "11-15x2");
  EXPECT_EQ(after(tasks.at("two.posed.a.pictures.7").words, "--frames"), "37-40");
  EXPECT_EQ(after(tasks.at("one.moving.a.bake.1").words, "--bounds"), "warn");

  // The report comes last, of all bakes, and waits for whatever nothing else waits for.
  const Task& report = graph.tasks.back();
  EXPECT_EQ(name_of(report), "report.1");
  for (const ShotBake& bake : show.bakes) {
    EXPECT_EQ(std::count(report.words.begin(), report.words.end(), bake.folder.string()), 1);
  }
  const Names last = waits_for("report.1");
  EXPECT_EQ(last.size(), 6u * 3u);
  EXPECT_TRUE(last.contains("two.posed.b.finish.1") && last.contains("two.posed.b.export.1"));
}

TEST_F(Farm, AsksForWhatThePilotTook) {
  const Jobs show = jobs(kShow);
  Costs costs;
  for (const ShotBake& bake : show.bakes) costs[bake.costs_as] = {1000.0, 10.0, 3.0, 0.25, 0.5};
  const auto tasks = by_name(plan_tasks(show, costs));
  EXPECT_EQ(tasks.at("one.moving.a.bake.1").seconds, 10.0 + 15 * 3.0);  // all up to the last
  EXPECT_EQ(tasks.at("one.posed.a.chunk.2").seconds, 10.0 + 3 * 3.0);
  EXPECT_EQ(tasks.at("one.posed.a.pictures.2").seconds, 10.0 + 2 * 0.5);
  EXPECT_EQ(tasks.at("one.moving.a.bake.1").memory_mib, 2048);
  EXPECT_EQ(tasks.at("one.moving.a.bake.1").minutes, 8);                // (4 × 55 + 120) s
  EXPECT_EQ(tasks.at("two.posed.a.join.1").seconds, 10.0 + 40 * 0.25);  // it solves nothing
  EXPECT_EQ(tasks.at("two.posed.a.join.1").minutes, 4);
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::ifstream in(file);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

// Of the arrays: each task stands in one, and an element waits for elements of its own number.
TEST_F(Farm, MakesArraysOfWhatIsAlike) {
  std::string text = "pictures = 8\n[[character]]\nname = \"c\"\nscene = \"pair/scene.toml\"\n";
  for (int s = 0; s < 1100; ++s) {
    text += "[[shot]]\nname = \"s" + std::to_string(s) + "\"\nframes = \"1-" +
            (s % 11 == 0 ? "4" : "16") + "\"\n";
  }
  const Graph graph = plan_tasks(jobs(text), {});
  const fs::path submit = write_slurm(graph, "/bin/thew", folder / "jobs");
  EXPECT_EQ(submit, folder / "jobs/1/submit.sh");
  const auto tasks = lines_of(folder / "jobs/1/tasks.txt");
  EXPECT_EQ(tasks.size(), graph.tasks.size());
  EXPECT_EQ(std::set<std::string>(tasks.begin(), tasks.end()).size(), tasks.size());
  size_t next = 1;
  std::map<std::string, size_t> counts;
  for (const std::string& line : lines_of(folder / "jobs/1/arrays.txt")) {
    std::istringstream words(line);
    std::string name, how, other;
    size_t first = 0, count = 0, threads = 0, memory = 0, minutes = 0;
    words >> name >> first >> count >> threads >> memory >> minutes >> how;
    EXPECT_EQ(first, next) << line;
    EXPECT_LE(count, 1000u);
    next += count;
    counts[name] = count;
    while (words >> other) {
      ASSERT_TRUE(counts.contains(other)) << line;
      if (how == "aftercorr") EXPECT_EQ(counts[other], count) << line;
    }
  }
  EXPECT_EQ(next, tasks.size() + 1);
  EXPECT_EQ(counts.size(), 3u + 4u + 1u);  // of 4 frames: one of pictures, of 16: two; the report

  // What is submitted already is left as it is: its elements read their lines when they start.
  EXPECT_EQ(write_slurm(graph, "/bin/thew", folder / "jobs"), submit);
  std::ofstream(folder / "jobs/1/submitted.txt") << "1.bake.1 7\n";
  EXPECT_EQ(write_slurm(graph, "/bin/thew", folder / "jobs"), folder / "jobs/2/submit.sh");
}

TEST_F(Farm, WritesAJobOfOpenJobDescriptionForEachShot) {
  const Jobs show = jobs(kShow);
  const auto files = write_openjd(plan_tasks(show, {}), show, "/bin/thew", folder / "jobs");
  ASSERT_EQ(files, (std::vector<fs::path>{folder / "jobs/shots/one/template.json",
                                          folder / "jobs/shots/two/template.json",
                                          folder / "jobs/report/template.json"}));
  const auto job = nlohmann::json::parse(std::ifstream(files[0]));
  EXPECT_EQ(job["specificationVersion"], "jobtemplate-2023-09");
  const auto step = [&](const std::string& name) {
    for (const auto& one : job["steps"]) {
      const std::string whole = one["name"];
      if (whole.substr(whole.find(' ') + 1) == name) return one;
    }
    ADD_FAILURE() << "no step " << name;
    return nlohmann::json();
  };
  const auto chunks = step("chunk one/posed/b");
  const auto& space = chunks["parameterSpace"];
  EXPECT_EQ(space["combination"], "(Out, Frames)");
  EXPECT_EQ(space["taskParameterDefinitions"][1]["range"], nlohmann::json({"1-9x2", "11-15x2"}));
  const std::vector<std::string> args = chunks["script"]["actions"]["onRun"]["args"];
  EXPECT_EQ(after(args, "--out"), "{{Param.Bakes}}/one/posed/b.chunks/{{Task.Param.Out}}");
  EXPECT_EQ(args[1], "{{Param.Scenes}}/pair/scene.toml");
  EXPECT_EQ(after(args, "--progress"), "openjd");
  EXPECT_EQ(step("join one/posed/b")["dependencies"],
            nlohmann::json({{{"dependsOn", chunks["name"]}}}));
  // A name that the schema has no way to quote.
  const Jobs other =
      jobs(std::string(kShow) + "[[setting]]\nname = \"c\"\n" + "set = [\"scene.name=x{{c}}\"]\n");
  EXPECT_THROW(write_openjd(plan_tasks(other, {}), other, "/bin/thew", folder / "jobs"), Error);
}

// Pictures drawn by range are those that the bake would have drawn: it draws none again.
TEST_F(Farm, PicturesByRangeAreTheBakes) {
  CommandOptions options;
  options.input = folder / "pair/scene.toml";
  options.out = folder / "bake";
  options.frames = "1-6";
  options.progress = "none";
  options.threads = 1;
  options.resume = true;
  options.overrides = {"bound=[{volume_error=1e-30}]"};
  options.pictures = false;
  EXPECT_EQ(bake_command(options), ExitCode::kDifferent);
  options.bounds_fail = false;
  EXPECT_EQ(bake_command(options), ExitCode::kDone);  // and says that it is complete
  CommandOptions draw = options;
  draw.input = options.out / "bake.h5";
  draw.out = options.out / "frames";
  draw.chunk = true;
  std::map<std::string, fs::file_time_type> drawn;
  for (const char* range : {"4-6", "1-3", "4-6"}) {
    draw.frames = range;
    EXPECT_EQ(render_command(draw, options.input), ExitCode::kDone);
  }
  for (const auto& entry : fs::directory_iterator(draw.out)) {
    EXPECT_NE(entry.path().extension(), ".mp4");
    if (entry.path().extension() == ".png") {
      drawn[entry.path().filename()] = entry.last_write_time();
    }
  }
  EXPECT_EQ(drawn.size(), 6u);
  options.pictures = true;
  EXPECT_EQ(bake_command(options), ExitCode::kDone);
  for (const auto& [name, time] : drawn) EXPECT_EQ(fs::last_write_time(draw.out / name), time);
  EXPECT_TRUE(fs::exists(draw.out / "contact_sheet.png"));
  const auto report = nlohmann::json::parse(std::ifstream(options.out / "report.json"));
  EXPECT_EQ(report["bounds"][0]["met"], false);
  // Once more by range: nothing of it is removed, although a bake has named it since.
  draw.frames = "1-3";
  EXPECT_EQ(render_command(draw, options.input), ExitCode::kDone);
  for (const auto& [name, time] : drawn) EXPECT_EQ(fs::last_write_time(draw.out / name), time);
}

}  // namespace
}  // namespace thew::tests
