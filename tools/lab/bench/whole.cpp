// SPDX-License-Identifier: Apache-2.0
#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>

#include "rig/types.h"
#include "tools/base/median.h"
#include "tools/base/temporary_folder.h"
#include "tools/lab/bench/benches.h"
#include "tools/render/frame_file.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* kStages[] = {"setup",   "settle", "rig",    "muscles", "contact", "skin",
                                   "measure", "write",  "render", "report",  "total"};

constexpr const char* kPicture = "picture, ms";

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

long pictures_in(const fs::path& folder) {
  if (!fs::is_directory(folder)) return 0;
  return std::count_if(fs::directory_iterator(folder), {}, [](const fs::directory_entry& file) {
    return read_frame_name(file.path().filename().string()).has_value();
  });
}

void bake(const std::string& scene, const fs::path& out, bool pictures, Bakes& bakes) {
  fs::remove_all(out);  // or pictures would be kept
  const double before = seconds_of_children();
  std::vector<std::string> words = {bakes.program.string(), "bake",        scene,       "--out",
                                    out.string(),           "--overwrite", "--threads", "1"};
  if (!pictures) words.push_back("--no-render");
  const int code = run_program(words);
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
  if (const long drawn = pictures_in(out / "frames"); drawn > 0) {
    for (auto* seconds : {&bakes.wall, &bakes.cpu}) {
      if (!(*seconds)["render"].empty()) {
        (*seconds)[kPicture].push_back(1e3 * (*seconds)["render"].back() / drawn);
      }
    }
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

std::string whole_bakes(const std::string& scene, const fs::path& against, int runs,
                        bool pictures) {
  std::vector<Bakes> builds = {{fs::read_symlink("/proc/self/exe").parent_path() / "thew", {}, {}}};
  if (!against.empty()) builds.push_back({against / "tools" / "thew", {}, {}});
  const TemporaryFolder folder("bench");
  for (int run = 0; run < runs; ++run) {
    for (Bakes& build : builds) bake(scene, folder.path() / "bake", pictures, build);
  }
  const Bakes &ours = builds.front(), &theirs = builds.back();
  const bool two = builds.size() > 1;
  std::string text = std::string("stage   ") + (pictures ? "   " : "") + "    wall, s    CPU, s";
  text += two ? "  |  other: wall    CPU  |  ratio: wall    CPU\n" : "\n";
  std::vector<const char*> rows(std::begin(kStages), std::end(kStages));
  if (pictures) rows.push_back(kPicture);
  for (const char* stage : rows) {
    char name[16];
    std::snprintf(name, sizeof name, pictures ? "%-11s" : "%-8s", stage);
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
