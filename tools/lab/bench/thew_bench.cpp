// SPDX-License-Identifier: Apache-2.0
//
// thew_bench SCENE: how fast the muscles are, and how right at that speed.
// thew_bench SCENE --tolerance MM [--set KEY=VALUE]...: what solver.tolerance chooses there, and
// its time beside that of the cheapest step that is the same for all muscles and as right. Exit
// code 1 where the choice misses the tolerance.
// thew_bench SCENE --copies OUT.svg: contact of 1 to 64 of it in one scene.
// thew_bench SCENE --skin: its skin layer as it comes, and with its volume kept.
// thew_bench SCENE --features: the scene over itself without its maps, activation, or props.
// One JSON object each (benches.h).
// thew_bench --whole SCENE [--against BUILD] [--runs N] [--pictures]: a table of the whole bake by
// stage, beside that of another build (its folder, such as ../other/build/release).
#include <cstdio>
#include <cstdlib>

#include "tools/lab/base/measures.h"
#include "tools/lab/bench/benches.h"

namespace thew::tools {
namespace {

constexpr int kRuns = 5;  // of which times are the medians

int show(const nlohmann::ordered_json& found) {
  std::printf("%s\n", found.dump(2).c_str());
  return 0;
}

// Whether `--whole` is asked for as it can be understood; then it is done.
bool show_whole(int argc, char** argv) {
  if (argc < 3 || std::string_view(argv[1]) != "--whole") return false;
  std::filesystem::path against;
  int runs = kRuns;
  bool pictures = false;
  for (int i = 3; i < argc; ++i) {
    const std::string_view word = argv[i];
    if (word == "--pictures") {
      pictures = true;
    } else if (word == "--against" && i + 1 < argc) {
      against = argv[++i];
    } else if (word == "--runs" && i + 1 < argc) {
      runs = std::atoi(argv[++i]);
    } else {
      return false;
    }
  }
  if (runs < 1) return false;
  std::fputs(whole_bakes(argv[2], against, runs, pictures).c_str(), stdout);
  return true;
}

int run(int argc, char** argv) {
  if (show_whole(argc, argv)) return 0;
  if (argc == 3 && std::string_view(argv[2]) == "--skin") return show(skin_price(argv[1], kRuns));
  if (argc == 3 && std::string_view(argv[2]) == "--features") {
    return show(price_of_features(argv[1], kRuns));
  }
  if (argc == 4 && std::string_view(argv[2]) == "--copies") {
    return show(contact_of_copies(argv[1], argv[3]));
  }
  std::vector<std::string> overrides;
  double tolerance = 0.0;
  bool understood = argc % 2 == 0;
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string word = argv[i];
    if (word == "--set") overrides.push_back(argv[i + 1]);
    if (word == "--tolerance") tolerance = std::atof(argv[i + 1]);
    understood = understood && (word == "--set" || word == "--tolerance");
  }
  if (!understood || (tolerance <= 0.0) != (argc == 2)) {
    std::fprintf(
        stderr,
        "usage: thew_bench SCENE.toml [--tolerance MM [--set KEY=VALUE]... | --copies OUT.svg | "
        "--skin | --features]\n"
        "       thew_bench --whole SCENE.toml [--against BUILD] [--runs N] [--pictures]\n");
    return 2;
  }
  if (tolerance <= 0.0) return show(speed_of(argv[1], kRuns));
  const nlohmann::ordered_json found = tolerance_of(argv[1], tolerance, overrides, kRuns);
  show(found);
  return found["error_mm"].get<double>() <= tolerance ? 0 : 1;
}

}  // namespace
}  // namespace thew::tools

int main(int argc, char** argv) {
  return thew::tools::run_or_tell("thew_bench", thew::tools::run, argc, argv);
}
