// SPDX-License-Identifier: Apache-2.0
// The hash of a bake, without the tools: hash_bake bake SCENE --frames FIRST-LAST --out DIR ...
// Other words of `thew bake` are let pass but --threads; the report holds the hash alone.
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include "sim/bake/bake.h"
#include "sim/scene/define_model.h"
#include "sim/scene/reader.h"

int main(int argc, char** argv) {
  std::string scene = argc > 2 ? argv[2] : "", frames, out;
  int threads = 1;
  for (int i = 3; i + 1 < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--frames") frames = argv[i + 1];
    if (word == "--out") out = argv[i + 1];
    if (word == "--threads") threads = std::atoi(argv[i + 1]);
  }
  try {
    const thew::sim::Model model = thew::sim::build_model(thew::sim::read_scene(scene));
    thew::sim::BakeOptions options{out, {}, threads, false};
    const int last = std::atoi(frames.substr(frames.find('-') + 1).c_str());
    for (int frame = std::atoi(frames.c_str()); frame <= last; ++frame) {
      options.frames.push_back(frame);
    }
    const thew::sim::BakeResult result =
        thew::sim::bake(model, options, [](const thew::sim::BakeFrame&) { return true; });
    std::ofstream(out + "/report.json") << "\"hash\": \"" << result.hash << "\"\n";
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
