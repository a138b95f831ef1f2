// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <nlohmann/json.hpp>

#include "tools/base/printing.h"
#include "tools/base/text.h"
#include "tools/cli/commands.h"
#include "tools/farm/engines.h"
#include "tools/render/program.h"

namespace thew::tools {
namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

void check_engine(const FarmChoice& choice, const CommandOptions& options) {
  const int engines = !choice.slurm.empty() + !choice.openjd.empty() + choice.local;
  if (engines > 1 || (engines == 0 && !options.dry_run)) {
    throw Error(ErrorCode::kUsage,
                "farm makes jobs of one engine; give --slurm DIR, --openjd DIR or --local");
  }
  if (choice.submit && choice.slurm.empty()) {
    throw Error(ErrorCode::kUsage,
                "--submit calls sbatch, which goes with --slurm DIR; Open Job Description's jobs "
                "are submitted by your render manager");
  }
}

double core_hours(const Graph& graph) {
  double seconds = 0.0;
  for (const Task& task : graph.tasks) seconds += task.seconds;
  return seconds * graph.threads / 3600.0;
}

ordered_json graph_as_json(const Graph& graph, const fs::path& program) {
  ordered_json tasks = ordered_json::array();
  for (const Task& task : graph.tasks) {
    std::vector<std::string> command = task.words, after;
    command.insert(command.begin(), program.string());
    for (const int other : task.after) {
      after.push_back(name_of(graph.tasks[static_cast<std::size_t>(other)]));
    }
    tasks.push_back({{"task", name_of(task)},
                     {"command", command},
                     {"after", after},
                     {"seconds", task.seconds},
                     {"memory_mib", task.memory_mib},
                     {"minutes", task.minutes}});
  }
  return {{"bakes", graph.bakes},
          {"complete", graph.done},
          {"core_hours", core_hours(graph)},
          {"tasks", tasks}};
}

// What is printed of files that were written.
std::vector<std::string> write_files(const Graph& graph, const Jobs& jobs, const fs::path& program,
                                     const FarmChoice& choice, bool overwrite) {
  std::vector<std::string> files;
  if (!choice.slurm.empty())
    files.push_back(write_slurm(graph, program, choice.slurm, overwrite).string());
  if (!choice.openjd.empty()) {
    for (const fs::path& file : write_openjd(graph, jobs, program, choice.openjd, overwrite)) {
      files.push_back(file.string());
    }
  }
  return files;
}

void submit(const std::string& script) {
  const int code = run_program({"bash", script});
  if (code == 0) return;
  throw Error(ErrorCode::kRetry,
              script + " ended with " + std::to_string(code) +
                  " and what it submitted is in submitted.txt beside it; run it by hand, it says "
                  "why and goes on");
}

}  // namespace

ExitCode farm_command(const CommandOptions& options, const FarmChoice& choice) {
  check_engine(choice, options);
  const fs::path program = fs::read_symlink("/proc/self/exe");
  const Jobs jobs = read_jobs(options.input, options.out);
  const Graph graph = plan_tasks(
      jobs, options.dry_run ? read_costs(jobs) : measure_costs(jobs, program, options.overwrite));
  const std::vector<std::string> files =
      options.dry_run ? std::vector<std::string>{}
                      : write_files(graph, jobs, program, choice, options.overwrite);
  if (!options.json) {
    print(std::to_string(graph.bakes) + " bakes, of which " + std::to_string(graph.done) +
          " are complete; " + std::to_string(graph.tasks.size()) + " tasks, " +
          readable(core_hours(graph)) + " core hours by the pilot\n");
    for (const std::string& file : files) print(file + "\n");
  }
  if (choice.submit && !options.dry_run) submit(files.front());
  ExitCode code = ExitCode::kDone;
  if (choice.local && !options.dry_run) {
    code = run_here(graph, program, jobs.out / "logs", thread_count(options.threads));
  }
  if (options.json) {  // last: where something fails, the error is the one document
    ordered_json json = graph_as_json(graph, program);
    if (!files.empty()) json["files"] = files;
    print_json(json);
  }
  return code;
}

}  // namespace thew::tools
