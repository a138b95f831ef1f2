// SPDX-License-Identifier: Apache-2.0
// What commands print: where it can go, as JSON, and what they say of what is not theirs. Run by
// root, the commands are of a user who may not do everything.
#include <sys/resource.h>
#include <unistd.h>

#include <map>
#include <regex>
#include <set>

#include "tests/kill/bake_process.h"

namespace thew::tests {
namespace {

using Words = std::vector<std::string>;

struct Told {
  int code;
  std::string output, errors;
};

class Output : public BakeTest {
 protected:
  static void SetUpTestSuite() {
    BakeTest::SetUpTestSuite();
    fs::permissions(root_, fs::perms::all);  // for whom the commands become
    bake_ = root_ / "whole/bake.h5";
    for (const char* folder : {"locked", "one_muscle"}) {
      fs::copy(THEW_SOURCE_DIR "/tests/scenes/one_muscle", root_ / folder);
    }
    write_file("one_muscle/broken.toml", "\n[solvr]\n" + bytes_of(root_ / "one_muscle/scene.toml"));
    write_file("file", "");
    fs::copy(bake_, root_ / "locked/bake.h5");
    fs::permissions(root_ / "locked", fs::perms::none);
  }
  static void TearDownTestSuite() {
    fs::permissions(root_ / "locked", fs::perms::owner_all);
    BakeTest::TearDownTestSuite();
  }
  static void write_file(const std::string& name, const std::string& text) {
    std::ofstream(root_ / name) << text;
  }
  static std::string path(const std::string& name) { return root_ / name; }

  static Told run(const Words& words, const std::function<void()>& prepare = {}) {
    const fs::path output = root_ / "output";
    const auto ended =
        CommandProcess(words, [&] {
          if (chdir(root_.c_str()) != 0) _exit(126);
          dup2(open(output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666), STDOUT_FILENO);
          close_range(STDERR_FILENO + 1, ~0U, 0);
          if (prepare) prepare();
        }).wait();
    return {ended.code, bytes_of(output), ended.errors};
  }
  static nlohmann::json run_json(Words words, int code, const std::function<void()>& prepare = {}) {
    words.push_back("--json");
    const Told told = run(words, prepare);
    EXPECT_EQ(told.code, code) << words[0] << ": " << told.errors;
    const auto json = nlohmann::json::parse(told.output, nullptr, false);
    EXPECT_TRUE(json.is_object()) << words[0] << ": " << told.output;
    return json;
  }
  // With the rights of an ordinary user.
  static void become_nobody() {
    if (getuid() == 0 && (setgid(65534) != 0 || setuid(65534) != 0)) _exit(126);
  }
  // What each command prints, and how it may fail.
  static std::vector<Words> printing() {
    return {{"--version"},
            {"--help"},
            {"bake", "--help"},
            {"golden", "check", "--help"},
            {"bake", "one_muscle/scene.toml", "--out", "x", "--dry-run"},
            {"bake", "one_muscle/scene.toml", "--out", "x", "--dry-run", "--json"},
            {"inspect", "one_muscle/rig.urdf"},
            {"inspect", "one_muscle/rig.urdf", "--json"},
            {"compare", bake_, bake_},
            {"compare", bake_, bake_, "--json"},
            {"report", fs::path(bake_).parent_path()},
            {"report", fs::path(bake_).parent_path(), "--json", "-"},
            {"export", bake_, "x.obj", "--frames", "1", "--progress", "none"},
            {"export", bake_, "x.obj", "--frames", "1", "--progress", "none", "--json"},
            {"export", bake_, "x.obj", "--frames", "1", "--progress", "openjd"},
            {"render", bake_, "--out", "drawn", "--frames", "1", "--progress", "none", "--json"},
            {"bake", "one_muscle/scene.toml", "--out", "x", "--no-render", "--frames", "1",
             "--progress", "none", "--json"},
            {"bake", "one_muscle/scene.toml", "--out", "x", "--no-render", "--frames", "1",
             "--progress", "none", "--json", "--resume"}};
  }

