// SPDX-License-Identifier: Apache-2.0
// The laboratory: what measures Thew and the methods that it is measured against. `thew chart` and
// `thew paper` become this program.
#include "tools/base/commit.h"
#include "tools/cli/program_main.h"
#include "tools/lab/chart/command.h"
#include "tools/lab/failure/command.h"
#include "tools/lab/paper/command.h"
#include "tools/lab/related/command.h"
#include "tools/lab/results/command.h"

namespace thew::tools {
namespace {

struct Arguments {
  bool quick = false, stability = false, related = false;
  std::filesystem::path cow;
  CLI::App *paper = nullptr, *chart = nullptr, *results = nullptr;
};

constexpr const char* kThreads = "0: all; what is timed runs on one";

CLI::App* add_command(CLI::App& app, const char* name, const char* what, const char* out,
                      CommandOptions& options) {
  CLI::App* command = app.add_subcommand(name, what);
  command->add_option("--out", options.out, out)->required();
  command->add_flag("--json", options.json, kJsonFlag);
  command->add_option("--progress", options.progress, kProgressWords);
  return command;
}

void declare(CLI::App& app, CommandOptions& options, Arguments& a) {
  app.description("The laboratory: measures Thew, and the methods that it is set against.");
  a.paper = add_command(app, "paper",
                        "runs the paper's experiments and sets its tables and figures beside ours",
                        "folder of the report", options);
  add_overwrite(*a.paper, options);
  a.paper->add_flag("--quick", a.quick, "within a minute: fewer frames, repetitions and elements");
  a.paper->add_option("--cow", a.cow, "a closed mesh, brought to the cow's 14,136 triangles")
      ->check(CLI::ExistingFile);
  a.paper->add_flag("--related", a.related,
                    "the methods that the paper names beside its own, side by side, instead; a "
                    "quarter of an hour, with --quick two minutes");
  a.chart = add_command(app, "chart",
                        "draws speed against accuracy of a scene's muscles, setting by setting",
                        "folder of the chart", options);
  a.chart->add_option("SCENE", options.input, "scene file, TOML")->required();
  add_overwrite(*a.chart, options);
  add_threads(*a.chart, options, kThreads);
  a.chart->add_flag("--stability", a.stability,
                    "maps of where each method fails instead, those of others too");
  a.results = add_command(
      app, "results", "measures every figure that is stated of Thew and writes them on one page",
      "Markdown file; what stands there is replaced", options);
  a.results->add_flag("--quick", a.quick,
                      "in three minutes: the arm, the paper and its related work, roughly");
  add_threads(*a.results, options, kThreads);
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  thew::tools::Arguments a;
  return thew::tools::program_main(
      argc, argv,
      {.commit = thew::tools::kCommit,
       .declare = [&](CLI::App& app,
                      thew::tools::CommandOptions& options) { declare(app, options, a); },
       .run =
           [&](thew::tools::CommandOptions& options, thew::tools::Call&) {
             if (*a.paper && a.related) return thew::tools::related_command(options, a.quick);
             if (*a.chart && a.stability) return thew::tools::stability_command(options);
             if (*a.results) return thew::tools::results_command(options, a.quick);
             return *a.paper ? thew::tools::paper_command(options, a.quick, a.cow)
                             : thew::tools::chart_command(options);
           }});
}
