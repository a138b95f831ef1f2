// SPDX-License-Identifier: Apache-2.0
// A scene file baked into a cache, with progress: bake_scene SCENE FOLDER
// Ends with 1 and one line that says what is wrong and what to do. A second run goes on.
#include <thew/thew.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 3) return std::fprintf(stderr, "usage: bake_scene SCENE FOLDER\n"), 2;
  try {
    const thew::Scene scene = thew::Scene::read(argv[1]);
    const auto show = [](const thew::BakeProgress& now) {
      return std::printf("frame %d, %d of %d\n", now.frame, now.done, now.of) > 0;
    };
    const auto cache = thew::bake(scene, argv[2], {.resume = true, .progress = show});
    std::printf("%s %s\n", cache.c_str(), thew::Bake(cache).contents().hash.c_str());
  } catch (const thew::Error& error) {
    return std::fprintf(stderr, "%s\n", error.what()), 1;
  }
}