  static inline std::string bake_;
};

TEST_F(Output, WhatCannotTakeItEndsWith4) {
  for (const Words& words : printing()) {
    const std::map<std::string, std::function<void()>> streams = {
        {"full", [] { dup2(open("/dev/full", O_WRONLY), STDOUT_FILENO); }},
        {"closed", [] { close(STDOUT_FILENO); }},
        {"all closed", [] { close(STDIN_FILENO), close(STDOUT_FILENO); }},
        {"for reading", [] { dup2(open("/dev/null", O_RDONLY), STDOUT_FILENO); }},
        {"a broken pipe", [] {
           int ends[2];
           if (pipe(ends) != 0) _exit(126);
           close(ends[0]);
           dup2(ends[1], STDOUT_FILENO);
         }}};
    for (const auto& [name, prepare] : streams) {
      const Told told = run(words, prepare);
      const std::string what = words[0] + " " + words.back() + ", " + name + ": " + told.errors;
      EXPECT_EQ(told.code, 4) << what;
      EXPECT_NE(told.errors.find("thew: standard output: cannot be written: "), std::string::npos)
          << what;
    }
    EXPECT_EQ(run(words).code, 0) << words[0];
    EXPECT_EQ(run(words, [] { close(STDERR_FILENO); }).code, 0) << words[0];
  }
}

TEST_F(Output, JsonIsOneDocumentOfEveryCommand) {
  const std::string scene = "one_muscle/scene.toml";
  const Words quiet = {"--progress", "none"};
  const auto with = [&](Words words) {
    words.insert(words.end(), quiet.begin(), quiet.end());
    return words;
  };
  const Words bake = with({"bake", scene, "--out", "json", "--frames", "1-2", "--no-render"});
  const auto report = run_json(bake, 0);
  EXPECT_EQ(report["frames"], (std::vector<int>{1, 2}));
  Words again = bake;
  again.push_back("--resume");
  EXPECT_EQ(run_json(again, 0)["hash"], report["hash"]);  // complete
  again.back() = "--dry-run";
  EXPECT_EQ(run_json(again, 0)["frames"], report["frames"]);
  EXPECT_FALSE(run_json(with({"bake", scene, "--out", "unmet", "--frames", "1-2", "--no-render",
                              "--set", "solver.volume=none", "--set", "bound.volume_error=1e-9"}),
                        1)["bounds"][0]["met"]);
  EXPECT_EQ(
      run_json(with({"render", "json/bake.h5", "--out", "drawn", "--frames", "1"}), 0)["files"]
          .size(),
      2u);
  EXPECT_EQ(run_json(with({"render", "json/bake.h5", "--out", "turned", "--frames", "1",
                           "--turntable", "2"}),
                     0)["files"]
                .size(),
            4u);
  EXPECT_EQ(run_json(with({"export", "json/bake.h5", "json.obj"}), 0)["files"].size(), 3u);
  EXPECT_TRUE(run_json({"compare", "json/bake.h5", "json/bake.h5"}, 0)["same"]);
  EXPECT_TRUE(run_json({"inspect", "json/bake.h5"}, 0)["sound"]);
  const auto night = run({"report", "json", "--json", "-"});
  EXPECT_EQ(nlohmann::json::parse(night.output)["bakes"]["done"], 1) << night.errors;
  const Words golden = with({"golden", "update", scene, "--golden", "golden", "--frames", "1"});
  EXPECT_TRUE(run_json(golden, 0)["rewritten"]);
  EXPECT_FALSE(run_json(golden, 0)["rewritten"]);
  EXPECT_TRUE(run_json(with({"golden", "check", scene, "--golden", "golden"}), 0)["same"]);
}

TEST_F(Output, JsonOfErrors) {
  const auto error = [](const Words& words, int code) {
    const auto json = run_json(words, code);
    EXPECT_TRUE(json.contains("error")) << json;
    EXPECT_EQ(json["error"]["code"], code) << json;
    return json["error"];
  };
  const auto key = error({"bake", "one_muscle/broken.toml", "--out", "x"}, 2);
  EXPECT_TRUE(key["file"].get<std::string>().ends_with("broken.toml")) << key;
  EXPECT_EQ(key["line"], 2);
  EXPECT_EQ(key["next"], "did you mean \"solver\"?");
  EXPECT_EQ(error({"bake", "none.toml", "--out", "x"}, 2)["file"], "none.toml");
  EXPECT_EQ(error({"inspect", "none.h5"}, 3)["file"], "none.h5");
  EXPECT_EQ(error({"bake", "one_muscle/scene.toml", "--out", "file/x"}, 4)["file"], "file/x");
  EXPECT_EQ(error({"bake", "one_muscle/scene.toml", "--ot", "x"}, 2)["next"],
            "did you mean --out?");
  EXPECT_EQ(error({"bke"}, 2)["next"], "did you mean bake?");
  EXPECT_EQ(error({"bake"}, 2)["message"], "SCENE is required");
  EXPECT_EQ(error({"bake", "x\xff.toml", "--out", "x"}, 2)["line"], nullptr);
  EXPECT_EQ(
      error({"bake", "one_muscle/scene.toml", "--out", "x", "--progress", "openjd"}, 2)["file"],
      nullptr);
  EXPECT_EQ(error({}, 2)["message"], "no command is given");
}

TEST_F(Output, WordsWrittenWronglyAreNamed) {
  const std::vector<std::pair<Words, std::string>> wrong = {
      {{"bke", "s.toml", "--out", "x"}, "\"bke\" is no command of thew; did you mean bake?"},
      {{"golden", "chek"}, "\"chek\" is no command of thew golden; did you mean check?"},
      {{"bake", "--fraems", "1", "s.toml"},
       "--fraems is no option of thew bake; did you mean --frames?"},
      {{"chart", "--stab=1"}, "--stab is no option of thew chart; did you mean --stability?"},
      {{"render", "a.h5", "--resume"}, "--resume is no option of thew render; thew render --help"},
      {{"--threads", "2", "bake", "s.toml"}, "--threads is no option of thew; thew --help"},
      {{"inspect", "a", "b"}, "\"b\" is a word too many; thew inspect --help"},
      {{"bake", "s.toml", "--out", ""}, "one of the command's words is empty; "},
      {{"paper", "--out", "x", "--progress", "jsn"}, "--progress jsn: did you mean json?"}};
  for (const auto& [words, message] : wrong) {
    const Told told = run(words);
    EXPECT_EQ(told.code, 2) << told.errors;
    EXPECT_TRUE(told.output.empty()) << told.output;
    EXPECT_EQ(told.errors.substr(0, 6 + message.size()), "thew: " + message);
  }
}

TEST_F(Output, WhatIsNotOursIsNoDefect) {
  const std::string locked = "locked", denied = "Permission denied",
                    scene = "one_muscle/scene.toml";
  const std::vector<std::tuple<int, Words, std::string>> cases = {
      {2, {"bake", "locked/scene.toml", "--out", "x"}, denied},
      {2, {"bake", locked, "--out", "x"}, "not a regular file"},
      {4, {"bake", scene, "--out", locked, "--no-render"}, denied},
      {4, {"bake", scene, "--out", "locked/x", "--no-render"}, denied},
      {4, {"bake", scene, "--out", "locked/x", "--no-render", "--resume"}, denied},
      {4, {"bake", scene, "--out", "file/x", "--no-render"}, "Not a directory"},
      {3, {"inspect", "locked/bake.h5"}, denied},
      {3, {"inspect", "locked/a.obj"}, denied},
      {3, {"inspect", locked}, "is a folder"},
      {3, {"compare", "locked/bake.h5", bake_}, denied},
      {3, {"compare", locked, locked}, denied},
      {4, {"compare", bake_, bake_, "--html", "locked/x.html"}, denied},
      {3, {"export", "locked/bake.h5", "x.obj"}, denied},
      {4, {"export", bake_, "locked/x.obj"}, denied},
      {4, {"export", bake_, "file/x.glb"}, "Not a directory"},
      {4, {"render", bake_, "--out", locked, "--frames", "1"}, denied},
      {4, {"render", bake_, "--out", "locked/x", "--frames", "1"}, denied},
      {3, {"golden", "check", scene, "--golden", locked}, denied},
      {4, {"golden", "update", scene, "--golden", "locked/x"}, denied},
      {4, {"chart", scene, "--out", locked}, denied},
      {4, {"chart", scene, "--out", "locked/x"}, denied},
      {4, {"paper", "--out", "locked/x"}, denied},
      {3, {"new", "locked/a.glb", "--out", "a.toml"}, denied},
      {4, {"new", "a.glb", "--out", "locked/a.toml"}, denied}};
  for (const auto& [code, words, message] : cases) {
    const Told told = run(words, become_nobody);
    const std::string what = words[0] + " " + words[1] + " " + words.back() + ": " + told.errors;
    EXPECT_EQ(told.code, code) << what;
    EXPECT_NE(told.errors.find(message), std::string::npos) << what;
    EXPECT_EQ(told.errors.find("defect"), std::string::npos) << what;
  }
  const Told told = run({"golden", "update", scene, "--golden", "g", "--frames", "1"},
                        [] { setenv("TMPDIR", "/nowhere", 1); });
  EXPECT_EQ(told.code, 4) << told.errors;
  EXPECT_NE(told.errors.find("set TMPDIR"), std::string::npos) << told.errors;
}

TEST_F(Output, FewProcessesFilesAndAFarmsNumbers) {
  const Words bake = {
      "bake", "one_muscle/scene.toml", "--out",      "few", "--frames", "1", "--threads",
      "8",    "--no-render",           "--progress", "none"};
  std::set<int> codes;
  for (const rlim_t processes : {1, 2, 3, 4, 5}) {  // its own among them
    const Told told = run(bake, [&] {
      setenv("ASAN_OPTIONS", "detect_leaks=0", 1);  // its search takes a process of its own
      become_nobody();
      const rlimit most{processes, processes};
      setrlimit(RLIMIT_NPROC, &most);
    });
    EXPECT_TRUE(told.code == 0 || told.code == 75) << told.errors;
    EXPECT_EQ(told.errors.find("defect"), std::string::npos) << told.errors;
    codes.insert(told.code);
    fs::remove_all(root_ / "few");
  }
  EXPECT_TRUE(codes.contains(75));  // with one process it cannot even read
  for (const rlim_t files : {5, 6, 7, 8, 9, 10, 12}) {
    const Told told = run(bake, [&] {
      const rlimit most{files, files};
      setrlimit(RLIMIT_NOFILE, &most);
    });
    EXPECT_TRUE(told.code == 0 || files < 8) << files << ": " << told.errors;
    EXPECT_EQ(told.errors.find("defect"), std::string::npos) << told.errors;
    fs::remove_all(root_ / "few");
  }
  for (const char* number : {"99999999999999999999", "1e400", "-3", "0", "", "many", "1000000"}) {
    const auto plan = run_json({"bake", "one_muscle/scene.toml", "--out", "x", "--dry-run"}, 0,
                               [&] { setenv("SLURM_CPUS_PER_TASK", number, 1); });
    const int threads = plan["threads"];
    EXPECT_GE(threads, 1) << number;
    EXPECT_LE(threads, static_cast<int>(std::max(1u, std::thread::hardware_concurrency())))
        << number;
  }
}

TEST_F(Output, OpenJobDescription) {
  const Told told = run({"bake", "one_muscle/scene.toml", "--out", "jd", "--no-render", "--frames",
                         "1-4", "--progress", "openjd"});
  EXPECT_EQ(told.code, 0) << told.errors;
  EXPECT_TRUE(told.output.starts_with("openjd_progress: 25\nopenjd_status: baking frame 1, "))
      << told.output;
  EXPECT_NE(told.output.find("openjd_progress: 100\n"), std::string::npos) << told.output;
}

// The options that a command's help lists.
std::set<std::string> options_in(const std::string& text) {
  std::set<std::string> options;
  static const std::regex kOption("--[a-z][a-z-]*");
  for (auto at = std::sregex_iterator(text.begin(), text.end(), kOption);
       at != std::sregex_iterator(); ++at) {
    options.insert(at->str());
  }
  return options;
}

// A message below the commands may reach any of them: it names no option. One of a command's own
// files names its options only.
TEST_F(Output, AdviceNamesOnlyOptionsOfItsCommand) {
  const std::vector<std::pair<std::string, std::vector<Words>>> commands_of = {
      {"tools/cli/bake_", {{"bake"}, {"render"}}},
      {"tools/cli/compare_", {{"compare"}}},
      {"tools/compare/", {{"compare"}}},
      {"tools/cli/export_", {{"export"}}},
      {"tools/export/", {{"export"}}},
      {"tools/cli/golden_", {{"golden", "update"}, {"golden", "check"}}},
      {"tools/compare/golden_", {{"golden", "update"}, {"golden", "check"}}},
      {"tools/cli/inspect_", {{"inspect"}}},
      {"tools/inspect/", {{"inspect"}}},
      {"tools/cli/report_", {{"report"}}},
      {"tools/night/", {{"report"}}},
      {"tools/cli/new_", {{"new"}}},
      {"tools/fit/", {{"new"}}},
      {"tools/cli/farm_", {{"farm"}}},
      {"tools/farm/", {{"farm"}, {"bake"}, {"render"}, {"export"}}},  // which it calls
      {"tools/lab/chart/", {{"chart"}}},
      {"tools/lab/paper/", {{"paper"}}}};
  // Places in a scene that the command line set; and what reads the option named.
  const std::map<std::string, std::set<std::string>> own = {
      {"sim/scene/toml.cpp", {"--set"}},
      {"sim/scene/toml.h", {"--set"}},
      {"sim/scene/reference.cpp", {"--set", "--keys"}},  // a page, no message
      {"tools/base/options.cpp", {"--frames", "--progress"}},
      {"tools/night/read_shot.cpp", {"--resume"}},  // of the commands that are to be run again
      {"tools/night/find_shots.cpp", {"--chunk"}},
      {"tools/farm/graph.cpp", {"--html"}},                   // of thew report
      {"tools/lab/chart/plot.cpp", {"--width", "--output"}},  // of rsvg-convert
      {"tools/cli/program_main.cpp",
       options_in(run({"bake", "--help"}).output + run({"--help"}).output)},
      {"tools/cli/thew.cpp",
       options_in(run({"bake", "--help"}).output + run({"new", "--help"}).output +
                  run({"inspect", "--help"}).output + run({"report", "--help"}).output)},
      {"tools/cli/self_description.cpp", {"--completion", "--out", "--progress"}},  // no message
      {"tools/python/module.cpp", {"--overwrite"}},  // which it takes out of messages
      {"tools/lab/base/table.cpp", {"--soft"}}};     // of its style sheet
  // What is no message of a command: the benches, and the page that says how its figures are
  // measured.
  const auto is_apart = [](const std::string& name) {
    return name.find("/thew_") != name.npos || name.starts_with("tools/lab/bench/") ||
           name.starts_with("tools/lab/results/");
  };
  std::map<Words, std::set<std::string>> helps;
  const auto help_of = [&](const Words& command) {
    if (!helps.contains(command)) {
      Words words = command;
      words.push_back("--help");
      helps[command] = options_in(run(words).output);
    }
    return helps.at(command);
  };
  static const std::regex kLiteral("\"(?:[^\"\\\\]|\\\\.)*\"");
  int seen = 0;
  for (const char* folder : {"rig", "muscles", "skin", "sim", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(THEW_SOURCE_DIR) / folder)) {
      const std::string name = fs::relative(entry.path(), THEW_SOURCE_DIR).string();
      const std::string ending = entry.path().extension();
      if ((ending != ".cpp" && ending != ".h") || is_apart(name)) continue;
      std::set<std::string> allowed = {"--help"};
      if (own.contains(name)) allowed.insert(own.at(name).begin(), own.at(name).end());
      for (const auto& [begin, commands] : commands_of) {
        if (!name.starts_with(begin)) continue;
        for (const Words& words : commands) {
          const std::set<std::string> options = help_of(words);
          allowed.insert(options.begin(), options.end());
        }
      }
      std::ifstream file(entry.path());
      for (std::string line; std::getline(file, line);) {
        for (auto at = std::sregex_iterator(line.begin(), line.end(), kLiteral);
             at != std::sregex_iterator(); ++at) {
          if (line.find("add_option") != line.npos || line.find("add_flag") != line.npos) continue;
          for (const std::string& option : options_in(at->str())) {
            ++seen;
            EXPECT_TRUE(allowed.contains(option)) << name << ": " << at->str();
          }
        }
      }
    }
  }
  EXPECT_GT(seen, 20);
  // All commands that write, since program_main.cpp names --overwrite to each of them.
  for (const Words& words : std::vector<Words>{{"bake"},
                                               {"render"},
                                               {"export"},
                                               {"new"},
                                               {"compare"},
                                               {"inspect"},
                                               {"report"},
                                               {"farm"},
                                               {"chart"},
                                               {"paper"},
                                               {"golden", "update"},
                                               {"golden", "check"}}) {
    EXPECT_TRUE(help_of(words).contains("--overwrite")) << words.back();
  }
}

}  // namespace
}  // namespace thew::tests
