// SPDX-License-Identifier: Apache-2.0
// The laboratory: what measures Thew and the methods that it is measured against. `thew chart` and
// `thew paper` become this program.
#include "tools/base/commit.h"
#include "tools/cli/program_main.h"
#include "tools/lab/chart/command.h"
#include "tools/lab/paper/command.h"

namespace thew::tools {
namespace {

struct Arguments {
  bool quick = false, stability = false;
  std::filesystem::path cow;
  CLI::App *paper = nullptr, *chart = nullptr;
};

CLI::App* add_paper(CLI::App& app, CommandOptions& options, bool& quick,
                    std::filesystem::path& cow) {
  CLI::App* command =
      app.add_subcommand("paper", "the paper's tables and figures, ours beside them");
  command->add_option("--out", options.out, "folder of the report")->required();
  command->add_flag("--json", options.json, kJsonFlag);
  add_overwrite(*command, options);
  command->add_flag("--quick", quick, "within a minute: fewer frames, repetitions and elements");
  command->add_option("--cow", cow, "a closed mesh, brought to the cow's 14,136 triangles")
      ->check(CLI::ExistingFile);
  command->add_option("--progress", options.progress, kProgressWords);
  return command;
}

CLI::App* add_chart(CLI::App& app, CommandOptions& options, bool& stability) {
  CLI::App* command = app.add_subcommand("chart", "speed against accuracy of a scene's muscles");
  command->add_option("SCENE", options.input, "scene file, TOML")->required();
  command->add_option("--out", options.out, "folder of the chart")->required();
  add_overwrite(*command, options);
  command->add_option("--threads", options.threads, "0: all; what is timed runs on one")
      ->check(CLI::Range(0, 1024));
  command->add_flag("--json", options.json, kJsonFlag);
  command->add_flag("--stability", stability, "maps of where each integrator fails instead");
  command->add_option("--progress", options.progress, kProgressWords);
  return command;
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  thew::tools::Arguments a;
  return thew::tools::program_main(
      argc, argv,
      {.commit = thew::tools::kCommit,
       .declare =
           [&](CLI::App& app, thew::tools::CommandOptions& options) {
             a.paper = thew::tools::add_paper(app, options, a.quick, a.cow);
             a.chart = thew::tools::add_chart(app, options, a.stability);
           },
       .run =
           [&](thew::tools::CommandOptions& options, thew::tools::Call&) {
             return *a.paper ? thew::tools::paper_command(options, a.quick, a.cow)
                             : thew::tools::chart_command(options, a.stability);
           }});
}
