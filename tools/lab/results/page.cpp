// SPDX-License-Identifier: Apache-2.0
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <thread>

#include "tools/lab/results/results.h"

namespace thew::tools {
namespace {

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown processor";
}

std::string today() {
  char text[16];
  const std::time_t now = std::time(nullptr);
  std::strftime(text, sizeof text, "%Y-%m-%d", std::gmtime(&now));
  return text;
}

}  // namespace

double load_average() {
  double load[1] = {0.0};
  return getloadavg(load, 1) == 1 ? load[0] : 0.0;
}

ResultsHead results_head(const std::string& commit, bool quick) {
  ResultsHead head;
  head.date = today();
  head.processor =
      processor_name() + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
#ifdef __clang__
  head.compiler = "clang " __clang_version__;
#else
  head.compiler = "g++ " __VERSION__;
#endif
  head.commit = commit;
  head.load_before = load_average();
  head.quick = quick;
  return head;
}

const std::vector<std::string>& figure_head() {
  static const std::vector<std::string> kHead = {"what", "figure", "measured alone by",
                                                 "tested by"};
  return kHead;
}

std::string results_page(const ResultsHead& head, const std::vector<Table>& tables) {
  std::string page =
      "# Results\n\nWritten by `build/release/tools/thew-lab results --out "
      "tools/lab/results.md`; do not edit it by hand.\n\n";
  if (head.quick) {
    page +=
        "**This is a quick run (`--quick`): fewer frames and repetitions, and no chart, tolerance, "
        "bar, peers or map of failure. Its times are rough.**\n\n";
  }
  if (!head.missing.empty()) {
    page += "**Interrupted; not measured: " + head.missing + ".**\n\n";
  }
  page += "- Date: " + head.date + "\n- Processor: " + head.processor +
          "\n- Compiler: " + head.compiler + "\n- Commit: " + head.commit +
          "\n- Load average of the machine: " + number(head.load_before, 2) + " before, " +
          number(head.load_after, 2) +
          " after. Above 1 other processes ran before the measurement began, or beside it; times "
          "are then noisy.\n- Time taken: " +
          number(head.minutes, 2) +
          " minutes\n\nTimes are CPU time of one thread. What carries over to another machine is "
          "the ratio of two times taken in one run; the times beside it are context. SCENE is "
          "`assets/arm/arm.toml`, and the programs lie in `build/release/tools`.\n";
  for (const Table& table : tables) page += "\n" + markdown_of(table);
  return page;
}

}  // namespace thew::tools
