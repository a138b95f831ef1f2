// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>

#include <cstdio>
#include <fstream>
#include <map>

#include "rig/types.h"
#include "tools/base/median.h"
#include "tools/base/temporary_folder.h"
#include "tools/lab/bench/benches.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kStages[] = {"setup",   "settle", "rig",    "muscles", "contact", "skin",
                                   "measure", "write",  "render", "report",  "total"};

// One build's runs: seconds by stage.
struct Bakes {
  fs::path program;
  std::map<std::string, std::vector<double>> wall, cpu;
};

double seconds_of_children() {
  rusage usage{};
  ::getrusage(RUSAGE_CHILDREN, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void bake(const std::string& scene, const fs::path& out, Bakes& bakes) {
  const double before = seconds_of_children();
  const int code = run_program({bakes.program.string(), "bake", scene, "--out", out.string(),
                                "--overwrite", "--no-render", "--threads", "1"});
  const double spent = seconds_of_children() - before;
  std::ifstream file(out / "report.json");
  const json report = json::parse(file, nullptr, false);
  if ((code != 0 && code != 1) || !report.is_object() || !report.contains("seconds")) {
    throw Error(ErrorCode::kInput, bakes.program.string() + " bake " + scene + ": exit code " +
                                       std::to_string(code) + "; run it by hand to see why");
  }
  for (const char* stage : kStages) {
    bakes.wall[stage].push_back(report["seconds"][stage]);
    if (report.contains("cpu_seconds")) bakes.cpu[stage].push_back(report["cpu_seconds"][stage]);
  }
  bakes.cpu["total"].resize(bakes.wall["total"].size());
  bakes.cpu["total"].back() = spent;  // with what its children spent
}

std::string cell(const std::map<std::string, std::vector<double>>& seconds, const char* stage) {
  const auto found = seconds.find(stage);
  char text[32];
  if (found == seconds.end()) return "         -";
  std::snprintf(text, sizeof text, "%10.3f", median(found->second));
  return text;
}

std::string ratio(const std::map<std::string, std::vector<double>>& ours,
                  const std::map<std::string, std::vector<double>>& theirs, const char* stage) {
  const auto one = ours.find(stage), other = theirs.find(stage);
  char text[32];
  if (one == ours.end() || other == theirs.end() || !(median(other->second) > 0.0)) {
    return "       -";
  }
  std::snprintf(text, sizeof text, "%8.3f", median(one->second) / median(other->second));
  return text;
}

}  // namespace

std::string whole_bakes(const std::string& scene, const fs::path& against, int runs) {
  std::vector<Bakes> builds = {{fs::read_symlink("/proc/self/exe").parent_path() / "thew", {}, {}}};
  if (!against.empty()) builds.push_back({against / "tools" / "thew", {}, {}});
  const TemporaryFolder folder("bench");
  for (int run = 0; run < runs; ++run) {
    for (Bakes& build : builds) bake(scene, folder.path() / "bake", build);
  }
  const Bakes &ours = builds.front(), &theirs = builds.back();
  const bool two = builds.size() > 1;
  std::string text = "stage       wall, s    CPU, s";
  text += two ? "  |  other: wall    CPU  |  ratio: wall    CPU\n" : "\n";
  for (const char* stage : kStages) {
    char name[16];
    std::snprintf(name, sizeof name, "%-8s", stage);
    text += name + cell(ours.wall, stage) + cell(ours.cpu, stage);
    if (two) {
      text += "  |  " + cell(theirs.wall, stage) + cell(theirs.cpu, stage) + "  |  " +
              ratio(ours.wall, theirs.wall, stage) + ratio(ours.cpu, theirs.cpu, stage);
    }
    text += "\n";
  }
  return text;
}

}  // namespace thew::tools
