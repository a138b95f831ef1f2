// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/related/command.h"

#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "sim/cache/durable_file.h"
#include "tools/base/options.h"
#include "tools/base/printing.h"
#include "tools/base/progress.h"
#include "tools/lab/related/page.h"

namespace thew::tools {

ExitCode related_command(const CommandOptions& options, bool quick) {
  const auto begin = std::chrono::steady_clock::now();
  create_folders(options.out);
  const FolderLock lock(options.out);
  const auto place = [&](const std::string& name) {
    claim({options.out / name}, options.overwrite);
    return options.out / name;
  };
  place("related.html");
  Progress progress(parse_progress(options.progress, isatty(STDERR_FILENO) != 0), "comparing",
                    study_steps(quick), stderr);
  int steps = 0;
  const Study study = run_study(own_asset("paper"), own_asset("arm/arm.toml"), quick,
                                [&] { progress.step(++steps); });
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - begin;
  write_study(study, seconds.count(), place);
  const std::string page = (options.out / "related.html").string();
  if (options.json) {
    print_json({{"report", page}, {"claims", (options.out / "claims.csv").string()}});
  } else {
    print(page + "\n");
  }
  return ExitCode::kDone;
}

}  // namespace thew::tools
